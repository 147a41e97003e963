#include "io/mcap_conformance.hpp"

#include <zlib.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace aslio::io::test {
namespace {

using Json = nlohmann::json;
using Fields = std::map<std::string, Json>;

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
/// Kinds by code.
const std::vector<std::string> kKinds{"",           "Header",        "Footer",          "Schema",
                                      "Channel",    "Message",       "Chunk",           "MessageIndex",
                                      "ChunkIndex", "Attachment",    "AttachmentIndex", "Statistics",
                                      "Metadata",   "MetadataIndex", "SummaryOffset",   "DataEnd"};
/// What each kind holds in which order: `name:type`, of types b, h, i, q (unsigned integers of 1, 2, 4, 8 bytes), s
/// (text), d (bytes), D (bytes with a length of 8 bytes), r (bytes to the end), m (map of texts), n (map of channels to
/// numbers).
const std::map<std::string, std::string> kLayouts{
    {"Header", "profile:s library:s"},
    {"Footer", "summary_start:q summary_offset_start:q summary_crc:i"},
    {"Schema", "id:h name:s encoding:s data:d"},
    {"Channel", "id:h schema_id:h topic:s message_encoding:s metadata:m"},
    {"Message", "channel_id:h sequence:i log_time:q publish_time:q data:r"},
    {"ChunkIndex",
     "message_start_time:q message_end_time:q chunk_start_offset:q chunk_length:q message_index_offsets:n "
     "message_index_length:q compression:s compressed_size:q uncompressed_size:q"},
    {"Attachment", "log_time:q create_time:q name:s media_type:s data:D"},
    {"AttachmentIndex", "offset:q length:q log_time:q create_time:q data_size:q name:s media_type:s"},
    {"Statistics",
     "message_count:q schema_count:h channel_count:i attachment_count:i metadata_count:i chunk_count:i "
     "message_start_time:q message_end_time:q channel_message_counts:n"},
    {"Metadata", "name:s metadata:m"},
    {"MetadataIndex", "offset:q length:q name:s"},
    {"SummaryOffset", "group_opcode:b group_start:q group_length:q"},
    {"DataEnd", "data_section_crc:i"}};

std::uint64_t number_of(const Json& text) { return std::stoull(text.get<std::string>()); }

std::uint32_t crc_of(const ByteVector& bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

void pack(Packed& out, const Json& value, char type) {
  Packed inside;
  switch (type) {
    case 'b':
      out.number(static_cast<std::uint8_t>(number_of(value)));
      break;
    case 'h':
      out.number(static_cast<std::uint16_t>(number_of(value)));
      break;
    case 'i':
      out.number(static_cast<std::uint32_t>(number_of(value)));
      break;
    case 'q':
      out.number(number_of(value));
      break;
    case 's':
      out.text(value.get<std::string>());
      break;
    case 'd':
      out.number(static_cast<std::uint32_t>(value.size())).raw(bytes_of(value));
      break;
    case 'D':
      out.number(static_cast<std::uint64_t>(value.size())).raw(bytes_of(value));
      break;
    case 'r':
      out.raw(bytes_of(value));
      break;
    case 'm':
      out.map(value.get<std::map<std::string, std::string>>());
      break;
    default:
      for (const auto& [key, number] : value.items()) {
        inside.number(static_cast<std::uint16_t>(std::stoul(key))).number(number_of(number));
      }
      out.number(static_cast<std::uint32_t>(inside.bytes().size())).raw(inside.bytes());
  }
}

ByteVector content_of(const std::string& kind, const Fields& fields) {
  Packed out;
  std::string_view layout = kLayouts.at(kind);
  while (!layout.empty()) {
    const std::size_t colon = layout.find(':');
    pack(out, fields.at(std::string(layout.substr(0, colon))), layout[colon + 1]);
    layout.remove_prefix(std::min(colon + 3, layout.size()));
  }
  if (kind == "Attachment") out.number(crc_of(out.bytes()));
  return out.bytes();
}

/// A chunk that is not compressed, and its message indexes.
struct Chunk {
  ByteVector records;
  std::map<std::uint16_t, Packed> entries;  ///< by channel
  std::uint64_t begin = ~std::uint64_t{0}, end = 0;

  void add(std::uint8_t op, const ByteVector& content, const Fields& fields) {
    if (kKinds[op] == "Message") {
      const std::uint64_t time = number_of(fields.at("log_time"));
      const auto channel = static_cast<std::uint16_t>(number_of(fields.at("channel_id")));
      entries[channel].number(time).number(static_cast<std::uint64_t>(records.size()));
      begin = std::min(begin, time);
      end = std::max(end, time);
    }
    append_record(records, op, content);
  }

  void write(ByteVector& out, bool indexed, const ByteVector& padding) const {
    const std::uint64_t size = records.size();
    Packed content;
    content.number(entries.empty() ? 0 : begin).number(end).number(size).number(crc_of(records)).text("");
    append_record(out, 0x06, content.number(size).raw(records).bytes());
    for (const auto& [channel, places] : entries) {
      Packed index;
      index.number(channel).number(static_cast<std::uint32_t>(places.bytes().size())).raw(places.bytes()).raw(padding);
      if (indexed) append_record(out, 0x07, index.bytes());
    }
  }
};

}  // namespace

Fields fields_of(const Json& record) {
  Fields fields;
  for (const Json& field : record.at("fields")) fields[field.at(0).get<std::string>()] = field.at(1);
  return fields;
}

ByteVector bytes_of(const Json& texts) {
  ByteVector out;
  for (const Json& text : texts) out.push_back(static_cast<std::uint8_t>(number_of(text)));
  return out;
}

ByteVector conformance_file(const Json& file) {
  const auto features = file.at("meta").at("variant").at("features").get<std::vector<std::string>>();
  const auto has = [&](const char* name) {
    return std::find(features.begin(), features.end(), name) != features.end();
  };
  // Fields of later versions, behind those that are known.
  const ByteVector padding = has("pad") ? ByteVector{0x01, 0xFF, 0xFF} : ByteVector{};
  ByteVector out(kMagic.begin(), kMagic.end());
  Chunk chunk;
  bool data = true;
  for (const Json& record : file.at("records")) {
    const auto kind = record.at("type").get<std::string>();
    const auto op = static_cast<std::uint8_t>(std::find(kKinds.begin(), kKinds.end(), kind) - kKinds.begin());
    const Fields fields = fields_of(record);
    ByteVector content = content_of(kind, fields);
    if (data && has("ch") && (kind == "Schema" || kind == "Channel" || kind == "Message")) {
      chunk.add(op, content, fields);
      continue;
    }
    if (kind == "DataEnd") {
      data = false;
      if (!chunk.records.empty()) chunk.write(out, has("mx"), padding);
    } else if (kind != "Footer" && kind != "Message") {
      content.insert(content.end(), padding.begin(), padding.end());
    }
    append_record(out, op, content);
  }
  out.insert(out.end(), kMagic.begin(), kMagic.end());
  return out;
}

}  // namespace aslio::io::test
