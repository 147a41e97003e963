"""Sections of the results: spreads, failures, the command, and their place in a document."""
import json
import unittest

import numpy as np

from hand_made_study import StudyCase, printed, write_csv, write_tum, yaw

import divergence
import results_table
from study_folder import Study


class ResultsTable(StudyCase):
    def one(self):
        return self.study("echo", [("a", 1, "no_echo", (0.1, 0.5)), ("a", 2, "no_echo", (0.3, 0.5)), ("a", 3, "no_echo", (0.2, 0.5)),
                                   ("a", 1, "as_lio_plus", (0.05, 0.5)), ("a", 2, "as_lio_plus", (0.07, 0.5)),
                                   ("a", 3, "as_lio_plus", (None, None), "diverged")], figures=("ate_m", "end_to_end_m"),
                          expectation=["the echo serves: ate_m of as_lio_plus below that of no_echo on 2 of 3 pairs, needs 2: **holds**"])

    def test_a_study_of_one_sequence(self):
        code, out, err = printed(results_table.main, self.one())
        self.assertEqual((code, err), (0, ""))
        self.assertIn("| a | ATE [m] | end to end [cm] |", out)
        self.assertIn("| no_echo | 0.2000 (0.1000 to 0.3000) | 50.0 (50.0 to 50.0) |", out)
        # The median of two figures and a failure is the worse figure.
        self.assertIn("| as_lio_plus | 0.0700 (0.0500 to 0.0700), 1 of 3 failed |", out)
        self.assertIn("| a | as_lio_plus | 0.0500 | 0.0700 | x |", out)
        self.assertIn("6 runs, 1 failed: a_3/as_lio_plus: diverged.", out)
        self.assertIn("--output out/echo --seeds 1-3\n", out)
        self.assertIn("on 2 of 3 pairs, needs 2: **holds**\n", out)
        self.assertNotIn("rotation", out)  # no run has it
        self.assertIn("Of the file, which the command runs whole, without ramp.", out)  # of experiments/echo.yaml

    def test_all_arms_of_a_file(self):
        self.study("echo", [("a", 1, method, 0.1) for method in ("no_echo", "as_lio_plus", "ramp")])
        self.assertNotIn("Of the file", printed(results_table.main, self.root)[1])
        self.study("seg_step", [("a", 1, "frame_0.1_seg_step_0.03", 0.1)])  # varies a key
        self.assertNotIn("Of the file", printed(results_table.main, self.root)[1])

    def test_marks_of_the_paper_from_the_truth(self):
        """100 m at 1 m/s: good; good by its status, but far off late; far off soon; silent; crashed soon; without a truth."""
        def run(method, status="ok", jump=None, silent=None, end=100.0):
            t = np.arange(0, end, 0.1)
            off = np.where(t > (1e9 if jump is None else jump), 6.0, 0.001)
            folder = self.root / "runs/a_1" / method
            # Another origin and heading than the truth's.
            write_tum(folder / "trajectory.tum", t, np.stack([off, t, 0 * t], axis=1) + [3, 4, 5], [yaw(np.pi / 2)] * len(t))
            refused = (t > silent) & (t < silent + 1.5) if silent else t < 0
            write_csv(folder / "updates.csv", {"t_ns": [round(x * 1e9) for x in t],
                                               "status": ["few_matches" if r else "degenerate" for r in refused]})
            return ("a", 1, method, (0.1, 0.05), status)

        runs = [run("good"), run("late", jump=90.0), run("soon", jump=5.0), run("within", silent=None),
                run("silent", silent=40.0), run("crashed", "crashed", end=7.0), run("stopped", "timeout", end=30.0),
                ("b", 1, "good", (0.1, None), "ok")]
        self.study("mine", runs, figures=("ate_m", "end_to_end_m"))
        self.straight_truth("a_1", seconds=100.0, text="# --seed 1 --scale 1\n")
        code, out, err = printed(results_table.main, self.root, "--metrics", "ate_m,end_to_end_m")
        self.assertEqual((code, err), (0, ""))
        table = out[out.rindex("| end to end [cm] | method"):]
        for method, text in (("good", "5.0"), ("late", "-"), ("soon", "x"), ("within", "5.0"), ("silent", "-"), ("crashed", "x"),
                             ("stopped", "-")):
            self.assertIn(f"| a | {method} | {text} |", table)
        self.assertIn("| b | good | - |", table)
        self.assertIn("| a | late | 0.1000 |", out)  # the ATE stands beside it
        self.assertIn("`x` where a run failed before a tenth of the way, `-` where it failed later", out)
        self.assertIn("| late | -, 1 of 1 failed | - |", out)

    def test_marks_that_the_runs_tell(self):
        self.study("mine", [("a", 1, "m", (0.1, None)), ("a", 2, "m", (0.1, 0.09)), ("a", 3, "m", (0.1, 0.1)),
                            ("a", 4, "m", (None, None), "crashed"), ("a", 5, "m", (None, None), "diverged")],
                   figures=("end_to_end_m", "failed_at"))
        study = Study(self.root)
        self.assertEqual([divergence.mark(study, run) for run in study.runs], [None, "x", "-", "x", "-"])

    def test_many_failures_are_counted_and_values_are_chosen(self):
        self.study("mine", [("a", seed, m, (0.1, 0.2), "ok" if seed > failed else "diverged")
                            for m, failed in (("good", 0), ("bad", 7), ("worse", 9)) for seed in range(1, 11)], figures=("ate_m", "ate_deg"))
        code, out, _ = printed(results_table.main, self.root, "--values", "ate_deg")
        self.assertEqual(code, 0)
        self.assertIn("30 runs, 16 failed: bad 7 of 10, worse 9 of 10 (reasons: `table.md`).", out)
        self.assertEqual((out.count("| ATE [m] |"), out.count("| rotation [deg] |")), (1, 2))  # of the medians, and by seed
        _, out, _ = printed(results_table.main, self.root, "--values", "none")
        self.assertNotIn("All values by seed", out)
        self.assertEqual((out.count("| ATE [m] |"), out.count("| rotation [deg] |")), (1, 1))
        with self.assertRaises(SystemExit) as end:
            printed(results_table.main, self.root, "--values", "nonsense")
        self.assertEqual(end.exception.code, 2)

    def test_order_seeds_are_no_replicates(self):
        self.study("mine", [("a", 1, "m", (1.0,)), ("a", 2, "m", (5.0,)), ("a", 1, "n", (2.0,)), ("a", 2, "n", (4.0,))])
        lines = (self.root / "results.csv").read_text().splitlines()
        more = [line.replace(",0,m,ok,,1.0", ",1,m,ok,,9.0").replace(",0,n,ok,,2.0", ",1,n,ok,,6.0") for line in lines[1:] if ",1,0," in line]
        (self.root / "results.csv").write_text("\n".join([*lines, *more]) + "\n")
        study = Study(self.root)
        self.assertEqual(len(study.runs), 6)
        self.assertEqual(sorted(study.values("m", "a", "ate_m")), [5.0, 5.0])  # of 1 and 9, and 5 alone
        self.assertEqual(study.pairs("m", "n", "ate_m"), [(5.0, 4.0), (5.0, 4.0)])
        self.assertIn("| m | 5.0000 (5.0000 to 5.0000) |", printed(results_table.main, self.root)[1])

    def test_five_percent_of_the_way_and_two_metres(self):
        for jump, error, mark in ((5.0, 1.9, None), (5.0, 2.1, "x"), (60.0, 2.9, None), (60.0, 3.1, "-")):
            t = np.arange(0, 70, 0.1)
            self.study("mine", [("a", 1, "m", (0.1, 0.05))], figures=("ate_m", "end_to_end_m"))
            self.straight_truth("a_1", seconds=100.0)
            folder = self.root / "runs/a_1/m"
            # Off for one moment: later on more of the way has been travelled.
            write_tum(folder / "trajectory.tum", t, np.stack([t, np.where(np.isclose(t, jump), error, 0), 0 * t], axis=1),
                      [yaw(0)] * len(t))
            t = np.arange(0, 100, 0.1)
            write_csv(folder / "updates.csv", {"t_ns": [round(x * 1e9) for x in t], "status": ["ok"] * len(t)})
            study = Study(self.root)
            self.assertEqual(divergence.mark(study, study.runs[0]), mark, (jump, error))

    def test_several_sequences_are_columns(self):
        self.study("mine", [(s, 1, m, 0.1) for s in ("a", "b") for m in ("x", "y")])
        _, out, _ = printed(results_table.main, self.root)
        self.assertIn("| ATE [m] | a | b |\n|---|---|---|\n| x | 0.1000 | 0.1000 |", out)

    def test_figures_of_one_seed_are_no_medians(self):
        self.study("mine", [(s, 1, m, 0.1) for s in ("a", "b") for m in ("x", "y")])
        _, out, _ = printed(results_table.main, self.root)
        self.assertIn("\n\nOne run each:\n\n| ATE [m] | a | b |", out)
        self.assertNotIn("Median", out)
        self.study("mine", [("a", 1, "x", 0.1), ("a", 2, "x", 0.1), ("a", 1, "y", 0.1)])
        self.assertIn("\n\nMedian (smallest to largest) over seeds:\n\n", printed(results_table.main, self.root)[1])

    def test_what_a_lost_run_cost_until_then(self):
        runs = [("a", 1, "m", (0.1, 0.04)), ("a", 2, "m", (0.3, 0.02), "diverged"), ("a", 3, "m", (None, None), "crashed")]
        self.study("mine", runs, figures=("ate_m", "cpu_s_per_s"))
        _, out, _ = printed(results_table.main, self.root)
        self.assertIn("| m | x (0.1000 to 0.1000), 2 of 3 failed | 0.0300 (0.0200 to 0.0400) |", out)
        self.assertIn("| a | m | 0.0400 | 0.0200 | - |", out)
        self.assertIn("CPU and RSS of runs that were lost are those until then if the study ends them there", out)
        self.study("mine", runs[:1], figures=("ate_m", "cpu_s_per_s"))
        self.assertNotIn("until then", printed(results_table.main, self.root)[1])

    def test_scale_and_revision_are_told(self):
        self.one()
        for seed in (1, 2, 3):
            folder = self.root / f"data/a_{seed}"
            folder.mkdir(parents=True)
            (folder / "scene.yaml").write_text("# simulated with --seed 1 --scale 0.3\nschema: x\n")
        folder = self.root / "runs/a_1/as_lio_plus"
        folder.mkdir(parents=True)
        (folder / "manifest.json").write_text(json.dumps({"build": {"revision": "0123456789abcdef-dirty"}}))
        _, out, _ = printed(results_table.main, self.root)
        self.assertIn("--seeds 1-3 --scale 0.3\n", out)
        self.assertIn("Revision 0123456789ab-dirty.", out)
        self.assertIn("All recordings are simulated.", out)

    def test_the_command_has_what_the_verdict_was_reached_with(self):
        self.one()
        _, out, _ = printed(results_table.main, self.root, "--best-fixed", "fixed_50")
        self.assertRegex(out, r"(?m)^tools/analysis/results_table.py out/\w+ --best-fixed fixed_50$")

    def test_the_verdict_says_what_was_compared_with(self):
        methods = ("fixed_10", "fixed_20", "fixed_50", "fixed_20_history", "as_lio_plus")
        self.study("ideal_imu", [("a", 1, method, 0.1) for method in methods])
        self.assertIn("Best fixed rate: `fixed_10`, chosen **on these very data, which favours it", printed(results_table.main, self.root)[1])
        self.assertIn("Best fixed rate: `fixed_50`, as chosen by the caller.",
                      printed(results_table.main, self.root, "--best-fixed", "fixed_50")[1])

    def test_sequences_with_seeds_of_their_own_are_told(self):
        self.study("echo", [(s, seed, "as_lio_plus", 0.1) for s, seed in (("a", 1), ("a", 2), ("b", 7))])
        out = printed(results_table.main, self.root)[1]
        self.assertIn("--output out/echo --seeds 1-2,7\n", out)
        self.assertIn("Seeds, of which the command makes all for every sequence: a 1-2, b 7.\n", out)

    def test_seeds_as_ranges(self):
        self.assertEqual(results_table.ranges([7, 1, 2, 3, 9, 10]), "1-3,7,9-10")
        self.assertEqual(results_table.ranges([]), "")

    def test_a_study_has_a_page_and_the_folder_an_index(self):
        pages = self.root / "pages"
        self.assertEqual(printed(results_table.main, self.one(), "--into", pages, "--metrics", "ate_m")[0], 0)
        (pages / "older.md").write_text("# Study `older`\n\nWas it\nbetter?\n\n3 runs of 4, 0 failed. Revision 0123456789ab.\n")
        self.study("echo", [("a", 1, "as_lio_plus", 0.7)])
        printed(results_table.main, self.root, "--into", pages)
        text = (pages / "echo.md").read_text()
        self.assertTrue(text.startswith("# Study `echo`\n"))
        self.assertIn("0.7000", text)
        self.assertNotIn("0.0700", text)
        index = (pages / "README.md").read_text()
        self.assertIn("[echo](echo.md)", index)
        self.assertIn("| [older](older.md) | Was it better? | 3 of 4 | 0123456789ab |", index)
        self.assertNotIn("(README.md)", index)

    def test_a_file_in_place_of_the_folder_is_refused(self):
        document = self.root / "results.md"
        document.write_text("By hand.\n")
        self.assertEqual(printed(results_table.main, self.one(), "--into", document)[0], 2)
        self.assertEqual(document.read_text(), "By hand.\n")

    def test_what_others_wrote_is_not_written_over_nor_listed(self):
        pages = self.root / "pages"
        pages.mkdir()
        (pages / "notes.md").write_text("# Notes\n\nBy hand.\n")
        for name in ("README.md", "echo.md"):
            (pages / name).write_text("# By hand\n")
            code = printed(results_table.main, self.one(), "--into", pages)[0]
            self.assertEqual(code, 2)
            self.assertEqual((pages / name).read_text(), "# By hand\n")
            (pages / name).unlink()
        self.assertEqual(printed(results_table.main, self.one(), "--into", pages)[0], 0)
        self.assertNotIn("notes", (pages / "README.md").read_text())

    def test_metrics_that_are_none(self):
        with self.assertRaises(SystemExit) as end:
            printed(results_table.main, self.one(), "--metrics", "ate")
        self.assertEqual(end.exception.code, 2)


if __name__ == "__main__":
    unittest.main()
