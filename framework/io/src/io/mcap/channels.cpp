#include "channels.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"

namespace aslio::io::mcap {
namespace {

constexpr std::uint64_t kPerEntry = 256;  ///< what an entry takes beside its texts, about

std::uint64_t bytes_of(const Schema& schema) {
  return kPerEntry + schema.name.size() + schema.encoding.size() + schema.data.size();
}

std::uint64_t bytes_of(const Channel& channel) {
  std::uint64_t bytes = kPerEntry + channel.topic.size() + channel.encoding.size();
  for (const auto& [key, value] : channel.metadata) bytes += kPerEntry + key.size() + value.size();
  return bytes;
}

Encoding encoding_of(const Channel& channel) {
  if (channel.encoding == "ros1") return Encoding::ros1;
  return channel.encoding == "cdr" ? Encoding::cdr : Encoding::other;
}

}  // namespace

ChannelTable::ChannelTable(std::string file, const Limits& limits)
    : file_(std::move(file)), most_bytes_(limits.description_bytes) {}

void ChannelTable::count(std::uint64_t bytes, std::uint64_t& sum) const {
  sum += bytes;
  if (sum <= most_bytes_) return;
  throw DataError(
      fmt::format("{}: the descriptions of its channels take more than {} bytes, the limit of this reader; write the "
                  "topics you need to a file of their own: `mcap filter IN -o OUT -y TOPIC`",
                  file_, most_bytes_));
}

std::string ChannelTable::compare(const Schema& schema) const {
  const auto known = schemas_.find(schema.id);
  if (known == schemas_.end() || known->second == schema) return {};
  return fmt::format("schema {} is described twice, with different content", schema.id);
}

std::string ChannelTable::compare(const Channel& channel) const {
  const auto known = channels_.find(channel.id);
  if (known == channels_.end() || known->second == channel) return {};
  return fmt::format("channel {} is described twice, with different content", channel.id);
}

std::string ChannelTable::add(Schema schema) {
  // A schema of id 0 is none; the specification asks readers to step over it.
  if (schema.id == 0) return {};
  if (schemas_.contains(schema.id)) return compare(schema);
  count(bytes_of(schema), bytes_);
  schemas_.emplace(schema.id, std::move(schema));
  return {};
}

std::string ChannelTable::add(Channel channel) {
  if (channels_.contains(channel.id)) return compare(channel);
  count(bytes_of(channel), bytes_);
  known_.resize(std::max<std::size_t>(known_.size(), channel.id + 1U));
  known_[channel.id] = true;
  channels_.emplace(channel.id, std::move(channel));
  return {};
}

bool ChannelTable::complete() const {
  return std::all_of(channels_.begin(), channels_.end(), [&](const auto& entry) {
    return entry.second.schema == 0 || schemas_.contains(entry.second.schema);
  });
}

std::vector<Connection> ChannelTable::connections() const {
  std::vector<Connection> all;
  std::uint64_t bytes = 0;
  for (const auto& [id, channel] : channels_) {
    Connection connection;
    connection.id = id;
    connection.topic = channel.topic;
    connection.encoding = encoding_of(channel);
    if (const auto md5 = channel.metadata.find("md5sum"); md5 != channel.metadata.end()) connection.md5 = md5->second;
    if (const auto schema = schemas_.find(channel.schema); schema != schemas_.end()) {
      count(schema->second.data.size(), bytes);
      connection.type = schema->second.name;
      connection.definition = schema->second.data;
    }
    all.push_back(std::move(connection));
  }
  return all;
}

}  // namespace aslio::io::mcap
