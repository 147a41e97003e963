#include "walk.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace aslio::io::mcap {
namespace {

/// Messages outside chunks are held as runs of so many, as far as their place and time go.
constexpr std::uint64_t kRunMessages = 4096;

void add_sorted(std::vector<std::uint32_t>& ids, std::uint32_t id) {
  const auto at = std::lower_bound(ids.begin(), ids.end(), id);
  if (at == ids.end() || *at != id) ids.insert(at, id);
}

}  // namespace

std::string Walk::run() {
  for (position_ = frame_.first_record; position_ < frame_.end && !ended_;) {
    std::string why = step();
    if (!why.empty()) return why;
  }
  if (!ended_ && !frame_.closed) index_.status = InputStatus::truncated;
  end_run();
  end_chunk(false);
  if (planned_ < plan_.chunks.size()) {
    return fmt::format("it names a chunk at offset {} where none begins", plan_.chunks[planned_].position);
  }
  return {};
}

std::string Walk::step() {
  if (planned_ < plan_.chunks.size() && plan_.chunks[planned_].position <= position_) {
    return step_over_planned(plan_.chunks[planned_]);
  }
  Record record;
  const Parsed parsed = parse_record(view_, position_, frame_.end, record);
  if (behind_data_ && parsed != Parsed::ok) {
    // No message stands there: at worst the index is lost.
    position_ = frame_.end;
    return {};
  }
  if (parsed == Parsed::no_record) {
    if (frame_.closed || !only_zeros_follow()) return "a record of kind 0";
    // A file system that lost the end of a file fills it with zeros.
    return take_cut(record, Parsed::head_cut);
  }
  if (parsed != Parsed::ok) return take_cut(record, parsed);
  std::string why = take(record);
  if (why.empty()) position_ = record.next();
  return why;
}

std::string Walk::step_over_planned(const ChunkIndex& chunk) {
  if (chunk.position != position_) {
    return fmt::format("it names a chunk at offset {} where none begins", chunk.position);
  }
  end_run();
  end_chunk(false);
  chunk_ = ChunkInfo{chunk.position, chunk.begin, chunk.end, chunk.channels, 0, 0};
  ++planned_;
  position_ += chunk.bytes + chunk.index_bytes;
  return {};
}

std::string Walk::take(const Record& record) {
  if (record.op == Op::footer) {
    take_footer(record);
    return {};
  }
  if (behind_data_) return {};
  switch (record.op) {
    case Op::schema:
    case Op::channel:
      return learn_description(view_, record, limits_, index_.channels);
    case Op::message:
      return take_message(record);
    case Op::chunk:
      return take_chunk(record, false);
    case Op::message_index:
      return take_message_index(record);
    case Op::data_end:
      take_data_end(record);
      return {};
    case Op::header:
      return "a second header";
    case Op::chunk_index:
    case Op::attachment:
    case Op::attachment_index:
    case Op::statistics:
    case Op::metadata:
    case Op::metadata_index:
    case Op::summary_offset:
    default:
      return {};
  }
}

std::string Walk::take_chunk(const Record& record, bool cut) {
  if (plan_.indexed) return "it lacks a chunk that is there";
  end_run();
  end_chunk(false);
  const std::optional<ChunkHead> head = parse_chunk_head(view_, record);
  if (!head) return cut ? std::string{} : "the fields of a chunk do not fit its length";
  chunk_ = ChunkInfo{record.position, head->begin, head->end, {}, 0, 0};
  return {};
}

std::string Walk::take_message_index(const Record& record) {
  if (!chunk_ || plan_.indexed) return {};
  const std::size_t bytes = static_cast<std::size_t>(std::min<std::uint64_t>(record.data_bytes, 6));
  Fields fields({view_.at(record.data_begin, bytes), bytes});
  const auto channel = fields.number<std::uint16_t>();
  const auto entries = fields.number<std::uint32_t>();
  if (!fields.whole()) return "a message index is shorter than its fields";
  if (entries > 0) add_sorted(chunk_->connections, channel);
  return {};
}

