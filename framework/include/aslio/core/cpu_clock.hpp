#pragma once

#include <ctime>

namespace aslio {

/// CPU time of the calling thread [s]. For reports only: no decision may depend on it.
inline double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Adds the CPU time between construction and destruction to `total`.
class CpuTimer {
 public:
  explicit CpuTimer(double& total) : total_(total), start_(thread_cpu_seconds()) {}
  ~CpuTimer() { total_ += thread_cpu_seconds() - start_; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& total_;
  double start_;
};

}  // namespace aslio
