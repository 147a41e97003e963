#include "record/top_view.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>

#include "aslio/core/errors.hpp"
#include "aslio/io/markup.hpp"

namespace aslio::simulator {
namespace {

constexpr double kReach = 100;                    // beyond the path [m]
constexpr int kMaxPixels = 1600;                  // in width and height
constexpr double kFloor = 0.25, kOverhead = 2.2;  // what stands is seen between these heights [m]
constexpr double kFinest = 0.02;                  // [m/pixel]
constexpr double kShownWidth = 1200, kMargin = 16, kHeader = 34, kFooter = 46;  // of the picture [px]

struct Bounds {
  Vec2 low = Vec2::Constant(1e9), high = Vec2::Constant(-1e9);
  void add(const Vec2& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

Bounds shown_bounds(const Trajectory& path, const Mesh& mesh) {
  Bounds near, world;
  for (const StampedPose& s : path.samples()) near.add(s.T.p.head<2>());
  for (const Eigen::Vector3f& v : mesh.vertices) world.add(v.head<2>().cast<double>());
  near.low = (near.low.array() - kReach).matrix().cwiseMax(world.low);
  near.high = (near.high.array() + kReach).matrix().cwiseMin(world.high);
  // Where the world ends before the path does, the path is still shown.
  for (const StampedPose& s : path.samples()) near.add(s.T.p.head<2>());
  return near;
}

/// 1, 2 or 5 times a power of ten.
double round_length(double most) {
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double digit : {5.0, 2.0})
    if (digit * power <= most) return digit * power;
  return power;
}

}  // namespace

TopView::TopView(const Trajectory& path, const Mesh& mesh, const Ground& ground) : ground_(ground) {
  const Bounds bounds = shown_bounds(path, mesh);
  low_ = bounds.low.array() - 1;
  const Vec2 size = bounds.high.array() + 1 - low_.array();
  resolution_ = std::max(kFinest, size.maxCoeff() / kMaxPixels);
  width_ = std::max(1, static_cast<int>(std::ceil(size.x() / resolution_)));
  height_ = std::max(1, static_cast<int>(std::ceil(size.y() / resolution_)));
  const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  standing_.assign(pixels, 0);
  level_.assign(pixels, 0);
}

void TopView::add(std::span<const Eigen::Vector3f> points_W) {
  for (const Eigen::Vector3f& p : points_W) {
    const Vec2 at = p.head<2>().cast<double>();
    const Vec2 cell = (at - low_) / resolution_;
    if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < width_ && cell.y() < height_)) continue;
    const auto row = static_cast<std::size_t>(height_ - 1 - static_cast<int>(cell.y()));
    const std::size_t pixel = row * static_cast<std::size_t>(width_) + static_cast<std::size_t>(cell.x());
    const double above = static_cast<double>(p.z()) - ground_.height(at.x(), at.y());
    ++(above > kFloor && above < kOverhead ? standing_ : level_)[pixel];
  }
}

TopView::Crop TopView::used() const {
  int left = width_, right = -1, top = height_, bottom = -1;
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const auto pixel =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
      if (standing_[pixel] == 0 && level_[pixel] == 0) continue;
      left = std::min(left, column);
      right = std::max(right, column);
      top = std::min(top, row);
      bottom = std::max(bottom, row);
    }
  }
  if (right < 0) return {0, 0, width_, height_};
  return {left, top, right - left + 1, bottom - top + 1};
}

