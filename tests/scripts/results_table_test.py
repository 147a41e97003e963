"""Sections of the results: spreads, failures, the command, and their place in a document."""
import json
import unittest

from hand_made_study import StudyCase, printed

import results_table


class ResultsTable(StudyCase):
    def one(self):
        return self.study("echo", [("a", 1, "no_echo", (0.1, 0.5)), ("a", 2, "no_echo", (0.3, 0.5)), ("a", 3, "no_echo", (0.2, 0.5)),
                                   ("a", 1, "as_lio", (0.05, 0.5)), ("a", 2, "as_lio", (0.07, 0.5)),
                                   ("a", 3, "as_lio", (None, None), "diverged")], figures=("ate_m", "end_to_end_m"))

    def test_a_study_of_one_sequence(self):
        code, out, err = printed(results_table.main, self.one())
        self.assertEqual((code, err), (0, ""))
        self.assertIn("| a | ATE [m] | end to end [cm] |", out)
        self.assertIn("| no_echo | 0.2000 (0.1000 to 0.3000) | 50.0 (50.0 to 50.0) |", out)
        # The median of two figures and a failure is the worse figure.
        self.assertIn("| as_lio | 0.0700 (0.0500 to 0.0700), 1 of 3 failed |", out)
        self.assertIn("| a | as_lio | 0.0500 | 0.0700 | x |", out)
        self.assertIn("6 runs, 1 failed: a_3/as_lio: diverged.", out)
        self.assertIn("--output out/echo --seeds 1-3\n", out)
        self.assertIn("- as_lio wins 2 of 3 pairs against no_echo (needs most): **holds**", out)
        self.assertNotIn("rotation", out)  # no run has it

    def test_several_sequences_are_columns(self):
        self.study("mine", [(s, 1, m, 0.1) for s in ("a", "b") for m in ("x", "y")])
        _, out, _ = printed(results_table.main, self.root)
        self.assertIn("| ATE [m] | a | b |\n|---|---|---|\n| x | 0.1000 | 0.1000 |", out)

    def test_scale_and_revision_are_told(self):
        self.one()
        for seed in (1, 2, 3):
            folder = self.root / f"data/a_{seed}"
            folder.mkdir(parents=True)
            (folder / "scene.yaml").write_text("# simulated with --seed 1 --scale 0.3\nschema: x\n")
        folder = self.root / "runs/a_1/as_lio"
        folder.mkdir(parents=True)
        (folder / "manifest.json").write_text(json.dumps({"build": {"revision": "0123456789abcdef-dirty"}}))
        _, out, _ = printed(results_table.main, self.root)
        self.assertIn("--seeds 1-3 --scale 0.3\n", out)
        self.assertIn("Revision 0123456789ab-dirty.", out)

    def test_seeds_as_ranges(self):
        self.assertEqual(results_table.ranges([7, 1, 2, 3, 9, 10]), "1-3,7,9-10")
        self.assertEqual(results_table.ranges([]), "")

    def test_a_section_replaces_itself_and_nothing_else(self):
        document = self.root / "results.md"
        document.write_text("# Results\n\nBy hand.\n")
        for _ in range(2):
            self.assertEqual(printed(results_table.main, self.one(), "--into", document, "--metrics", "ate_m")[0], 0)
        document.write_text(document.read_text() + "\nAfter it.\n")
        self.study("echo", [("a", 1, "as_lio", 0.7)])
        printed(results_table.main, self.root, "--into", document)
        text = document.read_text()
        self.assertEqual(text.count("## Study `echo`"), 1)
        self.assertIn("0.7000", text)
        self.assertNotIn("0.0700", text)
        self.assertTrue(text.startswith("# Results\n\nBy hand.\n\n<!-- study echo -->\n\n## Study"))
        self.assertTrue(text.endswith("<!-- end of study echo -->\n\nAfter it.\n"))

    def test_metrics_that_are_none(self):
        with self.assertRaises(SystemExit) as end:
            printed(results_table.main, self.one(), "--metrics", "ate")
        self.assertEqual(end.exception.code, 2)


if __name__ == "__main__":
    unittest.main()
