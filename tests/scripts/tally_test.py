"""What the closing line counts."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

TALLY = pathlib.Path(__file__).resolve().parents[2] / "tools/lib/tally.py"

REPORT = """<testsuite tests="5">
<testcase name="good" status="run"/>
<testcase name="wrong" status="fail"><failure message="Failed"/></testcase>
<testcase name="crashed" status="fail"><failure message="SEGFAULT"/></testcase>
<testcase name="no such program" status="notrun"><skipped message="Unable to find executable"/></testcase>
<testcase name="left out" status="notrun"><skipped message="SKIP_RETURN_CODE=4"/></testcase>
</testsuite>"""


def run(*arguments):
    return subprocess.run([sys.executable, TALLY, *map(str, arguments)], capture_output=True, text=True, check=False)


class Tally(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.report = pathlib.Path(self.folder.name, "junit.xml")
        self.tally = pathlib.Path(self.folder.name, "tally")

    def test_crashes_and_tests_that_could_not_start_have_failed(self):
        self.report.write_text(REPORT)
        self.assertEqual(run("junit", self.report, 8, self.tally).returncode, 1)
        closing = run("close", self.tally)
        self.assertEqual(closing.stdout, "1 passed, 3 failed, 1 skipped\n")
        self.assertEqual(closing.returncode, 1)

    def test_a_green_run(self):
        self.report.write_text('<testsuite><testcase name="a" status="run"/><testcase name="b" status="run"/></testsuite>')
        self.assertEqual(run("junit", self.report, 0, self.tally).returncode, 0)
        closing = run("close", self.tally)
        self.assertEqual((closing.stdout, closing.returncode), ("2 passed, 0 failed\n", 0))

    def test_counts_of_several_runs_add_up(self):
        self.tally.write_text("tests\t5\t0\t1\nclang-tidy\t7\t2\t0\n")
        self.assertEqual(run("close", self.tally).stdout, "12 passed, 2 failed, 1 skipped\n")

    def test_no_test_at_all_is_a_failure(self):
        self.report.write_text("<testsuite/>")
        run("junit", self.report, 0, self.tally)
        self.assertEqual(run("close", self.tally).returncode, 1)

    def test_a_missing_report_is_a_failure(self):
        self.assertEqual(run("junit", self.report, 0, self.tally).returncode, 1)
        self.assertEqual(run("close", self.tally).stdout, "0 passed, 1 failed\n")

    def test_a_runner_that_fails_without_a_failed_case_is_a_failure(self):
        self.report.write_text('<testsuite><testcase name="a" status="run"/></testsuite>')
        run("junit", self.report, 1, self.tally)
        self.assertEqual(run("close", self.tally).stdout, "1 passed, 1 failed\n")


if __name__ == "__main__":
    unittest.main()
