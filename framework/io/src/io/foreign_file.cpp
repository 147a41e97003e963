#include "foreign_file.hpp"

#include <fmt/format.h>

#include <array>

namespace aslio::io {

namespace {

using namespace std::string_view_literals;

struct Format {
  std::string_view magic, what;
};

constexpr std::array kPacked{Format{"\xFD"
                                    "7zXZ"sv,
                                    "xz -dk"},
                             Format{"\x1F\x8B"sv, "gunzip -k"}, Format{"BZh"sv, "bunzip2 -k"},
                             Format{"\x28\xB5\x2F\xFD"sv, "zstd -dk"}, Format{"PK\x03\x04"sv, "unzip"}};

constexpr std::string_view kScan = "one scan; give the folder that holds all scans, with a table of the IMU";
constexpr std::string_view kCloud = "a point cloud without the times of a recording; give the recording it was made of";
constexpr std::array kFormats{
    Format{"#ROSBAG V1"sv, "a bag of format 1; convert it with `rosbag fix`"},
    Format{"SQLite format 3"sv, "a rosbag2 database, not a ROS1 bag"},
    Format{"\x89MCAP"sv, "an MCAP file, not a ROS1 bag"},
    Format{"version https://git-lfs"sv, "a pointer of Git LFS, not the file itself: fetch it with `git lfs pull`"},
    Format{"# .PCD"sv, kScan},
    Format{"VERSION .7"sv, kScan},
    Format{"VERSION 0.7"sv, kScan},
    Format{"ply\n"sv, kScan},
    Format{"ply\r\n"sv, kScan},
    Format{"LASF"sv, kCloud},
    Format{"ASTM-E57"sv, kCloud},
    Format{"\x89HDF"sv, "an HDF5 file; convert it to an MCAP file, or to a folder of scans with a table of the IMU"}};

/// Version 1 has IMU data, version 2 has points alone.
std::string livox_file(std::string_view head) {
  constexpr std::size_t kVersion = 16;  // of four bytes, the first is the major one
  const bool second = head.size() > kVersion && head[kVersion] == '\x02';
  return second ? "an LVX2 file of Livox, which has points and no IMU data: record the topics of the driver in a bag"
                : "an LVX file of Livox: convert it to a bag with the `lvx_to_rosbag` of livox_ros_driver";
}

}  // namespace

std::string foreign_format(std::string_view head) {
  for (const Format& packed : kPacked) {
    if (head.starts_with(packed.magic))
      return fmt::format("compressed as a whole; unpack it first: `{} FILE`", packed.what);
  }
  if (head.starts_with("livox_tech")) return livox_file(head);
  for (const Format& format : kFormats) {
    if (head.starts_with(format.magic)) return std::string(format.what);
  }
  return "its first bytes are those of no known recording: a ROS1 bag (.bag), an MCAP file (.mcap), a rosbag2 database "
         "(.db3), a network capture (.pcap, .pcapng); scans in files are given as their folder";
}

}  // namespace aslio::io
