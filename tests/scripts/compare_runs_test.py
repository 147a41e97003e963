"""The comparison table: what a run did not measure is a dash, and a bad run is told."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/compare_runs.py"

SUMMARY = {
    "status": "ok", "reason": "", "rate_hz": {"min": 10.0, "median": 10.26, "max": 55.0}, "cpu_s": 1.5, "data_s": 20.0,
    "peak_rss_mb": 81.4,
    "metrics": {"ate_m": 0.0234, "ate_deg": 0.456, "rpe": 0.00512, "end_to_end_m": 0.0129},
}


class CompareRuns(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, name, **changes):
        (self.root / name).mkdir()
        (self.root / name / "summary.json").write_text(json.dumps({**SUMMARY, **changes}))

    def compare(self, *names):
        table = self.root / "table.md"
        run = subprocess.run([sys.executable, SCRIPT, "--markdown", table, *(self.root / name for name in names)],
                             capture_output=True, text=True, check=False)
        return run, [line.strip("| ").split(" | ") for line in table.read_text().splitlines()]

    def test_figures_are_scaled_and_rounded(self):
        self.write("as_lio_plus")
        run, table = self.compare("as_lio_plus")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(table[2], ["as_lio_plus", "ok", "23.4", "0.46", "12.9", "0.0051", "10.0 / 10.3 / 55.0", "0.075", "81"])

    def test_without_a_reference_there_are_dashes_and_no_zeros(self):
        self.write("a", metrics={"ate_m": None, "ate_deg": None, "rpe": None, "end_to_end_m": 0.02})
        _, table = self.compare("a")
        self.assertEqual(table[2][2:6], ["-", "-", "20.0", "-"])

    def test_a_column_of_lengths_has_one_unit(self):
        self.write("good")
        self.write("poor", metrics={"ate_m": 1.25, "end_to_end_m": 0.02})
        _, table = self.compare("good", "poor")
        self.assertEqual([line[2] for line in (table[0], *table[2:])], ["ATE [m]", "0.023", "1.250"])
        self.assertEqual([line[4] for line in (table[0], *table[2:])], ["end-to-end [mm]", "12.9", "20.0"])

    def test_a_diverged_run_stays_in_the_table_and_is_told(self):
        self.write("good")
        self.write("bad", status="diverged", reason="speed 40.0 m/s", rate_hz=None)
        run, table = self.compare("good", "bad")
        self.assertEqual(run.returncode, 1)
        self.assertEqual(table[3][:2], ["bad", "diverged"])
        self.assertIn("bad: diverged: speed 40.0 m/s", run.stderr)
        self.assertIn("good", run.stdout)

    def test_a_run_without_summary_is_told(self):
        self.write("good")
        run, table = self.compare("good", "gone")
        self.assertEqual(run.returncode, 1)
        self.assertEqual(table[3], ["gone", "no summary"] + ["-"] * 7)
        self.assertIn("summary.json", run.stderr)


if __name__ == "__main__":
    unittest.main()
