#include <cstring>
#include <vector>

#include "../../framework/io/src/io/decode/decode.hpp"
#include "fuzz/target.hpp"

// One message; then what units make of its bytes as samples of six doubles. The first byte: the declared units.
ASLIO_FUZZ_TARGET(imu) {
  if (bytes.empty()) return;
  const io::decode::Message message(bytes.subspan(1), bytes[0] >= 128 ? io::Encoding::cdr : io::Encoding::ros1);
  ImuSample sample;
  (void)io::decode::decode_imu(message, sample);
  (void)io::decode::header_stamp(message);
  io::SensorConfig sensor;
  sensor.acc_unit = static_cast<io::AccUnit>(bytes[0] % 3);
  sensor.gyro_unit = static_cast<io::GyroUnit>(bytes[0] / 3 % 3);
  std::vector<ImuSample> samples;
  io::decode::GyroRange range;
  constexpr std::size_t kBytes = 6 * sizeof(double);
  for (Bytes rest = bytes.subspan(1); rest.size() >= kBytes; rest = rest.subspan(kBytes)) {
    sample.t += kSecond / 100;
    std::memcpy(sample.gyro.data(), rest.data(), kBytes / 2);
    std::memcpy(sample.acc.data(), rest.data() + kBytes / 2, kBytes / 2);
    samples.push_back(sample);
    range.add(sample.gyro);
  }
  accepts([&] {
    const auto units = io::decode::judge_imu_units(samples, sensor, "input");
    must(!units.verdicts.empty(), "units have a verdict");
    for (ImuSample& s : samples) units.apply(s);
    (void)range.beyond(units);
  });
  (void)range.doubt(sensor.gyro_unit);
}
