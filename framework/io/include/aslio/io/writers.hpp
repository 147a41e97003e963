#pragma once
/// Writers. Each writes to a temporary name and renames on close(), so that no half-written file ever stands under a
/// final name; a failed write (full disk) throws DataError that names the path.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/core/types.hpp"

namespace aslio::io {

/// File that appears under its name at close(). Destroyed without close(): the temporary file is removed. That of a
/// process that was killed is removed by the next one to write the same name, an hour after its last change. A device
/// (/dev/stdout) is written to directly.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path, bool binary = false);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  void write(std::string_view text);
  /// Byte offset so far.
  std::uint64_t position() const { return written_; }
  /// Overwrites earlier bytes (headers whose counts are known at the end).
  void patch(std::uint64_t offset, std::string_view text);
  void close();
  /// The same, once its content is on the disk: for a file that tells that others are whole.
  void close_durably();
  const std::filesystem::path& path() const { return path_; }

 private:
  void close(bool durably);
  /// What close() then says, too: what could not be written is missing, whatever fits behind it.
  [[noreturn]] void give_up(const char* what);

  std::filesystem::path path_, temporary_;
  std::FILE* file_ = nullptr;
  std::uint64_t written_ = 0;
  int error_ = 0;  ///< errno of the first failure
};

/// One TUM line: `t tx ty tz qx qy qz qw`, %.9f seconds exact to the nanosecond, quaternion with w >= 0.
std::string tum_line(const StampedPose& pose);
/// One KITTI line: the 12 numbers of the 3x4 matrix.
std::string kitti_line(const Pose& pose);
void write_tum(const std::filesystem::path& path, std::span<const StampedPose> poses);
void write_kitti(const std::filesystem::path& path, std::span<const StampedPose> poses);

/// Times that are read from text lie within +-this [ns], 1824 to 2115: so the difference of any two fits into 63 bits.
inline constexpr TimeNs kFarthestTime = 4'600'000'000 * kSecond;
inline constexpr bool is_time(TimeNs t) { return t >= -kFarthestTime && t <= kFarthestTime; }

/// Reads TUM. Post: not empty, times strictly increase. Throws DataError with file:line and the offending text.
std::vector<StampedPose> read_tum(const std::filesystem::path& path);

/// Streams points to a map file: .ply (binary little endian) or .pcd (binary). Nothing is kept in memory.
class MapWriter {
 public:
  virtual ~MapWriter() = default;
  virtual void add(const Eigen::Vector3f& p_W, float intensity) = 0;
  virtual void close() = 0;
};
/// By extension; throws ConfigError for another one.
std::unique_ptr<MapWriter> open_map_writer(const std::filesystem::path& path);

}  // namespace aslio::io
