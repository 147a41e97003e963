#include "kitti_source.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "decode/decode.hpp"
#include "imu_rate.hpp"
#include "kitti_drive.hpp"

namespace aslio::io {
namespace {

class KittiSource final : public MeasurementSource {
 public:
  KittiSource(const std::filesystem::path& folder, const SensorConfig& sensor, const Section& section)
      : drive_(read_kitti_drive(folder)) {
    const std::string where = folder.string();
    if (drive_.scans.empty()) throw DataError(fmt::format("{}: there is no scan in velodyne_points/data", where));
    if (drive_.imu.empty()) throw DataError(fmt::format("{}: there is no IMU data in oxts/data", where));
    std::vector<ImuSample> first;
    for (const ImuSample& s : drive_.imu) {
      if (s.t - drive_.imu.front().t <= 5 * kSecond) first.push_back(s);
    }
    units_ = decode::judge_imu_units(first, sensor, where + "/oxts");
    notes_.verdicts = units_.verdicts;
    notes_.warnings = units_.warnings;
    note_imu_rate(first, notes_);
    note_gyro_range(sensor.gyro_unit);
    notes_.verdicts.push_back("lidar point times: by the azimuth between timestamps_start and timestamps_end");
    if (drive_.missing_scans > 0) {
      notes_.warnings.push_back(fmt::format("{}: {} scans are listed but missing", where, drive_.missing_scans));
    }
    if (drive_.missing_imu > 0) {
      notes_.warnings.push_back(fmt::format("{}: {} OXTS packets are listed but missing", where, drive_.missing_imu));
    }
    if (sensor.from_file) compare_extrinsic(sensor.model.T_imu_lidar);
    for (ImuSample& sample : drive_.imu) units_.apply(sample);
    set_section(section);
  }

  std::optional<Measurement> next() override {
    while (true) {
      const bool scans_left = scan_ < drive_.scans.size(), imu_left = imu_ < drive_.imu.size();
      if (!scans_left && !imu_left) return std::nullopt;
      // By the time at which they begin, for a drive records no order of arrival. A scan after the IMU samples of its
      // revolution would come too late in part when the odometry starts on one of them.
      if (imu_left && (!scans_left || drive_.imu[imu_].t <= drive_.scans[scan_].begin)) {
        const ImuSample& sample = drive_.imu[imu_++];
        if (sample.t < from_ || sample.t >= until_) continue;
        return Measurement(sample);
      }
      const KittiScan& scan = drive_.scans[scan_];
      const auto number = static_cast<std::uint32_t>(scan_++);
      if (scan.begin < from_ || scan.begin >= until_) continue;
      LidarPacket packet;
      packet.sweep_id = number;
      if (const std::size_t rest = read_kitti_scan(scan, packet); rest > 0) {
        status_ = InputStatus::truncated;
        notes_.warnings.push_back(fmt::format("{}: the file ends inside a point", scan.file.string()));
      }
      return Measurement(std::move(packet));
    }
  }

  InputStatus status() const override { return status_; }
  const SourceNotes& notes() const override { return notes_; }
  std::optional<TimeNs> begin_time() const override { return begin_; }
  std::optional<TimeNs> end_time() const override { return end_; }

 private:
  void note_gyro_range(GyroUnit declared) {
    decode::GyroRange range;
    for (const ImuSample& s : drive_.imu) range.add(s.gyro);
    for (const std::string& text : {range.beyond(units_), range.doubt(declared)}) {
      if (!text.empty()) notes_.warnings.push_back(fmt::format("{}/oxts: {}", drive_.folder.string(), text));
    }
  }

  void compare_extrinsic(const Pose& T_imu_lidar) {
    if (!drive_.T_imu_velo) return;
    const Pose difference = drive_.T_imu_velo->inverse() * T_imu_lidar;
    const double degrees = log_so3(difference.R).norm() * kDegPerRad;
    if (difference.p.norm() <= 1e-3 && degrees <= 0.01) return;
    notes_.warnings.push_back(
        fmt::format("{}: T_imu_lidar of the sensor file is {:.1f} mm and {:.3f} deg away from "
                    "calib_imu_to_velo.txt; the sensor file counts",
                    drive_.folder.string(), 1e3 * difference.p.norm(), degrees));
  }

  void set_section(const Section& section) {
    begin_ = std::min(drive_.scans.front().begin, drive_.imu.front().t);
    end_ = std::max(drive_.scans.back().end, drive_.imu.back().t);
    if (section.start > to_seconds(end_ - begin_)) {
      throw DataError(fmt::format("{}: the section starts at {} s, the drive lasts {:.3f} s", drive_.folder.string(),
                                  section.start, to_seconds(end_ - begin_)));
    }
    if (section.start > 0) from_ = begin_ + to_ns(section.start);
    if (section.duration) until_ = begin_ + to_ns(section.start) + to_ns(*section.duration);
    begin_ = std::max(begin_, from_);
    end_ = std::min(end_, until_);
  }

  KittiDrive drive_;
  decode::ImuUnits units_;
  SourceNotes notes_;
  InputStatus status_ = InputStatus::complete;
  std::size_t scan_ = 0, imu_ = 0;
  TimeNs begin_ = 0, end_ = 0, from_ = kTimeMin, until_ = kTimeMax;
};

}  // namespace

std::unique_ptr<MeasurementSource> open_kitti(const std::filesystem::path& folder, const SensorConfig& sensor,
                                              const Section& section) {
  return std::make_unique<KittiSource>(folder, sensor, section);
}

}  // namespace aslio::io
