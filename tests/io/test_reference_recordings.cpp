// References in recordings of messages.
#include <catch2/catch.hpp>
#include <cstring>

#include "aslio/core/errors.hpp"
#include "aslio/io/reference.hpp"
#include "io/bag_fixture.hpp"

// Of the library, not of its interface: messages in CDR have no writer here.
#include "../../framework/io/src/io/reference/decode_poses.hpp"

namespace aslio::io::test {
namespace {

/// Writes messages, packed as ROS1 does or aligned as CDR does.
struct Message {
  std::vector<std::uint8_t> bytes;
  bool cdr = false;

  explicit Message(bool as_cdr = false) : cdr(as_cdr) {
    if (cdr) bytes = {0, 1, 0, 0};
  }
  template <class T>
  Message& add(T value) {
    while (cdr && (bytes.size() - 4) % sizeof(T) != 0) bytes.push_back(0);
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof(T));
    std::memcpy(bytes.data() + at, &value, sizeof(T));
    return *this;
  }
  Message& text(const std::string& value) {
    add(static_cast<std::uint32_t>(value.size() + (cdr ? 1 : 0)));
    bytes.insert(bytes.end(), value.begin(), value.end());
    if (cdr) bytes.push_back(0);
    return *this;
  }
  Message& header(TimeNs t, const std::string& frame) {
    if (!cdr) add(std::uint32_t{7});
    add(static_cast<std::uint32_t>(t / kSecond)).add(static_cast<std::uint32_t>(t % kSecond));
    return text(frame);
  }
  Message& numbers(std::initializer_list<double> values) {
    for (const double v : values) add(v);
    return *this;
  }
};

struct Topic {
  std::string name, type;
  std::function<Message(TimeNs t, double x)> message;
};

std::filesystem::path write(const std::filesystem::path& path, const std::vector<Topic>& topics) {
  rosbag::BagWriter writer(path);
  std::vector<std::uint32_t> ids;
  for (const Topic& t : topics) ids.push_back(writer.add_connection(t.name, t.type, "0", ""));
  for (int i = 0; i < 10; ++i) {
    const TimeNs t = kStart + i * kSecond / 10;
    for (std::size_t k = 0; k < topics.size(); ++k) writer.write(ids[k], t + 7, topics[k].message(t, i).bytes);
  }
  writer.close();
  return path;
}

Message pose(TimeNs t, double x) { return Message().header(t, "map").numbers({x, 2, 3, 0, 0, 1, 0}); }
Message transform(TimeNs t, double x) { return Message().header(t, "map").text("base").numbers({x, 2, 3, 0, 0, 1, 0}); }
Message point(TimeNs t, double x) { return Message().header(t, "map").numbers({x, 2, 3}); }
Message transforms(TimeNs t, double x) {
  Message m;
  m.add(std::uint32_t{2});
  m.header(t, "/map").text("base").numbers({x, 2, 3, 0, 0, 1, 0});
  return m.header(t, "base").text("lidar").numbers({0, 0, 1, 0, 0, 0, 1});
}

void check_ten(const Reference& reference, bool positions_only = false) {
  REQUIRE(reference.poses.size() == 10);
  CHECK(reference.poses[3].t == kStart + 3 * kSecond / 10);
  CHECK(reference.poses[3].T.p == Vec3(3, 2, 3));
  CHECK(reference.positions_only == positions_only);
  if (!positions_only) CHECK(reference.poses[3].T.R(0, 0) == Approx(-1));
}

}  // namespace

TEST_CASE("poses are read from each type of message that tells them") {
  const TemporaryFolder folder;
  const struct {
    const char* type;
    Message (*message)(TimeNs, double);
    bool positions_only;
  } kinds[] = {{"nav_msgs/Odometry", transform, false},
               {"geometry_msgs/PoseStamped", pose, false},
               {"geometry_msgs/PoseWithCovarianceStamped", pose, false},
               {"geometry_msgs/TransformStamped", transform, false},
               {"geometry_msgs/PointStamped", point, true},
               {"geometry_msgs/msg/PoseStamped", pose, false}};
  for (const auto& kind : kinds) {
    INFO(kind.type);
    ReferenceSpec spec = write(folder / "gt.bag", {{"/gt", kind.type, kind.message}});
    // All orientations are alike.
    if (!kind.positions_only) spec.positions_only = PositionsOnly::no;
    const Reference reference = read_reference(spec);
    check_ten(reference, kind.positions_only);
    CHECK(contains(reference.notes, "poses of topic /gt"));
  }
}

