#pragma once

#include <optional>
#include <string>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/core/trajectory.hpp"
#include "aslio/stages/build_context.hpp"
#include "insertions/on_exit.hpp"

namespace aslio::plugins {

/// `at_reference`: as `on_exit`, but points enter where a known trajectory places them. The map then has no error of
/// the filter, and what is left of a run's error is that of IMU, points and window. For experiments alone. (INS-3)
///
/// The reference lies in a frame of its own: the end of the first update that it covers ties it to the frame of the
/// run. Points that it does not cover do not enter. Without a file it is `on_exit`.
class InsertAtReference final : public Insertion {
 public:
  struct Params {
    std::string file;
  };
  static void describe(config::Binder& b, Params& p);

  /// Throws DataError with file and line for a table that cannot be read, and names a column that is not there.
  InsertAtReference(const Params& params, const BuildContext& context);

  InsertCount begin(const Window& window, Map& map) override { return waiting_.begin(window, map); }
  /// Throws DataError when the reference covers nothing of the first update: it is of other data.
  InsertCount apply(const Window& window, const Update& update, Map& map) override;
  void finish(Map& map) override { waiting_.finish(map); }

 private:
  void place(const Window& window, const Update& update);

  std::string file_;
  Trajectory reference_;               ///< T_R_I in its own frame R
  std::optional<Pose> T_W_reference_;  ///< of the frame R in the frame of the run
  std::vector<WorldPoint> placed_;
  InsertOnExit waiting_;
};

}  // namespace aslio::plugins
