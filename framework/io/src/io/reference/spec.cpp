// The keys of a reference, and what they mean together.
#include <fmt/format.h>

#include <algorithm>

#include "aslio/config/file_text.hpp"
#include "aslio/config/load.hpp"
#include "aslio/config/stage_lookup.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/reference.hpp"
#include "rows.hpp"

namespace aslio::io {
namespace {

constexpr double kMaxSeconds = 1e9;

/// A reference has no stages.
class NoStages final : public config::StageLookup {
 public:
  const config::StageEntry* find(std::string_view, std::string_view) const override { return nullptr; }
  std::vector<std::string> types(std::string_view) const override { return {}; }
  std::vector<std::string> families() const override { return {}; }
};

const std::string kSchema = "schema: aslio/reference/1\n";

std::filesystem::path beside(const std::filesystem::path& folder, const std::string& written) {
  return (folder / written).lexically_normal();
}

void describe_file(config::Binder& b, ReferenceSpec& spec) {
  b.text("file", spec.file, "trajectory, table or recording; empty: no reference");
  b.text("times", spec.times, "file with the stamp of each pose, a line each: for the 12 numbers of KITTI");
  describe_format(b, spec.format, "how poses are written; auto: by the content");
  b.texts("columns", spec.columns, {},
          "what the columns hold, in their order: t, or sec and nsec; x, y, z; qx, qy, qz, qw, or r11 to r33; - for "
          "others. Or by the names of the header: x=pos_x");
  b.choice("time_unit", spec.time_unit,
           {{"auto", TimeUnit::automatic},
            {"s", TimeUnit::s},
            {"ms", TimeUnit::ms},
            {"us", TimeUnit::us},
            {"ns", TimeUnit::ns}},
           "unit of the stamps; auto: by their size, or by the header");
  b.text("topic", spec.topic, "topic of a recording; empty: the only one that tells poses");
  b.text("parent_frame", spec.parent_frame, "of a TF topic: the frame that is the world; empty: the only one");
  b.text("child_frame", spec.child_frame, "of a TF topic: the frame whose pose is the reference; empty: the only one");
}

void describe_association(config::Binder& b, ReferenceSpec& spec) {
  b.real("time_offset", spec.time_offset, "s", {.min = -kMaxSeconds, .max = kMaxSeconds},
         "added to the stamps of the reference");
  b.real("min_spacing", spec.min_spacing, "s", {.min = 0.0, .max = kMaxSeconds},
         "poses that come sooner after the last one are left out");
  b.choice("association", spec.association,
           {{"interpolated", Association::interpolated},
            {"nearest", Association::nearest},
            {"at_reference", Association::at_reference}},
           "interpolated: the reference at the stamps of the estimate; nearest: nearest stamps; at_reference: the "
           "estimate at the stamps of the reference, for a sparse one");
  b.optional_real("max_gap", spec.max_gap, "s", {.above = 0.0, .max = kMaxSeconds},
                  "2.5 of its usual steps, at least 0.1 s", "longest gap of the reference to interpolate across");
  b.optional_real("max_neighbour", spec.max_neighbour, "s", {.above = 0.0, .max = kMaxSeconds}, "any",
                  "farthest neighbour in the reference of a stamp to interpolate at");
  b.real("max_difference", spec.max_difference, "s", {.above = 0.0, .max = kMaxSeconds},
         "largest difference of nearest stamps");
  b.choice("protocol", spec.protocol,
           {{"none", Protocol::none},
            {"ntu_viral", Protocol::ntu_viral},
            {"hilti_2022", Protocol::hilti_2022},
            {"hilti_2023", Protocol::hilti_2023}},
           "measures as the authors of a data set do; keys that are written go before its own");
}

/// What a protocol says where the keys say nothing.
void apply_protocol(ReferenceSpec& spec) {
  const ReferenceSpec unset;
  const bool placed = !spec.lever_arm.empty() || !spec.frame.empty() || !spec.T_imu_reference.is_identity();
  switch (spec.protocol) {
    case Protocol::none:
      return;
    case Protocol::ntu_viral:
      if (!placed) spec.lever_arm = {-0.293656, -0.012288, -0.273095};  // prism in the body frame
      spec.positions_only = PositionsOnly::yes;
      if (spec.topic.empty() && (spec.format == ReferenceFormat::recording || is_recording(spec.file)))
        spec.topic = "/leica/pose/relative";
      if (!spec.max_neighbour) spec.max_neighbour = 0.1;
      if (!spec.max_gap) spec.max_gap = 2 * *spec.max_neighbour;
      return;
    case Protocol::hilti_2022:
    case Protocol::hilti_2023:
      spec.association = Association::nearest;
      spec.positions_only = PositionsOnly::yes;
      if (spec.max_difference == unset.max_difference) spec.max_difference = 2.0;
      // The tip of the pole. The frame of 2023 is another one: its lever arm has to be written.
      if (!placed && spec.protocol == Protocol::hilti_2022) {
        spec.lever_arm = {0.059, -0.00855, 0.1964};
      }
  }
}

ReferenceSpec parsed(const std::string& text, const std::string& source, const std::vector<std::string>& overrides) {
  std::vector<config::Override> sets;
  for (const std::string& assignment : overrides) sets.push_back({assignment});
  return config::parse<ReferenceSpec>(text, source, config::FileKind::reference, NoStages(), sets).value;
}

bool is_yaml(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".yaml" || extension == ".yml";
}

}  // namespace

void describe_format(config::Binder& b, ReferenceFormat& format, std::string_view doc) {
  b.choice("format", format,
           {{"auto", ReferenceFormat::automatic},
            {"tum", ReferenceFormat::tum},
            {"csv", ReferenceFormat::csv},
            {"euroc", ReferenceFormat::euroc},
            {"kitti", ReferenceFormat::kitti},
            {"recording", ReferenceFormat::recording}},
           doc);
}

void ReferenceSpec::describe(config::Binder& b, ReferenceSpec& spec) {
  describe_file(b, spec);
  b.choice("positions_only", spec.positions_only,
           {{"auto", PositionsOnly::automatic}, {"yes", PositionsOnly::yes}, {"no", PositionsOnly::no}},
           "no rotation error is measured; auto: where there is no orientation, or it never changes on the way");
  b.group("T_imu_reference", spec.T_imu_reference,
          "pose of the frame of the reference in the IMU frame: p_I = T_imu_reference p_R");
  b.text("frame", spec.frame,
         "frame of the reference; T_imu_reference is then the chain from `imu` to it through `transforms` and those of "
         "the sensor file, T_imu_lidar (frame `lidar`) among them");
  b.groups("transforms", spec.transforms, "further transforms between frames");
  b.reals("lever_arm", spec.lever_arm, 0, "m", {.min = -1000.0, .max = 1000.0},
          "position of the reference point (prism, antenna) in the IMU frame; empty: none");
  describe_association(b, spec);
  b.require(spec.lever_arm.empty() || spec.lever_arm.size() == 3, "lever_arm", "must be 3 numbers");
  b.require(spec.lever_arm.empty() || (spec.T_imu_reference.is_identity() && spec.frame.empty()), "lever_arm",
            "is the translation of T_imu_reference: give one of lever_arm, T_imu_reference and frame");
  b.require(spec.frame.empty() || spec.T_imu_reference.is_identity(), "frame",
            "and T_imu_reference exclude each other: leave one out");
}

ReferenceSpec parse_reference_spec(const std::string& text, const std::string& source) {
  return parsed(text, source, {});
}

ReferenceSpec load_reference_spec(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  if (!is_yaml(path)) {
    ReferenceSpec spec = parsed(kSchema, path.string(), overrides);
    if (!spec.file.empty()) {
      throw ConfigError(fmt::format("{}: is the reference, and 'file' names another one: {}; leave 'file' out",
                                    path.string(), spec.file));
    }
    spec.file = path.string();
    return spec;
  }
  ReferenceSpec spec = parsed(config::read_text(path), path.string(), overrides);
  if (spec.file.empty()) {
    throw ConfigError(fmt::format("{}: 'file' is required: name the trajectory, table or recording", path.string()));
  }
  spec.file = beside(path.parent_path(), spec.file).string();
  if (!spec.times.empty()) spec.times = beside(path.parent_path(), spec.times).string();
  for (const std::string& named : {spec.file, spec.times}) {
    std::error_code ignored;
    if (named.empty() || std::filesystem::exists(named, ignored)) continue;
    throw ConfigError(
        fmt::format("{}: names what does not exist: {} (paths are relative to its folder)", path.string(), named));
  }
  return spec;
}

ReferenceSpec with_overrides(const ReferenceSpec& spec, const std::vector<std::string>& overrides) {
  return overrides.empty() ? spec : parsed(resolved_text(spec), spec.file, overrides);
}

ReferenceSpec in_place(ReferenceSpec spec, const Pose& T_imu_reference) {
  const Vec3& p = T_imu_reference.p;
  spec.T_imu_reference = {};
  spec.T_imu_reference.translation = {p.x(), p.y(), p.z()};
  for (int i = 0; !T_imu_reference.R.isIdentity(0) && i < 9; ++i) {
    spec.T_imu_reference.rotation.push_back(T_imu_reference.R(i / 3, i % 3));
  }
  spec.frame.clear();
  spec.transforms.clear();
  spec.lever_arm.clear();
  return spec;
}

std::string resolved_text(const ReferenceSpec& spec) {
  return config::file_text(spec, config::FileKind::reference, NoStages());
}

ReferenceSpec with_protocol(ReferenceSpec spec) {
  apply_protocol(spec);
  return spec;
}

Pose pose_in_imu(const ReferenceSpec& spec, std::vector<NamedTransform> more) {
  if (!spec.lever_arm.empty()) return {Mat3::Identity(), Vec3(spec.lever_arm[0], spec.lever_arm[1], spec.lever_arm[2])};
  if (!spec.T_imu_reference.is_identity()) return spec.T_imu_reference.pose();
  more.insert(more.begin(), spec.transforms.begin(), spec.transforms.end());
  if (!spec.frame.empty()) return spec.frame == "imu" ? Pose{} : find_transform(more, "imu", spec.frame);
  const bool known = std::any_of(more.begin(), more.end(), [](const NamedTransform& t) {
    return t.child == "reference" || t.parent == "reference";
  });
  return known ? find_transform(more, "imu", "reference") : Pose{};
}

}  // namespace aslio::io
