#include "evaluation/tum.hpp"

#include <Eigen/Geometry>
#include <fstream>
#include <sstream>
#include <stdexcept>

aslio::Trajectory test::read_tum(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  aslio::Trajectory trajectory;
  std::string line;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    aslio::TimeNs seconds = 0;
    char dot = 0;
    std::string fraction;
    aslio::Vec3 p;
    Eigen::Quaterniond q;
    fields >> seconds >> dot >> fraction >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w();
    if (!fields || dot != '.') throw std::runtime_error(file.string() + ": not a TUM line: " + line);
    fraction.resize(9, '0');
    trajectory.append({seconds * aslio::kSecond + std::stoll(fraction), {q.normalized().toRotationMatrix(), p}});
  }
  return trajectory;
}
