#pragma once
/// What a stage under test is built with: one thread unless told, a default sensor, and a log that can be read.

#include <spdlog/sinks/ostream_sink.h>

#include <memory>
#include <sstream>
#include <string>

#include "aslio/stages/build_context.hpp"

namespace aslio::test {

class BuildEnvironment {
 public:
  explicit BuildEnvironment(int threads = 1) : exec_(threads) {}

  SensorModel sensor;
  std::uint64_t order_seed = 0;

  BuildContext context() { return {.exec = exec_, .sensor = sensor, .log = log_, .order_seed = order_seed}; }
  std::string logged() {
    log_->flush();
    return text_.str();
  }

 private:
  exec::Executor exec_;
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> log_ =
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_));
};

}  // namespace aslio::test
