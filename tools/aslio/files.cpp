#include "files.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"

namespace aslio::cli {

CheckedFile read_checked(const std::filesystem::path& file, const config::StageLookup& stages) {
  const config::FileKind kind = config::peek_kind(file);
  switch (kind) {
    case config::FileKind::pipeline:
      return {kind, config::load<pipeline::PipelineConfig>(file, kind, stages).resolved};
    case config::FileKind::sensor:
      return {kind, config::load<io::SensorConfig>(file, kind, stages).resolved};
    default:
      throw ConfigError(fmt::format("{}: this version cannot read a {} file; it reads pipeline and sensor files",
                                    file.string(), config::name(kind)));
  }
}

}  // namespace aslio::cli
