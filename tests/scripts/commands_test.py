"""The commands a newcomer types refuse wrong arguments before they install or build anything."""
import os
import pathlib
import re
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

    def test_quickstart_names_every_kind_of_input_that_the_formats_name(self):
        usage = run("tools/quickstart", "--help").stdout
        containers = (ROOT / "docs/formats.md").read_text(encoding="utf-8").split("## Containers")[1].split("## ")[0]
        endings = set(re.findall(r"\.(?:bag|mcap|db3|pcap|pcapng)\b", containers))
        self.assertEqual(len(endings), 5)
        for ending in endings:
            self.assertRegex(usage, re.escape(ending) + r"\b")
        for kind in ("rosbag2 folder", "folder of bags", "folder of files", "network capture"):
            self.assertIn(kind, usage)

    def test_quickstart_does_not_mix_a_recording_with_a_study(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "results.csv").write_text("data\n")
            self.assert_refused("holds a study", "tools/quickstart", "--scene", "configs/scenes/indoor_1.yaml", "--output", folder)

    def test_recordings_of_one_name_have_folders_of_their_own(self):
        def folder_for(source, folder):
            script = '. tools/lib/folders.sh && folder_for "$1" "$2"'
            done = subprocess.run(["bash", "-euc", script, "bash", source, folder], capture_output=True, text=True, check=True, cwd=ROOT)
            self.assertEqual(done.stderr, "")
            return done.stdout.removesuffix("\n")

        with tempfile.TemporaryDirectory() as folder:
            run_folder = pathlib.Path(folder, "run")
            for source, expected in (("/a/run.bag", "run"), ("/b/run.bag", "run-2"), ("/c/run.bag", "run-3"), ("/b/run.bag", "run-2")):
                found = pathlib.Path(folder_for(source, str(run_folder)))
                self.assertEqual(found.name, expected)
                found.mkdir(exist_ok=True)
                (found / "source").write_text(source + "\n")
            for name, file in (("older", "table.md"), ("study", "results.csv")):
                pathlib.Path(folder, name).mkdir()
                pathlib.Path(folder, name, file).write_text("\n")
                self.assertEqual(folder_for("/a/run.bag", str(pathlib.Path(folder, name))), str(pathlib.Path(folder, name + "-2")))

    def test_sudo_may_ask_on_the_terminal_whatever_the_input_is(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in (("sudo", 'echo "sudo $*"'), ("id", "echo 1000")):
                pathlib.Path(folder, name).write_text(f"#!/bin/sh\n{text}\n")
                pathlib.Path(folder, name).chmod(0o755)
            script = f'cd {ROOT} && . tools/lib/setup.sh && PATH={folder}:$PATH && as_root apt-get update </dev/null 2>/dev/null'
            said = subprocess.run(["script", "-qec", f"bash -c '{script}'", "/dev/null"], capture_output=True, text=True,
                                  check=False, stdin=subprocess.DEVNULL, timeout=60)
            self.assertEqual(said.stdout.strip(), "sudo apt-get update", said.stderr)
            alone = subprocess.run(["setsid", "--wait", "bash", "-c", script], capture_output=True, text=True, check=False,
                                   stdin=subprocess.DEVNULL, timeout=60)
            self.assertEqual(alone.stdout.strip(), "sudo -n apt-get update", alone.stderr)

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
