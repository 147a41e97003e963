#pragma once
/// The recordings of ASLIO_RECORDINGS_DIR, unpacked once into the build folder and shared by all tests.

#include <filesystem>
#include <string>

namespace aslio::test {

/// A file or folder of ASLIO_RECORDINGS_DIR. Throws std::runtime_error when it is missing.
std::filesystem::path recorded(const std::filesystem::path& name);

/// The bag of avia_corridor. Both throw std::runtime_error when the recording is missing or cannot be unpacked, and may
/// be called by several processes at once.
std::filesystem::path unpacked_avia();
/// Root folder of a KITTI raw drive of 2011_09_26: "0005", or "0013" (its first 60 scans).
std::filesystem::path unpacked_kitti(const std::string& drive = "0005");

}  // namespace aslio::test
