#include <fmt/format.h>

#include <array>
#include <bit>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::io {
namespace {

static_assert(std::endian::native == std::endian::little, "map files are written in host order");

/// Ten digits hold any count; leading zeros keep the header's length when the count is filled in at the end.
std::string ply_header(std::uint64_t count) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {:010d}\nproperty float x\nproperty float y\n"
      "property float z\nproperty float intensity\nend_header\n",
      count);
}

std::string pcd_header(std::uint64_t count) {
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\n"
      "COUNT 1 1 1 1\nWIDTH {0:010d}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0:010d}\nDATA binary\n",
      count);
}

class BinaryMapWriter final : public MapWriter {
 public:
  using Header = std::string (*)(std::uint64_t);

  BinaryMapWriter(const std::filesystem::path& path, Header header) : file_(path, true), header_(header) {
    file_.write(header_(0));
  }
  void add(const Eigen::Vector3f& p_W, float intensity) override {
    const std::array<float, 4> record{p_W.x(), p_W.y(), p_W.z(), intensity};
    file_.write({reinterpret_cast<const char*>(record.data()), sizeof(record)});
    ++count_;
  }
  void close() override {
    file_.patch(0, header_(count_));
    file_.close();
  }

 private:
  AtomicFile file_;
  Header header_;
  std::uint64_t count_ = 0;
};

}  // namespace

std::unique_ptr<MapWriter> open_map_writer(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".ply") return std::make_unique<BinaryMapWriter>(path, &ply_header);
  if (extension == ".pcd") return std::make_unique<BinaryMapWriter>(path, &pcd_header);
  throw ConfigError(fmt::format("{}: a map is written as .ply or .pcd, not '{}'", path.string(), extension));
}

}  // namespace aslio::io
