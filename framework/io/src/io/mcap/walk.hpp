#pragma once
/// Goes through the data section record by record.

#include "index.hpp"

namespace aslio::io::mcap {

class Walk {
 public:
  struct Plan {
    std::vector<ChunkIndex> chunks;  ///< by position: these are stepped over, and there are no others
    bool indexed = false;            ///< `chunks` is to be believed
    bool by_content = false;         ///< look into all chunks
  };
  /// Adds what it finds to `index`.
  Walk(const InputFile& file, const Limits& limits, const Frame& frame, const Plan& plan, Index& index)
      : file_(file), limits_(limits), frame_(frame), plan_(plan), index_(index), view_(file), loader_(file, limits) {}

  /// Returns what is wrong in the records or with the plan, at position(). Throws DataError for damage inside a chunk.
  std::string run();
  std::uint64_t position() const { return position_; }

 private:
  std::string step();
  std::string step_over_planned(const ChunkIndex& chunk);
  std::string take(const Record& record);
  std::string take_chunk(const Record& record, bool cut);
  std::string take_message(const Record& record);
  std::string take_message_index(const Record& record);
  std::string take_cut(const Record& record, Parsed parsed);
  void take_data_end(const Record& record);
  void take_footer(const Record& record);
  bool only_zeros_follow();
  void end_run();
  void end_chunk(bool cut);

  const InputFile& file_;
  const Limits& limits_;
  const Frame& frame_;
  const Plan& plan_;
  Index& index_;
  ByteView view_;
  ChunkLoader loader_;
  LoadedChunk scratch_;
  std::uint64_t position_ = 0;
  std::size_t planned_ = 0;  ///< chunks of the plan that were met
  bool behind_data_ = false, ended_ = false;
  std::optional<ChunkInfo> chunk_, run_;  ///< not finished yet
};

}  // namespace aslio::io::mcap
