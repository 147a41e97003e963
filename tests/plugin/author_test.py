"""What the author of a plugin does, by the commands of docs/howto_new_plugin.md: install aslio, write a project for a
stage, build it against the installation, list, describe, study and check it.

usage: author_test.py BUILD_DIR WORK_DIR CXX [LAUNCHER]   (LAUNCHER: ccache; WORK_DIR is emptied first)
"""
import csv
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

BUILD, WORK, CXX, LAUNCHER = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]
SOURCE = pathlib.Path(__file__).resolve().parents[2]
FAMILIES = ("estimators", "histories", "insertions", "maps", "motions", "overlaps", "residuals", "samplers", "stores", "windows")


def run(*command, expect=0, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False, **options)
    if expect is not None and done.returncode != expect:
        raise AssertionError(f"{command} ended with {done.returncode}, not {expect}:\n{done.stdout}\n{done.stderr}")
    return done


def configure(source, build, prefix):
    launcher = [f"-DCMAKE_CXX_COMPILER_LAUNCHER={LAUNCHER[0]}"] if LAUNCHER else []
    run("cmake", "-S", source, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={CXX}",
        *launcher)
    found = re.search(r"^aslio_DIR:PATH=(.*)$", (build / "CMakeCache.txt").read_text(), re.M)
    assert found and found.group(1).startswith(str(prefix) + "/"), f"found another aslio: {found}"


