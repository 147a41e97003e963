// On the MCAP files in ASLIO_RECORDINGS_DIR/formats, as their writers made them. Missing data fail the test.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "aslio/core/sha256.hpp"
#include "io/mcap_conformance.hpp"
#include "recordings/unpacked.hpp"

namespace aslio::io::test {
namespace {

using Json = nlohmann::json;

Encoding encoding_of(const std::string& name) {
  if (name == "ros1") return Encoding::ros1;
  return name == "cdr" ? Encoding::cdr : Encoding::other;
}

/// What the records of a conformance file say, as a reader should tell it.
struct Expected {
  std::vector<Connection> connections;
  std::vector<Read> messages;
};

Expected expected_of(const Json& file) {
  Expected expected;
  std::map<std::string, Json> schemas;
  std::map<std::uint32_t, Connection> channels;
  for (const Json& record : file.at("records")) {
    const std::map<std::string, Json> fields = fields_of(record);
    const auto text = [&](const char* name) { return fields.at(name).get<std::string>(); };
    const auto number = [&](const char* name) { return std::stoll(text(name)); };
    if (record.at("type") == "Schema") {
      schemas[text("id")] = fields;
    } else if (record.at("type") == "Channel") {
      Connection channel;
      channel.id = static_cast<std::uint32_t>(number("id"));
      channel.topic = text("topic");
      channel.encoding = encoding_of(text("message_encoding"));
      channel.md5 = fields.at("metadata").value("md5sum", "");
      if (text("schema_id") != "0") {
        const Json& schema = schemas.at(text("schema_id"));
        channel.type = schema.at("name").get<std::string>();
        const ByteVector data = bytes_of(schema.at("data"));
        channel.definition.assign(data.begin(), data.end());
      }
      channels[channel.id] = channel;
    } else if (record.at("type") == "Message") {
      expected.messages.push_back(
          {static_cast<std::uint32_t>(number("channel_id")), number("log_time"), bytes_of(fields.at("data"))});
    }
  }
  for (const auto& [id, channel] : channels) expected.connections.push_back(channel);
  std::stable_sort(expected.messages.begin(), expected.messages.end(),
                   [](const Read& a, const Read& b) { return a.time < b.time; });
  return expected;
}

bool alike(const Connection& a, const Connection& b) {
  return std::tie(a.id, a.topic, a.type, a.md5, a.definition, a.encoding) ==
         std::tie(b.id, b.topic, b.type, b.md5, b.definition, b.encoding);
}

std::size_t count_of(const std::vector<Read>& all, const MessageReader& reader, const std::string& topic) {
  return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [&](const Read& read) {
    return std::any_of(reader.connections().begin(), reader.connections().end(),
                       [&](const Connection& c) { return c.id == read.connection && c.topic == topic; });
  }));
}

}  // namespace

TEST_CASE("all conformance files of MCAP are read as their records say") {
  TemporaryFolder folder;
  std::size_t files = 0, messages = 0;
  for (const auto& entry : std::filesystem::directory_iterator(aslio::test::recorded("formats/mcap/conformance"))) {
    if (entry.path().extension() != ".json") continue;
    const std::string name = entry.path().stem().string() + ".mcap";
    INFO(name);
    const Json records = Json::parse(std::ifstream(entry.path()));
    std::filesystem::path path = entry.path().parent_path() / name;
    // A checkout without large files has their sizes and SHA-256 in their place: the file is made from its records
    // then.
    if (const ByteVector pointer = read_bytes(path); !pointer.empty() && pointer.front() == 'v') {
      write_bytes(folder / name, conformance_file(records));
      path = folder / name;
      REQUIRE(contains(std::string(pointer.begin(), pointer.end()), "sha256:" + sha256_of_file(path)));
    }
    const auto reader = open_messages(path);
    const Expected expected = expected_of(records);
    const std::vector<Read> read = read_messages(*reader);
    REQUIRE(read == expected.messages);
    REQUIRE(std::equal(reader->connections().begin(), reader->connections().end(), expected.connections.begin(),
                       expected.connections.end(), alike));
    REQUIRE(reader->begin_time().has_value() == !read.empty());
    if (!read.empty()) {
      REQUIRE(*reader->begin_time() == read.front().time);
      REQUIRE(*reader->end_time() == read.back().time);
    }
    REQUIRE(reader->status() == InputStatus::complete);
    REQUIRE_FALSE(contains(reader->warnings(), "damaged"));
    ++files;
    messages += read.size();
  }
  CHECK(files == 416);
  CHECK(messages == 1768);
}

TEST_CASE("an MCAP file of an Ouster, made from a bag of ROS1, is read whole") {
  const auto reader = open_messages(aslio::test::recorded("formats/mcap/ouster_ros1msg_zstd.mcap"));
  const std::vector<Read> all = read_messages(*reader);
  CHECK(count_of(all, *reader, "/os1_cloud_node/points") == 2);
  CHECK(count_of(all, *reader, "/os1_cloud_node/imu") == 17);
  CHECK(reader->connections().size() == 11);
  CHECK(reader->connections()[5].md5 == "6a62c6daae103f4ff57a132d6f95cec2");
  CHECK(reader->connections()[5].encoding == Encoding::ros1);
  CHECK(*reader->begin_time() == 1'592'833'242'605'385'634);
  CHECK(*reader->end_time() == 1'592'833'242'788'158'073);
  CHECK(std::is_sorted(all.begin(), all.end(), [](const Read& a, const Read& b) { return a.time < b.time; }));
  CHECK(reader->status() == InputStatus::complete);
  CHECK(reader->warnings().empty());
}

TEST_CASE("MCAP files as rosbag2 writes them are read whole") {
  std::size_t files = 0, messages = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(aslio::test::recorded("formats/db3/tool_bags"))) {
    if (entry.path().extension() != ".mcap") continue;
    INFO(entry.path().string());
    const auto reader = open_messages(entry.path());
    const std::vector<Read> read = read_messages(*reader);
    CHECK(reader->status() == InputStatus::complete);
    CHECK_FALSE(contains(reader->warnings(), "damaged"));
    for (const Connection& c : reader->connections()) CHECK(!c.topic.empty());
    ++files;
    messages += read.size();
  }
  CHECK(files == 20);
  CHECK(messages == 9782);
}

}  // namespace aslio::io::test
