#include "io/folder_fixture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace aslio::io::test {
namespace {

constexpr int kPoints = 40;

std::string header_of(const ScanFolder& folder) {
  if (folder.extension == ".pcd") {
    return fmt::format(
        "VERSION 0.7\nFIELDS {}\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 1\nWIDTH {}\nHEIGHT 1\nPOINTS {}\n"
        "DATA binary\n",
        folder.columns, kPoints, kPoints);
  }
  if (folder.extension == ".ply") {
    return fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float "
        "z\n"
        "property float intensity\nproperty float time\nproperty float ring\nend_header\n",
        kPoints);
  }
  return {};
}

}  // namespace

void ScanFolder::write(const std::filesystem::path& root) const {
  std::filesystem::create_directories(root / lidar_folder);
  std::filesystem::create_directories((root / imu_file).parent_path());
  const auto width = static_cast<std::size_t>(1 + std::count(columns.begin(), columns.end(), ' '));
  for (int k = 0; k < 10; ++k) {
    const TimeNs stamp = start + k * kSecond / 10;
    const std::string stem = counted ? std::to_string(k) : name ? name(stamp) : std::to_string(stamp);
    std::ofstream file(root / lidar_folder / (stem + extension), std::ios::binary);
    file << header_of(*this);
    for (int i = 0; i < kPoints; ++i) {
      const std::vector<float> point{5.0F + static_cast<float>(k + i), 1, -0.5F, 7, 0.0025F * static_cast<float>(i),
                                     static_cast<float>(i % 16)};
      file.write(reinterpret_cast<const char*>(point.data()), static_cast<std::streamsize>(4 * width));
    }
  }
  std::ofstream imu(root / imu_file);
  const char separator = imu_header.find(',') != std::string::npos || imu_header.empty() ? ','
                         : imu_header.find(';') != std::string::npos                     ? ';'
                                                                                         : ' ';
  if (!imu_header.empty()) imu << imu_header << '\n';
  for (int i = 0; i < 100; ++i) {
    const TimeNs t = start + imu_shift + i * kSecond / 100;
    imu << (imu_time ? imu_time(t) : std::to_string(t));
    for (const char* value : {"0.01", "0.02", "0.03", "0.1", "0.2", "9.8"}) imu << separator << value;
    imu << '\n';
  }
}

}  // namespace aslio::io::test
