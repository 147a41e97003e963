#include "aslio/config/binder.hpp"
#include "aslio/simulator/return_model.hpp"

namespace aslio::simulator {

void LidarParams::describe(config::Binder& b, LidarParams& p) {
  b.flag("noise", p.noise, "false: exact ranges and directions, nothing lost or added at random");
  b.optional_real("range_noise", p.range_noise, "m", {.min = 0.0, .max = 1.0}, "= that of the sensor",
                  "standard deviation of a range");
  b.optional_real("angle_noise", p.angle_noise, "deg", {.min = 0.0, .max = 5.0}, "= that of the sensor",
                  "standard deviation of a beam's direction, azimuth and elevation each");
  b.optional_real("min_range", p.min_range, "m", {.min = 0.0, .max = 100.0}, "= that of the sensor",
                  "nothing nearer is reported");
  b.optional_real("max_range", p.max_range, "m", {.above = 0.0, .max = 1000.0}, "= that of the sensor",
                  "nothing farther is reported");
  b.integer("columns", p.columns, "1", {.min = 100.0, .max = 10000.0},
            "firings per turn of a spinning sensor: 400, 500, 800, 1000, 2000, ..; others have none");
  b.require(may_be_columns(p.columns), "columns",
            "must end with every 10 ms: 400, 500, 800, 1000, 1250, 1600, 2000, ..");
  b.real("dropout", p.dropout, "1", {.min = 0.0, .max = 1.0}, "share of pulses lost at random");
  b.real("outliers", p.outliers, "1", {.min = 0.0, .max = 1.0},
         "share of returns at a random range before the surface");
  b.real("mixed", p.mixed, "1", {.min = 0.0, .max = 1.0},
         "share of pulses whose footprint is followed to a second surface");
  b.real("grazing_begin", p.grazing_begin, "deg", {.min = 0.0, .max = 90.0},
         "incidence from which returns begin to be lost");
  b.real("grazing_end", p.grazing_end, "deg", {.min = 0.0, .max = 90.0}, "incidence from which all are");
  b.require(p.grazing_end > p.grazing_begin, "grazing_end", "must be above grazing_begin");
  b.real("weak_range", p.weak_range, "m", {.above = 0.0, .max = 10000.0},
         "range up to which a surface of reflectivity 0.1 returns; grows with the square root of the reflectivity");
}

}  // namespace aslio::simulator