std::string Walk::take_message(const Record& record) {
  if (record.data_bytes < kMessageFields) return fmt::format("a message record has {} bytes", record.data_bytes);
  check_message_length(file_, record, limits_);
  // Its channel may be described in the chunk before it.
  end_chunk(false);
  const MessageHead head = parse_message_head(view_.at(record.data_begin, kMessageFields));
  if (!index_.channels.contains(head.channel)) {
    return fmt::format("a message names channel {}, which does not exist", head.channel);
  }
  if (!head.time) return "a message has a time of 2^63 ns or more";
  if (run_ && run_->messages >= kRunMessages) end_run();
  if (!run_) run_ = ChunkInfo{record.position, *head.time, *head.time, {}, 0, 0};
  run_->begin = std::min(run_->begin, *head.time);
  run_->end = std::max(run_->end, *head.time);
  run_->file_end = record.next();
  ++run_->messages;
  add_sorted(run_->connections, head.channel);
  return {};
}

std::string Walk::take_cut(const Record& record, Parsed parsed) {
  if (frame_.closed) {
    return fmt::format("a record claims {} bytes where {} are left", record.data_bytes,
                       frame_.end - std::min(frame_.end, record.data_begin));
  }
  index_.status = InputStatus::truncated;
  position_ = frame_.end;
  if (parsed != Parsed::data_cut || record.op != Op::chunk) return {};
  std::string why = take_chunk(record, true);
  if (why.empty()) end_chunk(true);
  return why;
}

void Walk::take_data_end(const Record& record) {
  const std::size_t bytes = static_cast<std::size_t>(std::min<std::uint64_t>(record.data_bytes, 4));
  Fields fields({view_.at(record.data_begin, bytes), bytes});
  index_.checksum = DataChecksum(record.position, fields.number<std::uint32_t>());
  behind_data_ = true;
}

/// One that is not where the last is: something was appended, or the file is cut behind it.
void Walk::take_footer(const Record& record) {
  ended_ = true;
  const bool whole = file_.size() - record.next() >= kMagic.size() &&
                     std::memcmp(view_.at(record.next(), kMagic.size()), kMagic.data(), kMagic.size()) == 0;
  if (!whole) {
    index_.status = InputStatus::truncated;
    return;
  }
  index_.warnings.push_back(fmt::format("{} bytes behind the end of the recording, at offset {}, are not read",
                                        file_.size() - record.next() - kMagic.size(), record.next() + kMagic.size()));
}

bool Walk::only_zeros_follow() {
  constexpr std::uint64_t kPiece = 4096;
  for (std::uint64_t at = position_; at < frame_.end;) {
    const std::size_t count = static_cast<std::size_t>(std::min(kPiece, frame_.end - at));
    const std::uint8_t* bytes = view_.at(at, count);
    if (std::any_of(bytes, bytes + count, [](std::uint8_t byte) { return byte != 0; })) return false;
    at += count;
  }
  return true;
}

void Walk::end_run() {
  if (run_) index_.chunks.push_back(std::move(*run_));
  run_.reset();
}

/// Looks into the chunk where what stands around it does not tell enough.
void Walk::end_chunk(bool cut) {
  if (!chunk_) return;
  ChunkInfo info = std::move(*chunk_);
  chunk_.reset();
  const bool known = !info.connections.empty() && info.begin <= info.end && index_.channels.complete() &&
                     std::all_of(info.connections.begin(), info.connections.end(),
                                 [&](std::uint32_t id) { return index_.channels.contains(id); });
  // A cut may have taken some of the message indexes of the last chunk.
  if (!known || plan_.by_content || index_.status == InputStatus::truncated) {
    loader_.load(info, {.may_be_cut = cut, .learn = true}, index_.channels, scratch_);
    if (scratch_.entries.empty()) return;
    info.begin = scratch_.begin;
    info.end = scratch_.end;
    info.connections = scratch_.connections;
  }
  index_.chunks.push_back(std::move(info));
}

}  // namespace aslio::io::mcap
