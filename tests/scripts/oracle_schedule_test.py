"""Schedules from the true overlap: the worked values of the segment rule, its echo, and where they are written."""
import argparse
import unittest

from hand_made_study import StudyCase, printed, write_csv

import oracle_schedule as oracle

MS = 10**6


def options(**more):
    return argparse.Namespace(**{**dict(frame_length=0.1, seg_step=0.1, n_min=2, n_max=25, shift_min=0.008, warmup=0.0, ahead=0.0,
                                        memory=0.01, no_echo=False), **more})


class OracleSchedule(StudyCase):
    def overlap(self, shares, path="overlap.csv", rays=None):
        write_csv(self.root / path, {"t": [f"1700000000.{10 * (k + 1) * MS:09d}" if k < 99 else f"170000000{(k + 1) // 100}."
                                           f"{10 * ((k + 1) % 100) * MS:09d}" for k in range(len(shares))],
                                     "static_rays": rays or [2400] * len(shares), "true_overlap": shares,
                                     "people_rays": [0] * len(shares)})
        return self.root / path

    def intervals(self, shares, **more):
        chosen = options(**more)
        updates = oracle.schedule(oracle.Overlap(self.overlap(shares), chosen.memory), chosen)
        ends = [1700000000 * 10**9] + [t for t, _ in updates]
        return [round((b - a) / MS, 1) for a, b in zip(ends, ends[1:])]

    def test_full_overlap_is_ten_hertz(self):
        self.assertEqual(self.intervals([1.0] * 50), [100.0] * 5)

    def test_the_rate_rises_at_once_and_falls_after_the_echo(self):
        # Overlap 0.5 in the second 100 ms: n = 6 for six updates of 33.3 ms, which is 2 L.
        self.assertEqual(self.intervals([1.0] * 10 + [0.5] * 10 + [1.0] * 40)[:9], [100.0, 100.0] + [33.3] * 6 + [100.0])

    def test_without_echo_it_falls_at_once(self):
        self.assertEqual(self.intervals([1.0] * 10 + [0.5] * 10 + [1.0] * 40, no_echo=True)[:4], [100.0, 100.0, 33.3, 100.0])

    def test_what_comes_is_known_ahead(self):
        self.assertEqual(self.intervals([1.0] * 10 + [0.5] * 10 + [1.0] * 40, ahead=0.1)[:7], [100.0] + [33.3] * 6)

    def test_limits_of_the_rate(self):
        self.assertEqual(min(self.intervals([0.0] * 50, seg_step=0.01)), 8.0)
        self.assertEqual(min(self.intervals([0.0] * 50)), 18.2)
        self.assertEqual(min(self.intervals([0.0] * 50, n_max=4)), 50.0)
        self.assertEqual(self.intervals([0.0] * 60, warmup=0.5)[:6], [100.0] * 5 + [18.2])

    def test_old_points_may_stay_where_all_is_known(self):
        self.assertEqual(self.intervals([1.0] * 50, n_min=4), [50.0] * 10)
        self.assertEqual(min(self.intervals([0.0] * 50, n_min=4)), 18.2)

    def test_what_is_young_counts_as_new(self):
        self.assertAlmostEqual(oracle.Overlap(self.overlap([0.9] * 10), 0.01).mean(0, 2 * 10**18), 0.9)
        # Newness of 0.1 per block, over three blocks: 0.9, 0.8, then 0.7.
        self.assertAlmostEqual(oracle.Overlap(self.overlap([0.9] * 10), 0.03).mean(0, 2 * 10**18), (0.9 + 0.8 + 8 * 0.7) / 10)
        blind = oracle.Overlap(self.overlap(["nan"] * 4 + [1.0], rays=[0] * 4 + [10]), 0.01)
        self.assertIsNone(blind.mean(0, 1700000000 * 10**9 + 40 * MS))
        self.assertEqual(blind.mean(0, 2 * 10**18), 1.0)

    def test_histories_fill_the_frame(self):
        updates = oracle.schedule(oracle.Overlap(self.overlap([0.5] * 40), 0.01), options())
        self.assertEqual([t - begin for t, begin in updates], [100 * MS] * len(updates))

    def test_files_of_a_study_and_into_another(self):
        for name in ("a_1", "a_2"):
            self.overlap([1.0] * 20, f"data/{name}/overlap.csv")
        code, out, _ = printed(oracle.main, self.root, "--n-min", "2", "--into", self.root / "other")
        self.assertEqual(code, 0)
        self.assertEqual(out.count("2 updates in 0.1 s"), 2)
        text = (self.root / "other/data/a_2/oracle.csv").read_text()
        # The map is young for a second: n = 2.
        self.assertEqual(text.splitlines()[:2], ["t_ns,window_begin_ns", "1700000000100000000,1700000000000000000"])
        self.assertEqual(printed(oracle.main, self.root, "--n-min", "2")[0], 0)
        self.assertEqual((self.root / "data/a_1/oracle.csv").read_text(), text)

    def test_like_a_run_the_short_intervals_are_where_least_is_known(self):
        # Half of the time in intervals of 100 ms, half of 20 ms; half of the view's time is known.
        shares = [1.0] * 100 + [0.2] * 100
        overlap = oracle.Overlap(self.overlap(shares), 0.01)
        ends = [int(overlap.begin)]
        for step in [20] * 50 + [100] * 10:  # the run had them the other way round
            ends.append(ends[-1] + step * MS)
        updates = oracle.schedule_like(overlap, ends, options())
        steps = [round((b[0] - a[0]) / MS) for a, b in zip(updates, updates[1:])]
        self.assertEqual(steps[:9], [100] * 9)
        self.assertEqual(set(steps[11:]), {20})
        self.assertAlmostEqual(len(updates), 60, delta=2)
        late = oracle.schedule_like(overlap, ends, options(ahead=0.5))  # knows of it half a second before
        self.assertEqual([round((b[0] - a[0]) / MS) for a, b in zip(late, late[1:])][6:10], [20] * 4)

    def test_like_a_run_its_warm_up_stays(self):
        # Nothing is known at first; the run had 100 ms there for a second, then 20 ms.
        ends = [k * 100 * MS for k in range(1, 12)] + [1100 * MS + k * 20 * MS for k in range(1, 46)]
        overlap = oracle.Overlap(self.overlap([0.0] * 50 + [1.0] * 150), 0.01)
        base = overlap.begin
        updates = oracle.schedule_like(overlap, [int(base) + end for end in ends], options(warmup=1.0))
        steps = [round((b[0] - a[0]) / MS) for a, b in zip(updates, updates[1:])]
        self.assertEqual(updates[0], (base + 100 * MS, base))
        self.assertEqual(steps[:10], [100] * 10)
        self.assertEqual(set(steps[10:]), {20})

    def test_like_a_run_of_a_study(self):
        self.overlap([1.0] * 20 + [0.5] * 20, "data/a_1/overlap.csv")
        code, _, err = printed(oracle.main, self.root, "--like", "as_lio_plus")
        self.assertEqual(code, 2)
        self.assertIn("run that method first", err)
        write_csv(self.root / "runs/a_1/as_lio_plus/updates.csv", {"t_ns": [1700000000 * 10**9 + k * MS for k in (100, 200, 220, 240, 260, 280, 300)]})
        code, out, _ = printed(oracle.main, self.root, "--like", "as_lio_plus", "--warmup", "0")
        self.assertEqual(code, 0)
        self.assertIn("shortest interval 20.0 ms", out)

    def test_a_run_of_other_data_is_refused(self):
        self.overlap([1.0] * 40, "data/a_1/overlap.csv")
        for offset in (0, 1800000000 * 10**9):
            write_csv(self.root / "runs/a_1/as_lio_plus/updates.csv", {"t_ns": [offset + k * MS for k in (100, 200, 220, 240)]})
            code, _, err = printed(oracle.main, self.root, "--like", "as_lio_plus", "--warmup", "0")
            self.assertEqual(code, 2)
            self.assertIn("of other data", err)

    def test_what_has_no_overlap_is_told(self):
        code, _, err = printed(oracle.main, self.root)
        self.assertEqual(code, 2)
        self.assertIn("overlap.csv", err)
        self.overlap([1.0] * 2, "data/a/overlap.csv")
        self.overlap([1.0] * 2, "data/b/overlap.csv")
        self.assertIn("leave it out", printed(oracle.main, self.root, "--output", "x.csv")[2])


if __name__ == "__main__":
    unittest.main()
