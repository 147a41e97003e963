#pragma once

#include <ctime>

namespace aslio {

/// CPU time of the calling thread [s]. For reports only: no decision may depend on it.
inline double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Adds the CPU time between construction and destruction to `total`; where another timer runs around this one, takes
/// it off that one's total, so that no time counts twice.
class CpuTimer {
 public:
  explicit CpuTimer(double& total) : total_(total), start_(thread_cpu_seconds()) {}
  CpuTimer(double& total, double& around) : total_(total), around_(&around), start_(thread_cpu_seconds()) {}
  ~CpuTimer() {
    const double spent = thread_cpu_seconds() - start_;
    total_ += spent;
    if (around_ != nullptr) *around_ -= spent;
  }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& total_;
  double* around_ = nullptr;
  double start_;
};

}  // namespace aslio