class Author(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # The same at every run: ccache knows a compilation by its paths.
        cls.root = pathlib.Path(WORK).resolve()
        shutil.rmtree(cls.root, ignore_errors=True)
        cls.root.mkdir(parents=True)
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.prefix = cls.root / "prefix"
        run("cmake", "--install", BUILD, "--prefix", cls.prefix)
        cls.program = cls.prefix / "bin" / "aslio"

    def aslio(self, *arguments, expect=0, plugins=None):
        environment = dict(os.environ)
        environment.pop("ASLIO_PLUGIN_PATH", None)
        if plugins:
            environment["ASLIO_PLUGIN_PATH"] = str(plugins)
        return run(self.program, *arguments, expect=expect, env=environment, cwd=self.root)

    def project(self, family, name, folder):
        self.aslio("new-plugin", f"{family}/{name}", folder)
        return self.root / folder

    def study(self, source, out, plugins):
        """The runs of the project's study by method; every one has come to its end near the truth."""
        self.aslio("check", source / "study" / "study.yaml", plugins=plugins)
        self.aslio("experiment", source / "study" / "study.yaml", "--output", out, "--data", self.root / "data", "--seeds",
                   "1", "--quiet", plugins=plugins)
        with open(out / "results.csv", encoding="utf-8", newline="") as file:
            runs = {row["method"]: row for row in csv.DictReader(file)}
        for method, row in runs.items():
            self.assertIn(row["status"], ("ok", "degraded"), msg=f"{source.name}: {method}: {row['reason']}")
            self.assertLess(float(row["ate_m"]), 0.2, msg=f"{source.name}: {method}")
        return runs

    def test_a_window_from_nothing_to_a_study(self):
        source = self.project("windows", "my_window", "window")
        self.assertEqual(sorted(str(p.relative_to(source)) for p in source.rglob("*") if p.is_file()),
                         ["CMakeLists.txt", "README.md", "my_window.cpp", "my_window.hpp", "study/as_lio_plus.yaml",
                          "study/scene.yaml", "study/study.yaml"])
        build = source / "build"
        configure(source, build, self.prefix)
        warned = run("cmake", "--build", build).stdout
        self.assertNotIn("warning", warned)
        # The repository has no part in it.
        for room in ("framework", "plugins", "tests", "cmake"):
            self.assertNotIn(f"{SOURCE / room}/", (build / "build.ninja").read_text())

        listed = self.aslio("list", "windows", plugins=build).stdout
        self.assertRegex(listed, r"(?m)^  my_window .*\[.*my_window\.so\]$")
        self.assertNotIn("my_window", self.aslio("list", "windows").stdout)
        described = self.aslio("describe", "windows/my_window", "--plugin", build / "my_window.so").stdout
        for key in ("period", "turning_period", "turn_rate"):
            self.assertRegex(described, rf"\b{key}\b")

        contract = run("ctest", "--test-dir", build, "--output-on-failure").stdout
        self.assertRegex(contract, r"100% tests passed, 0 tests failed out of 1")

        out = self.root / "out"
        runs = self.study(source, out, plugins=build)
        self.assertEqual(sorted(runs), ["my_window", "sod_adaptive"])
        self.assertNotEqual(runs["my_window"]["updates"], runs["sod_adaptive"]["updates"])
        self.assertRegex((out / "table.md").read_text(encoding="utf-8"), r"my_window")

    def test_the_template_of_every_family_builds_and_keeps_its_contract(self):
        every = self.root / "every"
        every.mkdir()
        text = ["cmake_minimum_required(VERSION 3.25)", "project(every LANGUAGES CXX)", "enable_testing()",
                "set(CMAKE_BUILD_TYPE Release)", "find_package(aslio 0.2 REQUIRED)"]
        families = [line for line in self.aslio("list").stdout.splitlines() if not line.startswith(" ")]
        self.assertEqual(families, list(FAMILIES))
        for family in families:
            self.project(family, f"my_{family}", pathlib.Path("every") / family)
            text.append(f"add_subdirectory({family})")
        # A window that leaves points out: the suite must say so.
        bad = self.project("windows", "forgetful", pathlib.Path("every") / "forgetful")
        code = (bad / "forgetful.cpp").read_text()
        self.assertIn("plan.fresh_begin = begin;", code)
        (bad / "forgetful.cpp").write_text(code.replace("plan.fresh_begin = begin;", "plan.fresh_begin = begin + 1000000;"))
        text.append("add_subdirectory(forgetful)")
        (every / "CMakeLists.txt").write_text("\n".join(text) + "\n")
        build = every / "build"
        configure(every, build, self.prefix)
        self.assertNotIn("warning", run("cmake", "--build", build).stdout)

        results = run("ctest", "--test-dir", build, "-j2", "--output-on-failure", expect=None).stdout
        for family in families:
            self.assertRegex(results, rf"contract: {family}/my_{family} \.+ +Passed", msg=results[-4000:])
        self.assertRegex(results, r"contract: windows/forgetful \.+\**Failed")
        self.assertIn("plan.fresh_begin == begin", results)  # what it failed at
        self.assertRegex(results, r"1 tests failed out of 11")

        objects = ":".join(str(build / family) for family in families)
        for family in families:
            runs = self.study(every / family, self.root / f"out_{family}", plugins=objects)
            self.assertTrue({f"my_{family}", "sod_adaptive"} <= set(runs))
            if family == "stores":  # all of them answer alike
                self.assertEqual(runs["my_stores"]["ate_m"], runs["sod_adaptive"]["ate_m"])

    def test_what_cannot_be_written_is_refused_and_leaves_nothing(self):
        (self.root / "there").mkdir()
        (self.root / "file").write_text("")
        cases = [
            (("window/my_window", "new"), 2, "unknown family 'window' (did you mean 'windows'?); there are: estimators, "),
            (("my_window", "new"), 2, "FAMILY/NAME"),
            (("windows/", "new"), 2, "is no name for a stage"),
            (("windows/MyWindow", "new"), 2, "'MyWindow' is no name for a stage"),
            (("windows/my__window", "new"), 2, "is no name for a stage"),
            (("windows/../../evil", "new"), 2, "is no name for a stage"),
            (("windows/" + "a" * 41, "new"), 2, "is no name for a stage"),
            (("windows/fixed", "new"), 2, "there is a stage windows/fixed already (built-in)"),
            (("windows/my_window", "there"), 2, "there: exists already"),
            (("windows/my_window", "there/"), 2, "there: exists already"),
            (("windows/my_window", "file"), 2, "file: exists already"),
            (("windows/my_window", "none/new"), 2, "no such folder to make 'new' in"),
            (("windows/my_window", "/proc/new"), 2, "/proc/new: cannot be made"),
        ]
        before = sorted(p.name for p in self.root.iterdir())
        for arguments, code, message in cases:
            with self.subTest(arguments):
                done = self.aslio("new-plugin", *arguments, expect=code)
                self.assertIn(message, done.stderr)
                self.assertEqual(done.stdout, "")
                self.assertEqual(sorted(p.name for p in self.root.iterdir()), before)

    def test_a_failing_disk_leaves_nothing(self):
        before = sorted(p.name for p in self.root.iterdir())
        limited = f"ulimit -f 0; exec {self.program} new-plugin windows/my_window {self.root}/new"
        done = run("bash", "-c", limited, expect=3)
        self.assertIn("cannot be written", done.stderr)
        self.assertEqual(sorted(p.name for p in self.root.iterdir()), before)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
