"""The rules of where_it_pays and starvation on results made by hand."""
import math
import random
import unittest

from hand_made_study import StudyCase, printed

import conditions
import study_folder


class Conditions(StudyCase):
    def results(self, effect, lost=(), both=False):
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
                            steady = (name, seed, f"steady_{kind}")
                            runs.append((*steady, None, "lost") if gone and both else (*steady, base))
        return self.study("where_it_pays", runs)

    def conditions(self, folder):
        return conditions.ratios(study_folder.Study(folder), "adaptive", "steady", "ate_m", ["indoor_1", "indoor_3"])

    def test_a_condition_pays_where_its_interval_lies_below_1(self):
        folder = self.results(lambda calibration, rate, kind: -0.5 if rate == "imu50" else 0.5 if kind == "points" else 0.0)
        rows = {tuple(row[:3]): row for row in conditions.condition_rows(self.conditions(folder))}
        self.assertEqual(len(rows), 8)
        self.assertEqual(rows["known", "imu50", "planes"][-1], "pays")
        self.assertEqual(rows["known", "imu200", "points"][-1], "harms")
        self.assertEqual(rows["known", "imu200", "planes"][3], 6)
        self.assertAlmostEqual(float(rows["unknown", "imu50", "planes"][4]), math.exp(-0.5), delta=0.05)

    def test_a_factor_that_does_nothing_is_not_shown(self):
        conditions_found = self.conditions(self.results(lambda calibration, rate, kind: -0.4 if rate == "imu50" else 0.4))
        first, last, worlds = conditions.contrasts(conditions_found, 1)
        self.assertEqual((first, last, len(worlds)), ("imu50", "imu200", 6))
        mean, low, _ = conditions.interval(worlds.values())
        self.assertAlmostEqual(mean, 0.8, delta=0.05)
        self.assertGreater(low, 0.7)
        verdicts = [row[-1] for row in conditions.effect_rows(conditions_found, ["calibration", "rate", "map"])]
        self.assertEqual(verdicts, ["not shown", "raises the ratio", "not shown"])

    def test_a_condition_lost_by_both_arms_stays_in_the_table_and_biases_no_factor(self):
        lost = {(scene, seed, "unknown", "imu50", "planes") for scene in ("indoor_1", "indoor_3") for seed in (81, 82, 83)}
        found = self.conditions(self.results(lambda calibration, rate, kind: -1.0 if kind == "planes" else 0.0, lost, both=True))
        rows = {tuple(row[:3]): row for row in conditions.condition_rows(found)}
        self.assertEqual(rows["unknown", "imu50", "planes"][3:], [0, "-", "-", "not decided"])
        mean, low, high = conditions.interval(conditions.contrasts(found, 0)[2].values())
        self.assertTrue(low < 0 < high, (mean, low, high))

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
