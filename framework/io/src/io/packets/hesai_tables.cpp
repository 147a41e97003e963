#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "hesai.hpp"

namespace aslio::io::packets {
namespace {

constexpr std::array<HesaiBeam, 40> k40p{
    {{14.794, -1.042},  {10.944, -1.042},  {7.971, -1.042},   {4.969, -1.042},   {2.952, -1.042},  {1.94, -1.042},
     {1.6, 3.125},      {1.263, -5.208},   {0.925, -1.042},   {0.587, 3.125},    {0.249, -5.208},  {-0.088, -1.042},
     {-0.425, 3.125},   {-0.763, -5.208},  {-1.101, -1.042},  {-1.439, 3.125},   {-1.776, -5.208}, {-2.116, -1.042},
     {-2.453, 3.125},   {-2.788, -5.208},  {-3.128, -1.042},  {-3.463, 3.125},   {-3.8, -5.208},   {-4.138, -1.042},
     {-4.473, 3.125},   {-4.808, -5.208},  {-5.145, -1.042},  {-5.479, 3.125},   {-5.814, -5.208}, {-6.149, -1.042},
     {-7.151, -1.042},  {-8.147, -1.042},  {-9.148, -1.042},  {-10.133, -1.042}, {-11.12, -1.042}, {-12.094, -1.042},
     {-13.062, -1.042}, {-14.018, -1.042}, {-18.977, -1.042}, {-24.985, -1.042}}};

constexpr std::array<HesaiBeam, 64> kQt64{
    {{-52.121, 8.736},  {-49.785, 8.314},  {-47.577, 7.964},  {-45.477, 7.669},  {-43.465, 7.417},  {-41.528, 7.198},
     {-39.653, 7.007},  {-37.831, 6.838},  {-36.055, 6.688},  {-34.320, 6.554},  {-32.619, 6.434},  {-30.950, 6.326},
     {-29.308, 6.228},  {-27.690, 6.140},  {-26.094, 6.059},  {-24.517, 5.987},  {-22.964, -5.270}, {-21.420, -5.216},
     {-19.889, -5.167}, {-18.372, -5.123}, {-16.865, -5.083}, {-15.368, -5.047}, {-13.880, -5.016}, {-12.399, -4.988},
     {-10.925, -4.963}, {-9.457, -4.942},  {-7.994, -4.924},  {-6.535, -4.910},  {-5.079, -4.898},  {-3.626, -4.889},
     {-2.175, -4.884},  {-0.725, -4.881},  {0.725, 5.493},    {2.175, 5.496},    {3.626, 5.502},    {5.079, 5.512},
     {6.534, 5.525},    {7.993, 5.541},    {9.456, 5.561},    {10.923, 5.584},   {12.397, 5.611},   {13.877, 5.642},
     {15.365, 5.676},   {16.861, 5.716},   {18.368, 5.759},   {19.885, 5.808},   {21.415, 5.862},   {22.959, 5.921},
     {24.524, -5.330},  {26.101, -5.396},  {27.697, -5.469},  {29.315, -5.550},  {30.957, -5.640},  {32.627, -5.740},
     {34.328, -5.850},  {36.064, -5.974},  {37.840, -6.113},  {39.662, -6.269},  {41.537, -6.447},  {43.475, -6.651},
     {45.487, -6.887},  {47.587, -7.163},  {49.795, -7.493},  {52.133, -7.892}}};

/// A number that takes up all of `cell` but for blanks around it.
std::optional<double> number_in(std::string_view cell) {
  while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
  while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t' || cell.back() == '\r')) cell.remove_suffix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// The first three cells of a line; nothing when one of them is no number.
std::optional<std::array<double, 3>> numbers_in(std::string_view line) {
  std::array<double, 3> values{};
  for (double& value : values) {
    const std::size_t comma = std::min(line.find(','), line.size());
    const auto found = number_in(line.substr(0, comma));
    if (!found) return std::nullopt;
    value = *found;
    line.remove_prefix(std::min(comma + 1, line.size()));
  }
  return values;
}

}  // namespace

HesaiBeams hesai_beams(HesaiModel model) {
  if (model == HesaiModel::pandar40p) return {k40p.begin(), k40p.end()};
  if (model == HesaiModel::qt64) return {kQt64.begin(), kQt64.end()};
  HesaiBeams beams(hesai_channels(model));
  const double step = model == HesaiModel::xt16 ? 2 : 1;
  for (std::size_t i = 0; i < beams.size(); ++i) beams[i].elevation = 15 - step * static_cast<double>(i);
  return beams;
}

HesaiBeams read_hesai_beams(const std::string& name, std::string_view text) {
  constexpr std::size_t kMostChannels = 256;
  HesaiBeams beams;
  for (std::size_t row = 1; !text.empty(); ++row) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const bool blank = line.find_first_not_of(" \t\r") == std::string_view::npos;
    const auto values = numbers_in(line);
    if (blank || (beams.empty() && !values)) continue;  // the head of the table
    const bool in_order = values && (*values)[0] == static_cast<double>(beams.size() + 1);
    const bool angles = values && std::abs((*values)[1]) <= 90 && std::abs((*values)[2]) <= 180;
    if (!in_order || !angles || beams.size() == kMostChannels) {
      throw DataError(
          fmt::format("{}, line {}: '{}' is no `channel,elevation,azimuth` of channel {} in degrees; name "
                      "the table of angles that belongs to the sensor",
                      name, row, line.substr(0, 80), beams.size() + 1));
    }
    beams.push_back({(*values)[1], (*values)[2]});
  }
  if (beams.empty()) throw DataError(fmt::format("{}: it holds no line `channel,elevation,azimuth`", name));
  return beams;
}

}  // namespace aslio::io::packets
