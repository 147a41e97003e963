#include <algorithm>

#include "aslio/io/message_reader.hpp"

namespace aslio::io {
namespace {

class MergedReader final : public MessageReader {
 public:
  MergedReader(std::vector<std::unique_ptr<MessageReader>> parts, std::vector<std::string> warnings)
      : warnings_(std::move(warnings)) {
    for (auto& reader : parts) {
      Part& part = parts_.emplace_back();
      part.reader = std::move(reader);
      part.order = parts_.size();
      for (const Connection& c : part.reader->connections()) {
        Connection& all = connections_.emplace_back(c);
        all.id = static_cast<std::uint32_t>(connections_.size() - 1);
        owners_.push_back({parts_.size() - 1, c.id});
        part.global.emplace_back(c.id, all.id);
      }
    }
    collect_warnings();
    start_over();
  }

  std::string kind() const override {
    const std::string first = parts_.front().reader->kind();
    const bool alike =
        std::all_of(parts_.begin(), parts_.end(), [&](const Part& p) { return p.reader->kind() == first; });
    if (parts_.size() == 1) return first;
    return std::to_string(parts_.size()) + (alike ? " parts, each a " + first : " parts of several kinds");
  }
  const std::vector<Connection>& connections() const override { return connections_; }

  std::optional<TimeNs> begin_time() const override {
    std::optional<TimeNs> first;
    for (const Part& part : parts_) {
      if (const auto t = part.reader->begin_time()) first = std::min(first.value_or(*t), *t);
    }
    return first;
  }
  std::optional<TimeNs> end_time() const override {
    std::optional<TimeNs> last;
    for (const Part& part : parts_) {
      if (const auto t = part.reader->end_time()) last = std::max(last.value_or(*t), *t);
    }
    return last;
  }

  void select(std::span<const std::uint32_t> ids) override {
    std::vector<std::vector<std::uint32_t>> own(parts_.size());
    for (const std::uint32_t id : ids) {
      if (id < owners_.size()) own[owners_[id].part].push_back(owners_[id].id);
    }
    for (std::size_t i = 0; i < parts_.size(); ++i) parts_[i].reader->select(own[i]);
    start_over();
  }

  bool next(RawMessage& message) override {
    // The message handed out last belongs to this part: only now may the part go on.
    if (given_ != nullptr) {
      advance(*given_);
      given_ = nullptr;
    }
    open_due();
    if (heap_.empty()) return false;
    std::pop_heap(heap_.begin(), heap_.end(), later);
    given_ = heap_.back();
    heap_.pop_back();
    message = given_->head;
    return true;
  }

  InputStatus status() const override {
    const bool cut = std::any_of(parts_.begin(), parts_.end(),
                                 [](const Part& p) { return p.reader->status() == InputStatus::truncated; });
    return cut ? InputStatus::truncated : InputStatus::complete;
  }
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  struct Part {
    std::unique_ptr<MessageReader> reader;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> global;  ///< own id, id here; by own id
    std::size_t order = 0, told = 0;                              ///< told: of its warnings
    RawMessage head;
  };
  struct Owner {
    std::size_t part;
    std::uint32_t id;
  };

  /// Heap order: the earliest message on top; equal times by the order of the parts.
  static bool later(const Part* a, const Part* b) {
    return a->head.time != b->head.time ? a->head.time > b->head.time : a->order > b->order;
  }

  void start_over() {
    heap_.clear();
    given_ = nullptr;
    waiting_.clear();
    for (Part& part : parts_) waiting_.push_back(&part);
    std::stable_sort(waiting_.begin(), waiting_.end(), [](const Part* a, const Part* b) {
      return a->reader->begin_time().value_or(kTimeMax) > b->reader->begin_time().value_or(kTimeMax);
    });
  }

  /// Parts are read from the moment on at which they begin: of parts one after the other, one is held at a time.
  void open_due() {
    while (!waiting_.empty()) {
      Part& part = *waiting_.back();
      const TimeNs begin = part.reader->begin_time().value_or(kTimeMax);
      if (!heap_.empty() && begin > heap_.front()->head.time) return;
      waiting_.pop_back();
      advance(part);
    }
  }

  void advance(Part& part) {
    RawMessage message;
    const bool more = part.reader->next(message);
    collect_warnings_of(part);
    if (!more) return;
    const auto at = std::lower_bound(part.global.begin(), part.global.end(), std::pair(message.connection, 0U));
    message.connection = at->second;
    part.head = message;
    heap_.push_back(&part);
    std::push_heap(heap_.begin(), heap_.end(), later);
  }

  void collect_warnings() {
    for (Part& part : parts_) collect_warnings_of(part);
  }
  void collect_warnings_of(Part& part) {
    const auto& all = part.reader->warnings();
    for (; part.told < all.size(); ++part.told) warnings_.push_back(all[part.told]);
  }

  std::vector<Part> parts_;
  std::vector<Connection> connections_;
  std::vector<Owner> owners_;  ///< by id here
  std::vector<Part*> heap_, waiting_;
  Part* given_ = nullptr;
  std::vector<std::string> warnings_;
};

}  // namespace

std::unique_ptr<MessageReader> merge_messages(std::vector<std::unique_ptr<MessageReader>> parts,
                                              std::vector<std::string> warnings) {
  if (parts.size() == 1 && warnings.empty()) return std::move(parts.front());
  return std::make_unique<MergedReader>(std::move(parts), std::move(warnings));
}

}  // namespace aslio::io
