"""The rule of adaptivity_worlds on results made by hand."""
import math
import random
import unittest

from hand_made_study import StudyCase

import equivalence
import study_folder


class Equivalence(StudyCase):
    def worlds(self, factor, spread=0.05, kinds=9, seeds=24, by_kind=lambda kind: 1.0, lost=()):
        draw = random.Random(5)
        runs = []
        for kind in range(kinds):
            for seed in range(seeds):
                name, base = f"scene_{kind}_ideal", 0.01 * math.exp(draw.gauss(0, 0.5))
                other = base * factor * by_kind(kind) * math.exp(draw.gauss(0, spread))
                runs.append((name, seed, "adaptive", base))
                status = "lost" if (kind, seed) in lost else "ok"
                runs.append((name, seed, "steady", None if status == "lost" else other, status))
        return study_folder.Study(self.study("adaptivity_worlds", runs))

    def row(self, study):
        return next(iter(equivalence.rows(study, "adaptive", "ate_m", ["_ideal"])))

    def test_the_four_verdicts(self):
        self.assertEqual(self.row(self.worlds(1.0))[-1], "no difference")
        self.assertEqual(self.row(self.worlds(1.3))[-1], "the baseline helps")
        self.assertEqual(self.row(self.worlds(0.7))[-1], "the baseline harms")
        self.assertEqual(self.row(self.worlds(1.0, spread=4))[-1], "not decided")

    def test_a_small_difference_is_none(self):
        # Wholly above 1, and within a tenth: equivalence comes first.
        row = self.row(self.worlds(1.05, spread=0.01))
        self.assertEqual(row[-1], "no difference")
        self.assertAlmostEqual(float(row[5]), 1.05, places=2)

    def test_worlds_of_one_kind_are_a_cluster(self):
        # Half of the kinds a third better, the others a third worse: 216 pairs, and nothing is known.
        study = self.worlds(1.0, by_kind=lambda kind: 1.5 if kind % 2 else 1 / 1.5)
        self.assertEqual(self.row(study)[-1], "not decided")

    def test_the_interval_is_that_of_students_t_over_the_means_of_equal_clusters(self):
        kinds = {0: [0.1, 0.3], 1: [0.0, 0.2], 2: [-0.2, 0.0]}
        mean, low, high = equivalence.interval(kinds)
        means = [0.2, 0.1, -0.1]
        centre = sum(means) / 3
        error = math.sqrt(sum((m - centre) ** 2 for m in means) / 2 / 3)
        self.assertAlmostEqual(mean, centre)
        self.assertAlmostEqual(high - centre, 2.919986 * error, places=6)  # t of 95 %, two degrees of freedom
        self.assertAlmostEqual(centre - low, high - centre)

    def test_a_lost_run_counts_twice(self):
        row = self.row(self.worlds(1.0, spread=0, lost={(kind, 0) for kind in range(9)}))
        self.assertAlmostEqual(float(row[5]), math.exp(math.log(2) / 24), places=3)
        self.assertEqual(row[2], 216)

    def test_one_kind_decides_nothing(self):
        self.assertEqual(self.row(self.worlds(1.0, kinds=1))[-1], "not decided")


if __name__ == "__main__":
    unittest.main()
