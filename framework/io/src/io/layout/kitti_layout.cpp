// A raw drive of KITTI: scans of a turn each from the rear over the left, and a packet of the OXTS for each sample.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "cloud_form.hpp"
#include "rows.hpp"
#include "writers_of.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

/// `2011-09-26 13:04:32.335337762`
std::string date_text(TimeNs t) {
  const std::chrono::sys_seconds whole{std::chrono::seconds{t / kSecond}};
  const auto day = std::chrono::floor<std::chrono::days>(whole);
  const std::chrono::year_month_day date{day};
  const auto seconds = (whole - day).count();
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02}.{:09}\n", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), seconds / 3600,
                     seconds / 60 % 60, seconds % 60, t % kSecond);
}

/// Where the packets of the OXTS go: those of 100 Hz lie in the drive that is not synchronised.
std::string oxts_of(const std::string& drive) {
  constexpr std::string_view kSync = "_sync";
  if (!drive.ends_with(kSync)) return drive;
  return drive.substr(0, drive.size() - kSync.size()) + "_extract";
}

/// Latitude and longitude [deg] of a position on the sphere that the development kit of KITTI takes.
std::pair<double, double> on_earth(const Vec3& p) {
  constexpr double kRadius = 6378137, kLatitude = 49.0, kLongitude = 8.4, kDegrees = 180 / std::numbers::pi;
  const double scale = std::cos(kLatitude / kDegrees);
  return {kLatitude + p.y() / kRadius * kDegrees, kLongitude + p.x() / (kRadius * scale) * kDegrees};
}

class KittiLayoutWriter final : public LayoutWriter {
 public:
  KittiLayoutWriter(const Layout& layout, const LayoutPlace& place)
      : layout_(layout),
        place_(place),
        drive_(layout.files.front()),
        oxts_(oxts_of(drive_) + "/oxts"),
        sampler_(layout.reference),
        scans_(named(drive_ + "/velodyne_points/timestamps.txt")),
        begins_(named(drive_ + "/velodyne_points/timestamps_start.txt")),
        ends_(named(drive_ + "/velodyne_points/timestamps_end.txt")),
        packets_(named(oxts_ + "/timestamps.txt")) {
    write_calibration();
    if (layout.reference.format == ReferenceFile::tum || layout.reference.format == ReferenceFile::csv) {
      reference_.emplace(layout.reference, named(layout.reference.file));
    }
  }

  void add_imu(const ImuSample& simulated, TimeNs) override {
    const ImuSample sample = as_told(layout_.imu, simulated);
    packets_.write(date_text(sample.t));
    const auto [latitude, longitude] = on_earth(last_pose_.p);
    const Mat3& R = last_pose_.R;
    const double roll = std::atan2(R(2, 1), R(2, 2)), pitch = -std::asin(std::clamp(R(2, 0), -1.0, 1.0));
    const double yaw = std::atan2(R(1, 0), R(0, 0));
    const Vec3 level = R * sample.acc;
    AtomicFile file(place_of(place_, fmt::format("{}/data/{:010}.txt", oxts_, samples_++)));
    // Velocities, accuracies and the state of the receiver are not simulated: 0.
    file.write(fmt::format("{} {} {} {} {} {} 0 0 0 0 0 {} {} {} {} {} {} {} {} {} {} {} {} 0 0 0 0 0 0 0\n", latitude,
                           longitude, last_pose_.p.z(), roll, pitch, yaw, sample.acc.x(), sample.acc.y(),
                           sample.acc.z(), level.x(), level.y(), level.z(), sample.gyro.x(), sample.gyro.y(),
                           sample.gyro.z(), sample.gyro.x(), sample.gyro.y(), sample.gyro.z()));
    file.close();
  }

  /// A scan ends half a period behind the start of a sweep: where the head looks to the rear.
  void add_sweep(const LidarPacket& simulated, TimeNs) override {
    const LidarPacket& sweep = as_told(layout_.lidar, simulated, scratch_);
    const TimeNs rear = moment_of(SweepMoment::middle, sweep.stamp, place_.grid.period);
    const auto behind = std::find_if(sweep.points.begin(), sweep.points.end(),
                                     [rear](const TimedPoint& point) { return point.t > rear; });
    scan_.insert(scan_.end(), sweep.points.begin(), behind);
    if (begin_) write_scan(*begin_, rear);
    scan_.assign(behind, sweep.points.end());
    begin_ = rear;
  }

  void add_reference(const StampedPose& T_W_I) override {
    last_pose_ = T_W_I.T;
    if (!reference_) return;
    if (const auto pose = sampler_.take(T_W_I)) reference_->add(*pose);
  }

  void close() override {
    for (AtomicFile* file : {&scans_, &begins_, &ends_, &packets_}) file->close();
    if (reference_) reference_->close();
  }

  const std::vector<fs::path>& files() const override { return files_; }

 private:
  fs::path named(const std::string& name) {
    fs::path path = place_of(place_, name);
    files_.push_back(path.lexically_relative(place_.folder));
    return path;
  }

  /// In the folder of the date, which holds the drives.
  void write_calibration() {
    const Pose T_velo_imu = place_.T_imu_lidar.inverse();
    std::string text = "R:";
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) text += fmt::format(" {}", T_velo_imu.R(row, column));
    }
    text += fmt::format("\nT: {} {} {}\n", T_velo_imu.p.x(), T_velo_imu.p.y(), T_velo_imu.p.z());
    AtomicFile file(named((fs::path(drive_).parent_path() / "calib_imu_to_velo.txt").string()));
    file.write(text);
    file.close();
  }

  /// Laser after laser, the highest first, each from ahead over the left.
  void write_scan(TimeNs begin, TimeNs end) {
    constexpr double kTurn = 2 * std::numbers::pi;
    const auto from_ahead = [](const TimedPoint& p) {
      const double azimuth = std::atan2(double{p.y}, double{p.x});
      return azimuth < 0 ? azimuth + kTurn : azimuth;
    };
    std::stable_sort(scan_.begin(), scan_.end(), [&](const TimedPoint& a, const TimedPoint& b) {
      return a.line != b.line ? a.line > b.line : from_ahead(a) < from_ahead(b);
    });
    AtomicFile file(place_of(place_, fmt::format("{}/velodyne_points/data/{:010}.bin", drive_, written_++)), true);
    for (const TimedPoint& p : scan_) {
      constexpr float kFullScale = 255;
      const std::array<float, 4> values{p.x, p.y, p.z, p.intensity / kFullScale};
      file.write({reinterpret_cast<const char*>(values.data()), sizeof(values)});
    }
    file.close();
    begins_.write(date_text(begin));
    ends_.write(date_text(end));
    scans_.write(date_text(begin + (end - begin) / 2));
  }

  const Layout layout_;
  const LayoutPlace place_;
  const std::string drive_, oxts_;
  std::vector<fs::path> files_;
  ReferenceSampler sampler_;
  AtomicFile scans_, begins_, ends_, packets_;
  std::optional<ReferenceFileWriter> reference_;
  LidarPacket scratch_;
  std::vector<TimedPoint> scan_;
  std::optional<TimeNs> begin_;
  Pose last_pose_;
  std::size_t written_ = 0, samples_ = 0;
};

}  // namespace

std::unique_ptr<LayoutWriter> open_kitti_layout(const Layout& layout, const LayoutPlace& place) {
  return std::make_unique<KittiLayoutWriter>(layout, place);
}

}  // namespace aslio::io
