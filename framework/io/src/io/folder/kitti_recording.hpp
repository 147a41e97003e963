#pragma once

#include "aslio/io/source.hpp"
#include "folder_recording.hpp"

namespace aslio::io {

/// `folder` as found by find_kitti_drive(). With a sensor file, its extrinsic is compared with the drive's.
FolderRecording kitti_recording(const std::filesystem::path& folder, const SensorConfig& sensor);

}  // namespace aslio::io
