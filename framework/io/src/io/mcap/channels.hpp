#pragma once
/// The channels of a file and their schemas.

#include <vector>

#include "aslio/io/message_reader.hpp"
#include "reader.hpp"
#include "record.hpp"

namespace aslio::io::mcap {

class ChannelTable {
 public:
  /// `file`: its name, for errors.
  ChannelTable(std::string file, const Limits& limits);

  /// Both return what is wrong: a second description of an id that differs from the first. Throws DataError where the
  /// descriptions take more memory than the limits allow.
  std::string add(Schema schema);
  std::string add(Channel channel);
  /// As add(), but what is not known yet stays so.
  std::string compare(const Schema& schema) const;
  std::string compare(const Channel& channel) const;

  bool contains(std::uint32_t id) const { return id < known_.size() && known_[id]; }
  /// Whether the schemas of all channels are known.
  bool complete() const;
  /// By id. Channels whose schema is not known have no type. Throws DataError as add().
  std::vector<Connection> connections() const;

 private:
  void count(std::uint64_t bytes, std::uint64_t& sum) const;

  std::string file_;
  std::uint64_t most_bytes_, bytes_ = 0;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<bool> known_;  ///< by id of a channel
};

}  // namespace aslio::io::mcap