TEST_CASE("fixes of a satellite receiver are metres east, north and up of the first") {
  const TemporaryFolder folder;
  const auto fix = [](TimeNs t, double x) {
    Message m;
    m.header(t, "gps").add(static_cast<std::int8_t>(x == 5 ? -1 : 0)).add(std::uint16_t{1});
    return m.numbers({47.0 + 1e-5 * x, 8.0, 400 + x});
  };
  const Reference reference = read_reference(write(folder / "gt.bag", {{"/fix", "sensor_msgs/NavSatFix", fix}}));
  REQUIRE(reference.poses.size() == 9);
  CHECK(reference.positions_only);
  CHECK(contains(reference.notes, "1 messages have no fix: left out"));
  // A degree of latitude is 111 174 m at 47 degrees.
  CHECK((reference.poses[4].T.p - Vec3(0, 4 * 1.11174, 4)).norm() < 1e-3);
}

TEST_CASE("a topic is chosen, by its name where there are several") {
  const TemporaryFolder folder;
  ReferenceSpec spec = write(folder / "gt.bag", {{"/a", "geometry_msgs/PoseStamped", pose},
                                                 {"/b", "geometry_msgs/PointStamped", point},
                                                 {"/tf", "tf2_msgs/TFMessage", transforms}});
  CHECK_THAT(data_error([&] { read_reference(spec); }), Catch::Contains("there is more than one reference topic") &&
                                                            Catch::Contains("/b [geometry_msgs/PointStamped]"));
  spec.topic = "/b";
  check_ten(read_reference(spec), true);
  spec.topic = "/c";
  CHECK_THAT(data_error([&] { read_reference(spec); }), Catch::Contains("there is no reference topic '/c'"));
}

TEST_CASE("a transform is chosen by its frames") {
  const TemporaryFolder folder;
  ReferenceSpec spec =
      write(folder / "gt.bag", {{"/a", "geometry_msgs/PoseStamped", pose}, {"/tf", "tf2_msgs/TFMessage", transforms}});
  spec.positions_only = PositionsOnly::no;
  spec.child_frame = "base";
  check_ten(read_reference(spec));
  spec.parent_frame = "map";
  check_ten(read_reference(spec));
  spec.child_frame = "camera";
  CHECK_THAT(data_error([&] { read_reference(spec); }),
             Catch::Contains("/tf: tells no pose; there are the frames base -> lidar, map -> base"));
  spec.parent_frame.clear();
  spec.child_frame.clear();
  spec.topic = "/tf";
  CHECK_THAT(data_error([&] { read_reference(spec); }),
             Catch::Contains("has several frames that fit: base -> lidar, map -> base; set `parent_frame`"));
}

TEST_CASE("messages that are too short are left out and told") {
  const TemporaryFolder folder;
  const auto cut = [](TimeNs t, double x) {
    Message m = pose(t, x);
    if (x == 4) m.bytes.resize(30);
    return m;
  };
  const Reference reference = read_reference(write(folder / "gt.bag", {{"/gt", "geometry_msgs/PoseStamped", cut}}));
  CHECK(reference.poses.size() == 9);
  CHECK(
      contains(reference.warnings, "1 messages cannot be read and are left out; message 5: the message is too short"));
}

TEST_CASE("poses are decoded from CDR as from ROS1") {
  for (const bool cdr : {false, true}) {
    Message message(cdr);
    message.add(std::uint32_t{2});
    message.header(kStart, "map").text("a").numbers({1, 2, 3, 0, 0, 0, 1});
    message.header(kStart + 1, "map").text("odd").numbers({4, 5, 6, 0, 0, 0, 1});
    std::vector<decode::ToldPose> told;
    const auto take = [&](const decode::ToldPose& p) { told.push_back(p); };
    const Encoding encoding = cdr ? Encoding::cdr : Encoding::ros1;
    CHECK(decode::decode_poses({message.bytes, encoding}, decode::PoseKind::transforms, take).empty());
    REQUIRE(told.size() == 2);
    CHECK(told[1].t == kStart + 1);
    CHECK(told[1].child == "odd");
    CHECK(told[1].p == Vec3(4, 5, 6));
    message.bytes.resize(message.bytes.size() - 1);
    CHECK_FALSE(decode::decode_poses({message.bytes, encoding}, decode::PoseKind::transforms, take).empty());
  }
}

}  // namespace aslio::io::test