std::vector<std::uint8_t> TopView::png(const Crop& crop) const {
  constexpr std::array<double, 3> kPaper = {255, 255, 255}, kLevel = {222, 226, 232}, kStanding = {28, 52, 92};
  std::vector<png_byte> pixels;
  pixels.reserve(3 * static_cast<std::size_t>(crop.width) * static_cast<std::size_t>(crop.height));
  const auto shade = [](std::uint32_t count, double first) {
    return count == 0 ? 0.0 : std::min(1.0, first + 0.15 * std::log2(static_cast<double>(count)));
  };
  for (int row = crop.top; row < crop.top + crop.height; ++row) {
    for (int column = crop.left; column < crop.left + crop.width; ++column) {
      const auto pixel =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
      const double level = shade(level_[pixel], 0.5), standing = shade(standing_[pixel], 0.35);
      for (std::size_t c = 0; c < 3; ++c) {
        const double below = kPaper[c] + level * (kLevel[c] - kPaper[c]);
        pixels.push_back(static_cast<png_byte>(std::lround(below + standing * (kStanding[c] - below))));
      }
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(crop.width);
  image.height = static_cast<png_uint_32>(crop.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::vector<std::uint8_t> bytes;
  // The first call tells the size.
  if (png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, nullptr) != 0) {
    bytes.resize(size);
    if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) != 0) {
      bytes.resize(size);
      return bytes;
    }
  }
  throw DataError(fmt::format("preview: libpng: {}", static_cast<const char*>(image.message)));
}

std::string TopView::svg(const Trajectory& path, const std::string& title) const {
  const Crop crop = used();
  const double scale = std::min(kShownWidth / crop.width, kShownWidth / crop.height);  // shown pixels per pixel
  const double width = scale * crop.width, height = scale * crop.height;
  const auto shown = [&](const Vec3& p) -> Vec2 {
    const Vec2 cell = (Vec2(p.head<2>()) - low_) / resolution_;
    return {kMargin + scale * (cell.x() - crop.left), kHeader + scale * (height_ - cell.y() - crop.top)};
  };
  const double total_width = std::max(width + 2 * kMargin, 480.0), total_height = kHeader + height + kFooter;
  std::string out;
  const auto to = std::back_inserter(out);
  fmt::format_to(to,
                 "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
                 "height=\"{1:.0f}\" font-family=\"sans-serif\" font-size=\"15\">\n"
                 "<title>{2}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
                 "<text x=\"{3}\" y=\"22\" fill=\"#111\">{2}</text>\n",
                 total_width, total_height, io::html_escaped(title), kMargin);
  fmt::format_to(to,
                 "<image x=\"{}\" y=\"{}\" width=\"{:.1f}\" height=\"{:.1f}\" href=\"data:image/png;base64,{}\"/>\n",
                 kMargin, kHeader, width, height, io::base64(png(crop)));
  out += "<polyline fill=\"none\" stroke=\"#d9480f\" stroke-width=\"2\" stroke-linejoin=\"round\" points=\"";
  Vec2 last = Vec2::Constant(-1e9);
  for (const StampedPose& s : path.samples()) {
    const Vec2 at = shown(s.T.p);
    if ((at - last).norm() < 1) continue;
    fmt::format_to(to, "{:.1f},{:.1f} ", at.x(), at.y());
    last = at;
  }
  out += "\"/>\n";
  const Vec2 start = shown(path.samples().front().T.p);
  fmt::format_to(to,
                 "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"5\" fill=\"#d9480f\" stroke=\"#fff\"/>\n"
                 "<text x=\"{2:.1f}\" y=\"{3:.1f}\" fill=\"#a33508\" stroke=\"#fff\" stroke-width=\"3\" "
                 "paint-order=\"stroke\">start</text>\n",
                 start.x(), start.y(), start.x() + 9, start.y() - 7);
  const double metres = round_length(width / 4 / scale * resolution_), bar = metres / resolution_ * scale;
  const double y = kHeader + height + 20;
  fmt::format_to(to,
                 "<path d=\"M{0} {1:.1f}v6h{2:.1f}v-6\" fill=\"none\" stroke=\"#111\"/>\n"
                 "<text x=\"{3:.1f}\" y=\"{4:.1f}\" fill=\"#111\">{5:g} m</text>\n</svg>\n",
                 kMargin, y, bar, kMargin + bar + 8, y + 8, metres);
  return out;
}

}  // namespace aslio::simulator
