"""The studies of the overlap degree: recordings made by hand whose events and figures are known."""
import csv
import pathlib
import unittest
import xml.etree.ElementTree as xml

import numpy as np

from hand_made_study import StudyCase, printed, write_csv, write_tum, yaw

import overlap_events
import sod_against_imu
import sod_pose_error
import sod_voxel_size
import update_cost
import svg
from overlap_events import Event, Truth, auc, detect, stretches

START = 1700000000
NS = 10**9
# (begin, end, turn rate, V): a fall in a turn, one without, a turn in which nothing is new, all at multiples of 0.1 s.
EVENTS = [("green", 10.0, 10.5, 3.0, 0.5), ("blue", 20.0, 20.5, 0.0, 0.6), ("red", 30.0, 30.5, 3.0, 0.99)]


def rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_truth(folder, seconds=40.0):
    """Swaying, with turns; V is 0.99 but for falls, and 0 in the first second."""
    t = np.arange(0, seconds + 1e-9, 0.005)
    rate = 0.3 * np.abs(np.sin(3 * t))
    for _, begin, end, turning, _ in EVENTS:
        rate[(t >= begin) & (t < end)] = turning
    angle = np.concatenate([[0], np.cumsum(rate[:-1] * 0.005)])
    write_tum(folder / "truth.tum", t + START, [[0, 0, 1]] * len(t), [yaw(a) for a in angle])
    t = np.arange(1, round(seconds * 100) + 1) / 100
    V = np.where(t < 1.0, 0.0, 0.99)
    for _, begin, end, _, overlap in EVENTS:
        V[(t > begin) & (t <= end + 1e-9)] = overlap
    write_csv(folder / "overlap.csv", {"t": [f"{START + x:.9f}" for x in t], "static_rays": [100] * len(t), "true_overlap": V,
                                       "people_rays": [0] * len(t)})


def write_updates(folder, period=0.1, seconds=40.0, late=0.0):
    """O follows V, `late` seconds behind it, a little restless."""
    t = np.arange(1, round(seconds / period) + 1) * period
    sod = 0.97 + 0.002 * np.cos(37 * np.arange(len(t)))
    for _, begin, end, _, overlap in EVENTS:
        if overlap < 0.8:
            sod[(t > begin + late + 1e-9) & (t <= end + late + 1e-9)] = overlap
    write_csv(folder / "updates.csv", {"t_ns": [START * NS + round(x * 1e9) for x in t],
                                       "sod": ["" if x < 0.25 else f"{v:.6f}" for x, v in zip(t, sod)]})


class Events(StudyCase):
    def test_stretches(self):
        t = np.arange(8) * 0.1
        mask = np.array([1, 0, 1, 1, 0, 0, 0, 1], dtype=bool)
        self.assertEqual(stretches(mask, t, 0), [(0, 0), (2, 3), (7, 7)])
        self.assertEqual(stretches(mask, t, 0.25), [(0, 3), (7, 7)])
        self.assertEqual(stretches(np.zeros(8, dtype=bool), t, 1), [])

    def test_kinds_and_bounds(self):
        write_truth(self.root)
        found = Truth(self.root).events(3.0)
        self.assertEqual([event.kind for event in found], [kind for kind, *_ in EVENTS])
        for event, (_, begin, end, *_) in zip(found, EVENTS):
            # Times count from the first sample of the overlap, 10 ms into the recording.
            self.assertAlmostEqual(event.begin, begin - 0.01, delta=0.011)
            self.assertAlmostEqual(event.end, end - 0.01, delta=0.011)
        self.assertEqual([event.kind for event in Truth(self.root).events(15.0)], ["blue", "red"])

    def test_rate_and_force_of_a_motion(self):
        t = np.arange(0, 4, 0.005)
        write_tum(self.root / "truth.tum", t, [[0, 0, x * x] for x in t], [yaw(0.7 * x) for x in t])
        write_csv(self.root / "overlap.csv", {"t": [f"{x:.9f}" for x in t], "true_overlap": [1.0] * len(t)})
        truth = Truth(self.root)
        np.testing.assert_allclose(truth.rate, 0.7, atol=1e-6)
        np.testing.assert_allclose(truth.force, 2.0, atol=1e-3)  # 2 m/s^2 upwards

    def test_auc(self):
        values = np.array([0.1, 0.4, 0.35, 0.8])
        self.assertAlmostEqual(auc(values, np.array([0, 0, 1, 1], dtype=bool)), 0.75)
        self.assertAlmostEqual(auc(np.array([1.0, 1.0, 1.0, 2.0]), np.array([0, 1, 0, 1], dtype=bool)), 0.75)
        self.assertAlmostEqual(auc(np.ones(4), np.array([0, 1, 0, 1], dtype=bool)), 0.5)
        self.assertIsNone(auc(values, np.zeros(4, dtype=bool)))

    def test_snr_delay_and_alarms(self):
        t = np.arange(1, 401) * 0.1
        values = 0.01 * np.random.default_rng(1).standard_normal(400)
        values[(t > 10.15) & (t < 10.45)] = 1.0
        values[(t > 30.15) & (t < 30.25)] = 1.0  # an alarm without an event
        events = [Event("green", 10.0, 10.5), Event("red", 20.0, 20.5)]
        found = detect(t, values, (t > 10.0) & (t <= 10.5), events, 0.0)
        # The median over 21 values takes some of the noise away.
        self.assertAlmostEqual(found.snr_db, 40.0, delta=1.5)
        self.assertAlmostEqual(found.delay_s, 0.2, places=6)
        self.assertEqual(found.found, {"green": (1, 1), "red": (0, 1)})
        self.assertAlmostEqual(found.alarms_per_min, 60 / 39.9, places=6)

    def test_a_signal_that_does_not_rise_finds_nothing(self):
        t = np.arange(1, 401) * 0.1
        low = (t > 10.0) & (t <= 10.5)
        found = detect(t, np.where(low, 0.0, 1.0), low, [Event("blue", 10.0, 10.5)], 0.0)
        self.assertEqual((found.auc, found.snr_db, found.threshold, found.found), (0.0, None, None, {}))


