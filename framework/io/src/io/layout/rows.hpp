#pragma once
/// Tables of numbers, and the reference among them.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/io/layout_writer.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::io {

/// A time in a unit: seconds with nine decimals, others as whole numbers.
std::string time_text(TimeNs t, TimeUnit unit);

/// A table with a role for each column, and behind `=` its name in the header. The roles t, sec, nsec, count and - are
/// of every table.
class RowFile {
 public:
  RowFile(const std::filesystem::path& path, std::vector<std::string> columns, std::string separator, bool header,
          TimeUnit unit);
  /// `number` gives the value of any other column.
  void add(TimeNs t, const std::function<double(std::string_view)>& number);
  void close() { file_.close(); }

 private:
  AtomicFile file_;
  std::vector<std::string> roles_;
  std::string separator_, line_;
  TimeUnit unit_;
  std::uint64_t count_ = 0;
};

/// The poses of a reference that its rate asks for, in its frame and world.
class ReferenceSampler {
 public:
  explicit ReferenceSampler(const ReferenceLayout& layout);
  /// Nothing between two samples.
  std::optional<StampedPose> take(const StampedPose& T_W_I);

 private:
  TimeNs period_, offset_;
  bool positions_only_;
  Pose T_imu_reference_;
  Vec3 origin_;
  std::optional<TimeNs> first_;
  std::int64_t taken_ = 0;
};

/// A reference in a file of its own.
class ReferenceFileWriter {
 public:
  ReferenceFileWriter(const ReferenceLayout& layout, const std::filesystem::path& path);
  void add(const StampedPose& T_W_reference);
  void close();

 private:
  std::unique_ptr<AtomicFile> tum_;
  std::unique_ptr<RowFile> table_;
};

/// The path of a file of the layout, whose folder is created. Throws DataError.
std::filesystem::path place_of(const LayoutPlace& place, const std::string& name);

}  // namespace aslio::io
