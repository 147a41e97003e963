"""The rules of where_it_pays and starvation on results made by hand."""
import math
import random
import unittest

from hand_made_study import StudyCase, printed

import conditions
import study_folder


class Conditions(StudyCase):
    def results(self, effect, lost=()):
        """Ratios of `adaptive` to `steady`: exp(effect(calibration, rate, map)), six worlds, 2 x 2 x 2 conditions."""
        draw = random.Random(11)
        runs = []
        for scene in ("indoor_1", "indoor_3"):
            for seed in (81, 82, 83):
                for calibration in ("known", "unknown"):
                    for rate in ("imu50", "imu200"):
                        for kind in ("planes", "points"):
                            name, base = f"{scene}_{calibration}_{rate}", 0.01 * math.exp(draw.gauss(0, 0.5))
                            arm = base * math.exp(effect(calibration, rate, kind) + draw.gauss(0, 0.05))
                            gone = (scene, seed, calibration, rate, kind) in lost
                            runs.append((name, seed, f"adaptive_{kind}", None, "lost") if gone else (name, seed, f"adaptive_{kind}", arm))
                            runs.append((name, seed, f"steady_{kind}", base))
        return self.study("where_it_pays", runs)

    def conditions(self, folder):
        return conditions.ratios(study_folder.Study(folder), "adaptive", "steady", "ate_m", ["indoor_1", "indoor_3"])[0]

    def test_a_condition_pays_where_its_interval_lies_below_1(self):
        folder = self.results(lambda calibration, rate, kind: -0.5 if rate == "imu50" else 0.5 if kind == "points" else 0.0)
        rows = {tuple(row[:3]): row for row in conditions.condition_rows(self.conditions(folder))}
        self.assertEqual(len(rows), 8)
        self.assertEqual(rows["known", "imu50", "planes"][-1], "pays")
        self.assertEqual(rows["known", "imu200", "points"][-1], "harms")
        self.assertEqual(rows["known", "imu200", "planes"][3], 6)
        self.assertAlmostEqual(float(rows["unknown", "imu50", "planes"][4]), math.exp(-0.5), delta=0.05)

    def test_a_factor_that_does_nothing_is_not_shown(self):
        folder = self.results(lambda calibration, rate, kind: -0.4 if rate == "imu50" else 0.4)
        found = {level: (effect, low, high) for _, level, effect, low, high in conditions.effects(self.conditions(folder), 500)}
        self.assertAlmostEqual(found["imu50"][0], -0.4, delta=0.05)
        self.assertLess(found["imu50"][2], 0)
        self.assertGreater(found["imu200"][1], 0)
        for level in ("known", "planes"):
            self.assertLess(found[level][1], 0.02)
            self.assertGreater(found[level][2], -0.02)

    def test_a_lost_run_counts_twice(self):
        lost = {("indoor_1", seed, "known", "imu50", "planes") for seed in (81, 82, 83)}
        worlds = self.conditions(self.results(lambda *_: 0.0, lost))["known", "imu50", "planes"]
        self.assertAlmostEqual(worlds["indoor_1", "81"], math.log(2))
        self.assertAlmostEqual(worlds["indoor_3", "81"], 0, delta=0.2)

    def test_the_command_prints_both_tables_and_names_what_is_missing(self):
        folder = self.results(lambda *_: 0.0)
        words = ["--pairs", "adaptive:steady", "--factors", "calibration,rate,map"]
        code, out, _ = printed(conditions.main, folder, *words)
        self.assertEqual(code, 0)
        self.assertIn("| calibration | rate | map | worlds |", out)
        code, _, err = printed(conditions.main, folder, "--pairs", "adaptive:nothing")
        self.assertEqual(code, 2)
        self.assertIn("no run of adaptive beside one of nothing", err)
        code, _, err = printed(conditions.main, folder, *words, "--scenes", "outdoor_1")
        self.assertEqual(code, 2)
        self.assertIn("begins with none of the scenes outdoor_1", err)


if __name__ == "__main__":
    unittest.main()
