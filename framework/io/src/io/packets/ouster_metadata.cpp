#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aslio/core/errors.hpp"
#include "aslio/io/json.hpp"
#include "ouster.hpp"

namespace aslio::io::packets {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<OusterProfile, 5> kProfiles{
    {{"LEGACY", 0, 16, 12, 4, 0, 0xFFFFF, 0, 4, false, true},
     {"RNG19_RFL8_SIG16_NIR16", 32, 12, 12, 0, 32, 0x7FFFF, 0, 4, false, false},
     {"RNG19_RFL8_SIG16_NIR16_DUAL", 32, 12, 16, 0, 32, 0x7FFFF, 0, 3, true, false},
     {"RNG15_RFL8_NIR8", 32, 12, 4, 0, 32, 0x7FFF, 3, 2, false, false},
     {"RNG15_RFL8_NIR8_DUAL", 32, 12, 8, 0, 32, 0x7FFF, 3, 2, true, false}}};

/// Reads one sensor's metadata. Firmware of different age has the same keys at different depths.
class MetadataReader {
 public:
  MetadataReader(const std::string& where, const Json& root) : where_(where), root_(root) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(
        fmt::format("{}: {}; name the metadata of this sensor (JSON, as the sensor and Ouster's tools write "
                    "it) by `lidar_metadata` of the sensor file",
                    where_, what));
  }

  /// Null where there is none.
  const Json* find(const char* key) const {
    if (const auto at = root_.find(key); at != root_.end()) return &*at;
    for (const char* group : {"data_format", "lidar_data_format", "beam_intrinsics", "lidar_intrinsics",
                              "imu_intrinsics", "sensor_info", "config_params"}) {
      const auto part = root_.find(group);
      if (part == root_.end() || !part->is_object()) continue;
      if (const auto at = part->find(key); at != part->end()) return &*at;
    }
    return nullptr;
  }

  std::string text(const char* key, const std::string& otherwise) const {
    const Json* value = find(key);
    return value != nullptr && value->is_string() ? value->get<std::string>() : otherwise;
  }

  std::size_t count(const char* key, std::size_t otherwise, std::size_t most) const {
    const Json* value = find(key);
    if (value == nullptr) return otherwise;
    const double number = value->is_number() ? value->get<double>() : -1;
    if (!(number >= 1) || number > static_cast<double>(most)) {
      fail(fmt::format("`{}` is {}, where 1 to {} can be", key, shown(*value), most));
    }
    return static_cast<std::size_t>(number);
  }

  double number(const char* key, double otherwise) const {
    const Json* value = find(key);
    return value == nullptr ? otherwise : usable(key, *value);
  }

  std::vector<double> numbers(const char* key, bool required) const {
    const Json* value = find(key);
    if (value == nullptr && !required) return {};
    if (value == nullptr || !value->is_array()) fail(fmt::format("there is no array `{}`", key));
    std::vector<double> all;
    for (const Json& one : *value) all.push_back(usable(key, one));
    return all;
  }

  /// A 4x4 matrix row by row, in mm; the identity where there is none.
  Pose pose(const char* key) const {
    Pose T;
    const std::vector<double> v = numbers(key, false);
    if (v.empty()) return T;
    if (v.size() != 16) fail(fmt::format("`{}` has {} numbers, not 16", key, v.size()));
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) T.R(row, column) = v[static_cast<std::size_t>(4 * row + column)];
      T.p[row] = 1e-3 * v[static_cast<std::size_t>(4 * row + 3)];
    }
    if ((T.R.transpose() * T.R - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-3) {
      fail(fmt::format("`{}` holds no rotation", key));
    }
    return T;
  }

 private:
  /// Of an angle, a length in mm, a part of a matrix.
  double usable(const char* key, const Json& value) const {
    constexpr double kMost = 1e4;
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (std::isfinite(number) && std::abs(number) <= kMost) return number;
    fail(fmt::format("`{}` holds {}, no number that can be used", key, shown(value)));
  }

  static std::string shown(const Json& value) {
    return value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 60);
  }

  const std::string& where_;
  const Json& root_;
};

const OusterProfile& profile_of(const MetadataReader& reader) {
  const std::string name = reader.text("udp_profile_lidar", "LEGACY");
  for (const OusterProfile& profile : kProfiles) {
    if (profile.name == name) return profile;
  }
  std::vector<std::string_view> names;
  for (const OusterProfile& profile : kProfiles) names.push_back(profile.name);
  reader.fail(fmt::format("its LiDAR packets are of profile {}, where {} can be read", name, fmt::join(names, ", ")));
}

/// 0 for a serial number that is none.
std::uint64_t serial_of(const std::string& text) {
  std::uint64_t serial = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), serial);
  return error == std::errc{} && end == text.data() + text.size() ? serial : 0;
}

/// "1024x10" tells columns per frame, for firmware that knows no data format.
std::size_t columns_of_mode(const std::string& mode) {
  std::size_t columns = 0;
  for (const char c : mode.substr(0, 5)) {
    if (c < '0' || c > '9') break;
    columns = 10 * columns + static_cast<std::size_t>(c - '0');
  }
  return columns;
}

}  // namespace

OusterMetadata parse_ouster_metadata(const std::string& where, std::string_view json) {
  const Json root = parse_json(json).value_or(Json());
  const MetadataReader reader(where, root);
  if (!root.is_object()) reader.fail("the metadata is no JSON object");
  constexpr double kRadians = std::numbers::pi / 180;
  constexpr std::size_t kMostColumns = 8192, kMostPerPacket = 128, kMostRows = 256;
  OusterMetadata metadata;
  metadata.profile = &profile_of(reader);
  metadata.product = reader.text("prod_line", "sensor");
  metadata.serial = serial_of(reader.text("prod_sn", ""));
  for (const double deg : reader.numbers("beam_altitude_angles", true)) metadata.altitudes.push_back(kRadians * deg);
  for (const double deg : reader.numbers("beam_azimuth_angles", true)) metadata.azimuths.push_back(kRadians * deg);
  metadata.rows = reader.count("pixels_per_column", metadata.altitudes.size(), kMostRows);
  metadata.columns_per_packet = reader.count("columns_per_packet", 16, kMostPerPacket);
  metadata.columns_per_frame =
      reader.count("columns_per_frame", columns_of_mode(reader.text("lidar_mode", "")), kMostColumns);
  if (metadata.columns_per_frame == 0) reader.fail("neither `columns_per_frame` nor `lidar_mode` tells the columns");
  if (metadata.rows == 0 || metadata.altitudes.size() != metadata.rows || metadata.azimuths.size() != metadata.rows) {
    reader.fail(fmt::format("there are {} altitude and {} azimuth angles for {} rows", metadata.altitudes.size(),
                            metadata.azimuths.size(), metadata.rows));
  }
  const std::vector<double> beam = reader.numbers("beam_to_lidar_transform", false);
  const double radius = reader.number("lidar_origin_to_beam_origin_mm", 0);
  metadata.beam_x = 1e-3 * (beam.size() == 16 ? beam[3] : radius);
  metadata.beam_z = 1e-3 * (beam.size() == 16 ? beam[11] : 0);
  metadata.T_sensor_lidar = reader.pose("lidar_to_sensor_transform");
  metadata.T_sensor_imu = reader.pose("imu_to_sensor_transform");
  metadata.legacy_imu = reader.text("udp_profile_imu", "LEGACY") == "LEGACY";
  return metadata;
}

}  // namespace aslio::io::packets