class AgainstImu(StudyCase):
    def test_of_a_run(self):
        write_truth(self.root / "data")
        write_updates(self.root / "run", late=0.1)
        code, text, err = printed(sod_against_imu.main, "--run", self.root / "run", "--data", self.root / "data", "--output",
                                  self.root / "out")
        self.assertEqual(code, 0, err)
        lines = {line["signal"]: line for line in rows(self.root / "out/sod_against_imu.csv")}
        sod, turn = lines["sod"], lines["turn_rate"]
        self.assertEqual([sod[k + "_found"] for k in ("green", "blue", "red")], ["1", "1", "0"])
        self.assertEqual([sod[k + "_events"] for k in ("green", "blue", "red")], ["1", "1", "1"])
        self.assertAlmostEqual(float(sod["delay_s"]), 0.2, delta=0.02)  # an update, one late
        self.assertEqual([turn[k + "_found"] for k in ("green", "blue", "red")], ["1", "0", "1"])
        self.assertGreater(float(sod["auc"]), float(turn["auc"]))
        self.assertGreater(float(sod["snr_db"]), 20)
        self.assertIn("| overlap degree (1 - O) | 1 |", text)
        self.assertEqual(text, (self.root / "out/sod_against_imu.md").read_text())
        (picture,) = (self.root / "out").glob("*.svg")
        xml.parse(picture)
        self.assertIn(overlap_events.COLOURS["blue"], picture.read_text())

    def test_of_a_study_without_its_failures(self):
        self.study("sod_against_imu", [("indoor_1", 1, "a", 0.1), ("indoor_1", 2, "a", 0.1), ("indoor_1", 3, "a", None, "failed")])
        for seed in (1, 2):
            write_truth(self.root / f"data/indoor_1_{seed}")
            write_updates(self.root / f"runs/indoor_1_{seed}/a")
        code, text, err = printed(sod_against_imu.main, self.root, "--output", self.root / "out")
        self.assertEqual(code, 0, err)
        self.assertIn("indoor_1_3/a (failed)", err)
        self.assertIn("| indoor_1 | a | overlap degree (1 - O) | 2 |", text)
        self.assertIn("| 2 / 2 | 2 / 2 | 0 / 2 |", text)
        self.assertIn("in 1 of 1 sequences and windows (needs all), and finds 2 of 2 blue events (needs one): **holds**", text)
        self.assertEqual(len(list((self.root / "out").glob("*.svg"))), 1)

    def test_what_does_not_belong_together_is_refused(self):
        write_truth(self.root / "data")
        write_csv(self.root / "run/updates.csv", {"t_ns": [1, 2, 3], "sod": [1, 1, 1]})
        code, _, err = printed(sod_against_imu.main, "--run", self.root / "run", "--data", self.root / "data", "--output",
                               self.root / "out")
        self.assertEqual(code, 2)
        self.assertIn("no update within", err)
        code, _, err = printed(sod_against_imu.main, "--run", self.root / "run", "--output", self.root / "out")
        self.assertEqual(code, 2)
        self.assertIn("--data", err)


