"""The table of docs/systems.md: what a row says of runs that were lost, and where it goes."""
import argparse
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "benchmarks"))
import systems  # noqa: E402


def summary(status, ate=0.02, cpu=0.8):
    return {"status": status, "metrics": {"ate_m": ate, "ate_deg": 0.5}, "cpu_s": cpu, "data_s": 20.0}


class Systems(unittest.TestCase):
    def test_row_counts_the_lost_and_leaves_them_out(self):
        beginnings = [summary("ok", 0.02), summary("diverged", 9.0, 0.2), summary("degraded", 0.04)]
        row = systems.row(pathlib.Path("a/b.yaml"), beginnings, (summary("ok"), 0.033, "fast_lio2"))
        self.assertEqual(row, ["`b`", "0.020", "0.030 (0.020 to 0.040)", "0.50", "ok, 1 of 3 lost", "0.040", "0.033", "`fast_lio2`", "0.040"])
        self.assertEqual(len(row), len(systems.HEAD))

    def test_row_of_a_system_that_is_lost(self):
        row = systems.row(pathlib.Path("b.yaml"), [summary("diverged", 9.0)], (summary("diverged"), None, "b"))
        self.assertEqual(row, ["`b`", "x", "-", "x", "diverged, 1 of 1 lost", "-", "diverged", "`b`", "-"])

    def test_drive_is_held_against_its_own_trajectory_if_one_is_published(self):
        with tempfile.TemporaryDirectory() as folder:
            options = argparse.Namespace(aslio="x", drive="x", output=pathlib.Path(folder), published=pathlib.Path(folder))
            (options.published / "kiss_icp.tum").touch()
            with mock.patch.object(systems, "lidar_ate", lambda *_: 0.5):
                for name, status, expected in (("kiss_icp", "ok", (0.5, "kiss_icp")), ("kiss_icp", "diverged", (None, "kiss_icp")),
                                               ("loam", "degraded", (0.02, "fast_lio2")), ("loam", "diverged", (None, "fast_lio2"))):
                    with mock.patch.object(systems, "run", lambda *_, status=status: summary(status)):
                        self.assertEqual(systems.drive(options, pathlib.Path(f"{name}.yaml"))[1:], expected)

    def test_table_replaces_what_stands_between_the_marks_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            page.write_text(f"before\n{systems.BEGIN}\nold\n{systems.END}\nafter\n")
            arguments = ["systems.py", "--aslio", "x", "--corridor", "x", "--truth", "x", "--drive", "x", "--published", folder,
                         "--pipeline", "b.yaml", "--output", folder, "--into", str(page)]
            with mock.patch.object(sys, "argv", arguments), mock.patch.object(systems, "run", lambda *_: summary("ok")), \
                    contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                systems.main()
            text = page.read_text()
            self.assertTrue(text.startswith(f"before\n{systems.BEGIN}\n| pipeline |"))
            self.assertTrue(text.endswith(f"{systems.END}\nafter\n"))
            self.assertNotIn("old", text)
            page.write_text("no marks\n")
            with mock.patch.object(sys, "argv", arguments), contextlib.redirect_stderr(io.StringIO()) as complaint:
                self.assertRaises(SystemExit, systems.main)
            self.assertIn("needs one line", complaint.getvalue())


if __name__ == "__main__":
    unittest.main()
