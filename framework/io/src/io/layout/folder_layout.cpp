// A file for each scan and a table of the IMU: HeLiPR, Boreas, FoMo and others.
#include <fmt/format.h>

#include <optional>

#include "cloud_form.hpp"
#include "rows.hpp"
#include "writers_of.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

class FolderLayoutWriter final : public LayoutWriter {
 public:
  FolderLayoutWriter(const Layout& layout, const LayoutPlace& place)
      : layout_(layout),
        place_(place),
        encoder_(layout.lidar, place.grid),
        sampler_(layout.reference),
        imu_(named(layout.files.at(1)), layout.imu.columns, ",", layout.imu.header, layout.imu.time_unit) {
    if (layout.reference.format == ReferenceFile::tum || layout.reference.format == ReferenceFile::csv) {
      reference_.emplace(layout.reference, named(layout.reference.file));
    }
  }

  void add_imu(const ImuSample& sample, TimeNs) override {
    const ImuSample told = as_told(layout_.imu, sample);
    imu_.add(told.t, [&](std::string_view column) {
      const int axis = column[1] - 'x';
      return column[0] == 'w' ? told.gyro[axis] : told.acc[axis];
    });
  }

  void add_sweep(const LidarPacket& simulated, TimeNs) override {
    const LidarPacket& sweep = as_told(layout_.lidar, simulated, scratch_);
    const std::vector<std::uint8_t>& data = encoder_.encode(sweep);
    const TimeNs stamp = moment_of(layout_.lidar.stamp, sweep.stamp, place_.grid.period);
    std::string name = filled_in(layout_.files.front(), "stamp", time_text(stamp, layout_.lidar.name_unit));
    name = filled_in(std::move(name), "index", fmt::format("{:06}", scans_++));
    const fs::path path = place_of(place_, name);
    const fs::path folder = path.parent_path().lexically_relative(place_.folder);
    if (files_.empty() || files_.back() != folder) files_.push_back(folder);
    AtomicFile file(path, true);
    file.write({reinterpret_cast<const char*>(data.data()), data.size()});
    file.close();
  }

  void add_reference(const StampedPose& T_W_I) override {
    if (!reference_) return;
    if (const auto pose = sampler_.take(T_W_I)) reference_->add(*pose);
  }

  void close() override {
    imu_.close();
    if (reference_) reference_->close();
  }

  const std::vector<fs::path>& files() const override { return files_; }

 private:
  fs::path named(const std::string& name) {
    fs::path path = place_of(place_, name);
    files_.push_back(path.lexically_relative(place_.folder));
    return path;
  }

  const Layout layout_;
  const LayoutPlace place_;
  std::vector<fs::path> files_;
  CloudEncoder encoder_;
  ReferenceSampler sampler_;
  RowFile imu_;
  std::optional<ReferenceFileWriter> reference_;
  LidarPacket scratch_;
  std::size_t scans_ = 0;
};

}  // namespace

std::unique_ptr<LayoutWriter> open_folder_layout(const Layout& layout, const LayoutPlace& place) {
  return std::make_unique<FolderLayoutWriter>(layout, place);
}

}  // namespace aslio::io
