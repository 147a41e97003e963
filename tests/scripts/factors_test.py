"""The rules of tuned, ladder and what_should_adapt on results made by hand."""
import math
import random
import unittest

from hand_made_study import StudyCase, printed

import factors
import study_folder

SCENES = factors.SCENES.split(",")


class Factors(StudyCase):
    def results(self, window, voxel, lost=()):
        """A factorial of steady|adaptive and fixed|controlled in nine scenes, two seeds, two kinds of world; effects on log error."""
        draw = random.Random(5)
        runs = []
        for scene in SCENES:
            for seed in (93, 94):
                for kind in ("ideal", "realistic"):
                    base = 0.02 * math.exp(draw.gauss(0, 0.6))
                    for w in ("steady", "adaptive"):
                        for v in ("fixed", "controlled"):
                            effect = (window if w == "adaptive" else 0) + (voxel if v == "controlled" and kind == "ideal" else 0)
                            run = (f"{scene}_{kind}", seed, f"{w}_{v}")
                            if (scene, seed, kind, w, v) in lost:
                                runs.append((*run, None, "lost"))
                            else:
                                runs.append((*run, base * math.exp(effect + draw.gauss(0, 0.02))))
        return self.study("what_should_adapt", runs)

    def table(self, folder, *factors_asked):
        rows = factors.rows_of(study_folder.Study(folder), factors_asked, "ate_m", SCENES)
        return {(row[0], row[1]): row[2:] for row in rows}

    def test_a_factor_is_judged_in_each_kind_of_world(self):
        table = self.table(self.results(0.0, -0.5), ("steady", "adaptive"), ("fixed", "controlled"))
        worlds, ratio, _, verdict, both = table["fixed to controlled", "ideal"]
        self.assertEqual((worlds, verdict, both), (18, "helps", 0))
        self.assertAlmostEqual(float(ratio), math.exp(-0.5), delta=0.02)
        self.assertAlmostEqual(float(table["fixed to controlled", "realistic"][1]), 1.0, delta=0.02)
        self.assertAlmostEqual(float(table["steady to adaptive", "ideal"][1]), 1.0, delta=0.02)

    def test_a_factor_that_harms(self):
        table = self.table(self.results(0.3, 0.0), ("steady", "adaptive"))
        self.assertEqual([row[3] for row in table.values()], ["harms", "harms"])

    def test_whole_names_are_a_step_of_a_ladder(self):
        table = self.table(self.results(-0.3, 0.0), ("steady_fixed", "adaptive_fixed"))
        self.assertEqual(table["steady_fixed to adaptive_fixed", "ideal"][3], "helps")

    def test_a_lost_run_counts_twice_and_both_lost_not(self):
        one = {("indoor_1", 93, "ideal", "adaptive", v) for v in ("fixed", "controlled")}
        kinds, both = factors.effects(study_folder.Study(self.results(0.0, 0.0, one)), "steady", "adaptive", "ate_m", SCENES)
        self.assertEqual(sum(both.values()), 0)
        self.assertAlmostEqual(kinds["ideal"]["indoor_1", "93"], math.log(2))
        two = one | {("indoor_1", 93, "ideal", "steady", v) for v in ("fixed", "controlled")}
        kinds, both = factors.effects(study_folder.Study(self.results(0.0, 0.0, two)), "steady", "adaptive", "ate_m", SCENES)
        self.assertEqual(both, {"ideal": 2, "realistic": 0})
        self.assertNotIn(("indoor_1", "93"), kinds["ideal"])
        self.assertEqual(len(kinds["ideal"]), 17)

    def test_one_factorial_of_several(self):
        study = study_folder.Study(self.results(-0.3, 0.4))
        kinds, _ = factors.effects(study, "fixed", "controlled", "ate_m", SCENES, "steady")
        self.assertEqual(len(kinds["ideal"]), 18)
        with self.assertRaises(study_folder.FolderError):
            factors.effects(study, "steady", "adaptive", "ate_m", SCENES, "steady")

    def test_the_command_prints_a_table_and_names_what_is_missing(self):
        folder = self.results(0.0, -0.5)
        code, out, _ = printed(factors.main, folder, "--factors", "fixed:controlled")
        self.assertEqual(code, 0)
        self.assertIn("| fixed to controlled | ideal | 18 |", out)
        code, _, err = printed(factors.main, folder, "--factors", "fixed:huge")
        self.assertEqual(code, 2)
        self.assertIn("no method with huge beside one with fixed; there are", err)


if __name__ == "__main__":
    unittest.main()