class UpdateCost(StudyCase):
    def test_percentiles_and_the_share_of_the_overlap(self):
        self.study("table_1", [("indoor_1", 1, "as_lio_plus", 0.1), ("indoor_1", 2, "as_lio_plus", None, "failed"), ("indoor_1", 1, "fixed_10", 0.1)])
        stages = ("window", "predict", "deskew", "sample", "associate", "solve", "overlap", "insert")
        for method, overlap in (("as_lio_plus", 0.0002), ("fixed_10", 0.001)):
            solve = [0.0008] * 99 + [0.0098]  # one update of 10 ms
            write_csv(self.root / f"runs/indoor_1_1/{method}/timings.csv",
                      {"t_ns": range(100), **{f"{name}_s": [0] * 100 for name in stages}, "solve_s": solve, "overlap_s": [overlap] * 100})
        code, text, err = printed(update_cost.main, self.root, "--methods", "as_lio_plus")
        self.assertEqual(code, 0, err)
        self.assertIn("| indoor_1 | as_lio_plus | 1 | 1.00 | 1.09 | 18.3 |", text)
        self.assertNotIn("fixed_10", text)
        code, _, err = printed(update_cost.main, self.root, "--methods", "gone")
        self.assertEqual(code, 2)
        self.assertIn("no good run of gone", err)


