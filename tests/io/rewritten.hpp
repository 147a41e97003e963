#pragma once
/// Recordings in other containers, and what their sources yield, as text that can be compared.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "aslio/io/message_writer.hpp"
#include "aslio/io/source.hpp"
#include "io/mcap_fixture.hpp"

namespace aslio::io::test {

/// Every measurement with all its bits: one line each.
std::vector<std::string> measurements(MeasurementSource& source);
/// SHA-256 of those of the IMU and of the LiDAR, for long recordings: messages of one time may come in either order.
std::string digest(MeasurementSource& source);

/// A PointCloud2 of 40 points with times in seconds, the layout of a Velodyne driver.
std::vector<std::uint8_t> cloud_message(TimeNs stamp);

/// All messages as CDR; closes the writer.
void rewrite(const std::filesystem::path& bag, MessageWriter& writer);

/// An MCAP file of ROS1 messages or of CDR.
std::unique_ptr<MessageWriter> mcap_writer(const std::filesystem::path& path, const McapOptions& options);

/// A ROS1 bag for each topic, by its name.
void split_by_topic(const std::filesystem::path& bag, const std::filesystem::path& folder);

std::vector<std::uint8_t> packed_zstd(const std::vector<std::uint8_t>& bytes);

}  // namespace aslio::io::test
