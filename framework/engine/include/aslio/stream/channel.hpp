#pragma once
/// What one sensor sends, from its arrival until it is known whether its stamps are right.

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "aslio/stream/arrival.hpp"

namespace aslio::stream {

/// `T` is a message or sample. It has, found by argument-dependent lookup: `begin_of(T)` and `end_of(T)`, the times
/// that it spans [ns], and `are_copies(T, T)`.
template <class T>
class Channel {
 public:
  explicit Channel(std::string what) : guard_(std::move(what)) {}

  /// Of what was taken; kTimeMin: nothing yet.
  TimeNs newest() const { return newest_; }
  void note_taken(TimeNs end) { newest_ = std::max(newest_, end); }
  void forget_newest() { newest_ = kTimeMin; }

  /// Whether a copy of it waits for others that confirm its stamp.
  bool holds_copy_of(const T& arrived) const {
    return std::any_of(held_.begin(), held_.end(), [&](const T& held) { return are_copies(held, arrived); });
  }
  /// What was held, where `arrived` confirms that it came after a pause: to be taken before it. Else nothing.
  std::vector<T> confirmed_by(const T& arrived) {
    return guard_.confirms(begin_of(arrived), end_of(arrived)) ? std::exchange(held_, {}) : std::vector<T>{};
  }
  bool implausible(const T& arrived) const {
    return newest_ != kTimeMin && guard_.implausible(begin_of(arrived), end_of(arrived), newest_);
  }
  /// `sole`: only one measurement has been taken so far.
  JumpGuard::Verdict judge(const T& arrived, bool sole) {
    if (newest_ == kTimeMin) return JumpGuard::Verdict::take;
    return guard_.judge(begin_of(arrived), end_of(arrived), newest_, sole);
  }
  void hold(T&& arrived) { held_.push_back(std::move(arrived)); }
  /// What was held had wild stamps. Returns how many those were.
  std::uint64_t drop_held() { return std::exchange(held_, {}).size(); }
  /// What is held, taken out, if the other sensor went on to `other`: a pause that it knows of as well.
  std::vector<T> held_before(TimeNs other) {
    const bool pause = !held_.empty() && other > begin_of(held_.front()) - kMaxStepBack;
    return pause ? std::exchange(held_, {}) : std::vector<T>{};
  }

  /// Its clock has jumped, and it is not known yet whether that of the other sensor has.
  bool jumped() const { return jumped_; }
  /// How far, ahead where it is positive [ns]. Pre: jumped().
  TimeNs jump() const { return jump_; }
  /// Keeps what came after the jump. Pre: the last verdict was `jumped`. Returns the time that it spans by now [ns].
  TimeNs keep_after_jump(T&& arrived) {
    if (!jumped_) jump_ = guard_.jumped_to() - newest_;
    jumped_ = true;
    after_jump_.push_back(std::move(arrived));
    return end_of(after_jump_.back()) - begin_of(after_jump_.front());
  }
  /// It has come back to its clock of before.
  void forget_jump() {
    jumped_ = false;
    after_jump_.clear();
  }
  /// All of it is judged by itself from now on. Returns what came after the jump.
  std::vector<T> begin_again() {
    jumped_ = false;
    held_.clear();
    guard_.forget();
    return std::exchange(after_jump_, {});
  }
  /// Throws the DataError of a clock that jumped alone.
  [[noreturn]] void fail() const { guard_.fail(newest_); }

 private:
  JumpGuard guard_;
  std::vector<T> held_, after_jump_;
  bool jumped_ = false;
  TimeNs jump_ = 0, newest_ = kTimeMin;
};

}  // namespace aslio::stream