class VoxelSize(StudyCase):
    SIZES = ("0.1", "0.2", "0.4")

    def make(self, times=None):
        self.study("sod_voxel_size", [("indoor_1", 1, f"{m}_voxel_{s}", 0.1, "ok", (s,)) for m in ("soft", "hard")
                                      for s in self.SIZES], axes=("overlap.voxel",))
        wave = 0.8 + 0.1 * np.cos(np.arange(100))
        for k, size in enumerate(self.SIZES):
            for method, sod in (("soft", wave + 0.02 * k), ("hard", np.where(np.arange(100) % (k + 2), wave, 0.5))):
                at = times[k] if times else range(100)
                write_csv(self.root / f"runs/indoor_1_1/{method}_voxel_{size}/updates.csv",
                          {"t_ns": [START * NS + i * NS // 10 for i in at], "sod": [f"{v:.9f}" for v in sod]})

    def test_correlations_and_spread(self):
        self.make()
        code, text, err = printed(sod_voxel_size.main, self.root, "--output", self.root / "out", "--skip", 0)
        self.assertEqual(code, 0, err)
        self.assertIn("| indoor_1 | soft | 1 | 1.000 |", text)
        self.assertIn("| 0.040 |", text)
        lines = rows(self.root / "out/sod_voxel_size.csv")
        self.assertEqual([line["voxel"] for line in lines], list(self.SIZES) * 2)
        wave = 0.8 + 0.1 * np.cos(np.arange(100))
        self.assertAlmostEqual(float(lines[2]["mean"]), np.mean(wave) + 0.04, places=8)
        hard = [np.where(np.arange(100) % (k + 2), wave, 0.5) for k in range(3)]
        lowest = min(np.corrcoef(hard[a], hard[b])[0, 1] for a, b in ((0, 1), (0, 2), (1, 2)))
        self.assertIn(f"| indoor_1 | hard | 1 | {lowest:.3f} |", text)
        xml.parse(self.root / "out/sod_voxel_size_indoor_1.svg")

    def test_the_rules_of_the_study(self):
        self.make()
        self.assertIn("**not decided**", printed(sod_voxel_size.main, self.root, "--output", self.root / "out", "--skip", 0)[1])
        for spread, outcome in ((0.01, "holds"), (0.03, "does not hold")):
            self.study("sod_voxel_size", [("indoor_1", 1, f"{m}_voxel_{s}", 0.1, "ok", (s,)) for m in ("fixed_layers", "fixed_margin")
                                          for s in self.SIZES], axes=("overlap.voxel",))
            wave = 0.8 + 0.1 * np.cos(np.arange(100))
            for k, size in enumerate(self.SIZES):
                for method, step in (("fixed_layers", 0.02), ("fixed_margin", spread)):
                    write_csv(self.root / f"runs/indoor_1_1/{method}_voxel_{size}/updates.csv",
                              {"t_ns": [START * NS + i * NS // 10 for i in range(100)], "sod": [f"{v:.9f}" for v in wave + step * k]})
            _, text, _ = printed(sod_voxel_size.main, self.root, "--output", self.root / "out", "--skip", 0)
            self.assertIn("lowest correlation between two sizes is 1.000 (needs 0.9): **holds**", text)
            self.assertIn(f"at a fixed margin, 0.040 at fixed layers: **{outcome}**", text)

    def test_only_shared_times_count_and_others_are_refused(self):
        self.make([range(100), range(50, 150), range(100)])
        self.assertEqual(printed(sod_voxel_size.main, self.root, "--output", self.root / "out")[0], 0)
        self.make([range(100), range(95, 195), range(100)])
        code, _, err = printed(sod_voxel_size.main, self.root, "--output", self.root / "out")
        self.assertEqual(code, 2)
        self.assertIn("fixed window", err)

    def test_a_study_of_something_else_is_refused(self):
        self.study("echo", [("indoor_1", 1, "a", 0.1)])
        code, _, err = printed(sod_voxel_size.main, self.root, "--output", self.root / "out")
        self.assertEqual(code, 2)
        self.assertIn("overlap.voxel", err)


class PoseError(StudyCase):
    def program(self, body):
        path = self.root / "aslio"
        path.write_text("#!/usr/bin/python3\nimport sys\nwords = sys.argv\n" + body)
        path.chmod(0o755)
        return path

    def score(self, hard, soft):
        # Frames of 1 s at 0.9, moved by 0.08 / 0.02 (hard / soft) below and above it in turn, undefined at first.
        program = self.program(
            "block = words[words.index('--set') + 1]\n"
            f"d = {hard} if 'hard' in block else {soft}\n"
            "with open(words[words.index('--output') + 1], 'w') as out:\n"
            "    out.write('t_ns,sod,sod_moved\\n0,,\\n')\n"
            "    for i in range(1, 21): out.write(f'{i}000000000,0.9,{0.9 - d if i % 4 else 0.9 + d}\\n')\n")
        (self.root / "data").mkdir(exist_ok=True)
        code, text, err = printed(sod_pose_error.main, self.root / "data", "--aslio", program, "--output", self.root / "out",
                                  "--skip", 0.5)
        self.assertEqual(code, 0, err)
        return text

    def test_changes_by_metric_and_size(self):
        text = self.score(0.08, 0.02)
        self.assertIn("| hard | 0.1 | 0.900 | 0.0800 | 0.0800 | -0.0400 | 4.0 |", text)
        self.assertIn("| soft, 3 layers | 0.4 | 0.900 | 0.0200 | 0.0200 | -0.0100 | 1.0 |", text)
        self.assertEqual(len(rows(self.root / "out/sod_pose_error.csv")), 12)
        self.assertIn("changes less than the hard one at 4 of 4 sizes (needs all): **holds**", text)
        self.assertIn("at 0 of 4 sizes (needs all): **does not hold**", self.score(0.02, 0.08))

    def test_a_command_that_fails_is_told(self):
        program = self.program("sys.exit('error: no such stage')\n")
        code, _, err = printed(sod_pose_error.main, self.root, "--aslio", program, "--output", self.root / "out")
        self.assertEqual(code, 2)
        self.assertIn("no such stage", err)
        self.assertFalse((self.root / "out").exists())


class Charts(unittest.TestCase):
    def test_ticks_are_round_and_inside(self):
        np.testing.assert_allclose(svg.ticks(0, 1, 5), [0, 0.2, 0.4, 0.6, 0.8, 1.0])
        np.testing.assert_allclose(svg.ticks(-3, 88, 12), range(0, 81, 10))
        np.testing.assert_allclose(svg.ticks(0.1, 1.02, 5), [0.2, 0.4, 0.6, 0.8, 1.0])

    def test_a_missing_value_breaks_the_line(self):
        chart = svg.chart("a < b", [svg.Panel("p").line("l", [0, 1, 2, 3], [1, np.nan, 2, 3])], (0, 3), "t")
        path = xml.fromstring(chart).find(".//{http://www.w3.org/2000/svg}path").get("d")
        self.assertEqual(path.count("M"), 2)
        self.assertEqual(path.count("L"), 1)

    def test_more_values_than_pixels_keep_their_peaks(self):
        values = np.zeros(100000)
        values[[123, 70000]] = 1, -1
        chart = svg.chart("many", [svg.Panel("p", (-1, 1)).line("l", np.arange(100000), values)], (0, 100000), "t")
        path = xml.fromstring(chart).find(".//{http://www.w3.org/2000/svg}path").get("d")
        heights = [float(point.split(" ")[1]) for point in path[1:].split("L")]
        self.assertLess(len(heights), svg.WIDTH)
        self.assertAlmostEqual(max(heights) - min(heights), svg.PANEL)


if __name__ == "__main__":
    unittest.main()
