"""The rule of floor on results made by hand."""
import math
import random
import unittest
from types import SimpleNamespace

from hand_made_study import StudyCase

import shares
import study_folder

METHODS = ("as_lio_plus", "true_map", "true_map_10", "true_map_125")


class Shares(StudyCase):
    def table(self, factors, lost=()):
        """The rows by name. `factors`: of the error 0.01 m, by (method, IMU)."""
        draw = random.Random(3)
        runs = []
        for kind in range(9):
            for seed in range(4):
                for imu in ("datasheet", "perfect"):
                    for method in METHODS:
                        value = 0.01 * factors.get((method, imu), factors.get(method, 1.0)) * math.exp(draw.gauss(0, 0.02))
                        name = f"scene_{kind}_{imu}"
                        gone = (kind, seed, imu, method) in lost
                        runs.append((name, seed, method, None, "lost") if gone else (name, seed, method, value))
        study = study_folder.Study(self.study("floor", runs))
        options = SimpleNamespace(baseline="as_lio_plus", windows=list(METHODS[1:]), metric="ate_m", worlds=["_datasheet", "_perfect"])
        return {row[0]: row for row in shares.rows(study, options)}

    def test_each_share_is_what_its_change_takes_away(self):
        table = self.table({"as_lio_plus": 1.0, "true_map": 0.3, "true_map_10": 0.4, "true_map_125": 0.3,
                            ("true_map", "perfect"): 0.1, ("true_map_10", "perfect"): 0.1, ("true_map_125", "perfect"): 0.1})
        self.assertEqual(table["map_datasheet"][1], 36)
        self.assertAlmostEqual(float(table["map_datasheet"][3]), 7.0, delta=0.2)
        self.assertEqual(table["map_datasheet"][-1], "shown")
        self.assertAlmostEqual(float(table["IMU, on the true map"][3]), 2.0, delta=0.1)
        window = next(row for name, row in table.items() if name.startswith("window") and name.endswith("_datasheet"))
        self.assertTrue(window[0].startswith("window: true_map_10 to "))
        self.assertAlmostEqual(float(window[3]), 1.0, delta=0.1)
        self.assertAlmostEqual(float(table["left on the true map_perfect"][3]), 1.0, delta=0.1)

    def test_noise_is_not_shown(self):
        self.assertEqual(self.table({})["IMU, on the true map"][-1], "not shown")

    def test_a_harm_is_shown_with_its_sign(self):
        row = self.table({"true_map": 1.5})["map_datasheet"]
        self.assertEqual(row[-1], "shown")
        self.assertLess(float(row[3]), 0)

    def test_lost_runs_are_borne_by_the_median(self):
        lost = {(kind, 0, "datasheet", "true_map") for kind in range(9)}
        table = self.table({"true_map": 0.3}, lost)
        self.assertEqual(table["map_datasheet"][1], 36)
        self.assertAlmostEqual(float(table["map_datasheet"][3]), 7.0, delta=0.3)

    def test_a_world_that_both_lose_is_left_out_and_counted(self):
        lost = {(0, seed, "datasheet", method) for seed in range(4) for method in ("as_lio_plus", "true_map")}
        self.assertEqual(self.table({"true_map": 0.3}, lost)["map_datasheet"][1:3], [32, 4])

    def test_the_largest_of_several_pairs_needs_more(self):
        values = [0.01 * k for k in range(-10, 26)]
        self.assertGreater(shares.interval(values)[1], shares.interval(values, 1000)[1])
        self.assertTrue(math.isnan(shares.interval([math.inf, -math.inf])[1]))

    def test_few_worlds_decide_nothing(self):
        worlds = {("scene", str(seed)): 0.01 for seed in range(5)}
        self.assertEqual(shares.row("map", worlds, dict.fromkeys(worlds, 0.001), 0.01)[-1], "not decided")

    def test_a_method_that_is_missing_is_named(self):
        study = study_folder.Study(self.study("floor", [("scene_datasheet", 1, "true_map", 0.1)]))
        options = SimpleNamespace(baseline="as_lio_plus", windows=list(METHODS[1:]), metric="ate_m", worlds=["_datasheet", "_perfect"])
        with self.assertRaisesRegex(study_folder.FolderError, "no run of as_lio_plus"):
            list(shares.rows(study, options))


if __name__ == "__main__":
    unittest.main()
