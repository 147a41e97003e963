"""The commands a newcomer types refuse wrong arguments before they install or build anything."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(command, *arguments):
    return subprocess.run([ROOT / command, *arguments], capture_output=True, text=True, check=False, cwd=ROOT,
                          stdin=subprocess.DEVNULL, timeout=60)


class Commands(unittest.TestCase):
    def assert_refused(self, words, command, *arguments):
        result = run(command, *arguments)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertIn(words, result.stderr)
        self.assertEqual(result.stdout, "")

    def test_help(self):
        for command in ("tools/quickstart", "tools/test"):
            result = run(command, "--help")
            self.assertEqual(result.returncode, 0)
            self.assertIn("usage: " + command, result.stdout)
            self.assertIn("examples:", result.stdout)

    def test_quickstart_arguments(self):
        self.assert_refused("unknown argument '--inptu'", "tools/quickstart", "--inptu", "x.bag")
        self.assert_refused("--input needs --sensor", "tools/quickstart", "--input", "README.md")
        self.assert_refused("--output needs a value", "tools/quickstart", "--output")
        self.assert_refused("go with --input", "tools/quickstart", "--reference", "README.md")
        self.assert_refused("--input: no such file", "tools/quickstart", "--input", "gone.bag", "--sensor", "README.md")
        self.assert_refused("--sensor: no such file", "tools/quickstart", "--input", "README.md", "--sensor", "gone.yaml")

    def test_test_arguments(self):
        self.assert_refused("preset 'release' has no tests", "tools/test", "--preset", "release")
        self.assert_refused("--tally needs a value", "tools/test", "--tally")


class Analysis(unittest.TestCase):
    def test_without_numpy_the_scripts_say_where_to_get_it(self):
        scripts = [path for path in sorted((ROOT / "tools/analysis").glob("*.py")) if os.access(path, os.X_OK)]
        self.assertGreater(len(scripts), 6)
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "numpy.py").write_text("raise ModuleNotFoundError('numpy')\n")
            for script in scripts:
                result = subprocess.run([sys.executable, script, "--help"], capture_output=True, text=True, check=False, timeout=60,
                                        env={**os.environ, "PYTHONPATH": folder})
                if result.returncode == 0:
                    continue  # needs none
                self.assertEqual(result.returncode, 2, script)
                self.assertIn("python3-numpy", result.stderr, script)
                self.assertNotIn("Traceback", result.stderr, script)


if __name__ == "__main__":
    unittest.main()
