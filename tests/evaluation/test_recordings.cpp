#include <catch2/catch.hpp>
#include <filesystem>

#include "aslio/evaluation/evaluation.hpp"
#include "evaluation/tum.hpp"

namespace {

using namespace aslio;
using namespace aslio::evaluation;

/// What the recording's own README states of a system.
struct Published {
  const char* file;
  double ate_m, end_to_end_cm, rotation_deg;
};

}  // namespace

TEST_CASE("the published figures of five systems on avia_corridor come out again") {
  const std::filesystem::path folder = ASLIO_RECORDINGS_DIR;
  const Trajectory truth = test::read_tum(folder / "avia_corridor.gt.tum");
  for (const Published& published : {Published{"fast_lio2.tum", 0.100, 5.8, 1.07},
                                     {"fast_lio2_blind_0.5.tum", 0.062, 7.7, 0.74},
                                     {"point_lio.tum", 0.053, 2.0, 0.81},
                                     {"faster_lio.tum", 0.042, 3.0, 1.03},
                                     {"rko_lio_voxel_0.5.tum", 0.158, 1.5, 2.07}}) {
    INFO(published.file);
    const Trajectory estimate = test::read_tum(folder / "reference/avia_corridor" / published.file);

    Options options;
    options.weight_by_time = false;  // as they were computed
    const Evaluation evaluation = evaluate(estimate, truth, options);
    CHECK(evaluation.unmatched == 0);
    CHECK(evaluation.ate.translation.rmse == Approx(published.ate_m).margin(0.00051));
    // The published rotation leaves out a constant offset of the body frame.
    CHECK(evaluation.ate_deg_body_offset_removed == Approx(published.rotation_deg).margin(0.0051));
    CHECK(evaluation.ate_deg_rotation_aligned < evaluation.ate.rotation.rmse);
    CHECK(100.0 * evaluation.end_to_end.distance == Approx(published.end_to_end_cm).margin(0.051));
    CHECK(100.0 * evaluation.end_to_end.error == Approx(published.end_to_end_cm).margin(0.1));  // the loop is closed
    REQUIRE(evaluation.ate_turns.has_value());
    CHECK(evaluation.reference_path == Approx(21.0326).margin(1e-3));
  }
}
