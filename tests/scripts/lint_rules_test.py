"""Each house rule finds what it forbids and leaves its neighbour alone."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/lint/lint_rules.py"
MARK = "TO" + "DO"
HOME = "/ho" + "me/somebody/data"


class HouseRules(unittest.TestCase):
    def findings(self, name, text, others=()):
        """Rules that a tree with this one file, and maybe others, breaks. "ROOT" in a text is where the tree stands."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            for path, content in ((name, text), *others, ("tools/lint/lint_rules.py", SCRIPT.read_text())):
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(content.replace('"ROOT/', f'"{root}/'))
            for command in (["init", "-q"], ["add", "."]):
                subprocess.run(["git", *command], cwd=root, check=True, capture_output=True)
            run = subprocess.run([sys.executable, root / "tools/lint/lint_rules.py"], capture_output=True, text=True,
                                 check=False)
        broken = [line[7:] for line in run.stdout.splitlines() if line.startswith("FAILED")]
        self.assertEqual(run.returncode, 1 if broken else 0, run.stdout + run.stderr)
        return broken

    def assert_breaks(self, rule, name, text):
        self.assertTrue(any(rule in found for found in self.findings(name, text)), f"'{rule}' not found in {text!r}")

    def assert_clean(self, name, text):
        self.assertEqual(self.findings(name, text), [])

    def test_directions_of_includes(self):
        self.assert_breaks("includes no plugin", "framework/engine/src/pipeline/a.cpp", '#include "maps/voxel_hash.hpp"\n')
        self.assert_breaks("lies below", "framework/engine/src/core/a.cpp", '#include "aslio/io/source.hpp"\n')
        self.assert_breaks("no other family", "plugins/maps/a.cpp", '#include "windows/fixed.hpp"\n')
        self.assert_breaks("no other family", "plugins/maps/a.cpp", '#include "aslio/io/source.hpp"\n')
        self.assert_breaks("no other family", "plugins/maps/a.cpp", '#include "../windows/fixed.hpp"\n')
        self.assert_clean("plugins/maps/a.cpp", '#include "aslio/stages/map.hpp"\n#include "maps/a.hpp"\n')
        self.assert_clean("plugins/maps/register.cpp", '#include "aslio/plugin/registry.hpp"\n')

    def test_equations(self):
        doc = "docs/equations.md"
        text = "## modules\nAll of them. Tests: `tests/modules`.\n\n**AB-1** x = 1.\n\n**AB-10** y = 2.\nTest: `b_test.cpp`.\n"
        code = ("plugins/maps/a.cpp", "// eq. AB-1\n// eq. AB-10\n")
        tests = (("tests/modules/a.cpp", "// eq. AB-1\n"), ("tests/b_test.cpp", "// AB-10\n"))
        self.assertEqual(self.findings(doc, text, (code, *tests)), [])
        rule = ["every equation is cited in code and in the test it names"]
        self.assertEqual(self.findings(doc, text, tests), rule)
        self.assertEqual(self.findings(doc, text, ((code[0], "// eq. AB-10\n"), *tests)), rule)
        self.assertEqual(self.findings(doc, text, (code, tests[0])), rule)
        self.assertEqual(self.findings(doc, text.replace("`tests/modules`", "some"), (code, *tests)), rule)
        self.assertEqual(self.findings(doc, text.replace("b_test", "c_test"), (code, *tests)), rule)

    def test_threads(self):
        self.assert_breaks("only in exec", "plugins/maps/a.cpp", "#pragma omp parallel for\n")
        self.assert_breaks("only in exec", "framework/io/src/io/a.cpp", "std::thread t;\n")
        self.assert_clean("framework/engine/src/exec/a.cpp", "#pragma omp parallel for\n")

    def test_printing(self):
        self.assert_breaks("printing", "plugins/maps/a.cpp", 'std::cout << "x";\n')
        self.assert_breaks("printing", "framework/io/src/io/a.cpp", 'printf("x");\n')
        self.assert_clean("framework/io/src/io/a.cpp", 'std::snprintf(b, 3, "x");\n')
        self.assert_clean("tools/aslio/a.cpp", 'std::printf("x");\n')

    def test_determinism(self):
        self.assert_breaks("random", "plugins/maps/a.cpp", "std::normal_distribution<double> d;\n")
        self.assert_breaks("unordered", "plugins/maps/a.cpp", "std::unordered_map<int, int> m;\nfor (auto& e : m) f(e);\n")
        self.assert_clean("plugins/maps/a.cpp", "std::unordered_map<int, int> m;\nm.find(3);\n")

    def test_text(self):
        self.assert_breaks("unfinished", "docs/a.md", f"{MARK}: more\n")
        self.assert_breaks("one machine", "docs/a.md", f"see {HOME}\n")
        self.assert_breaks("std::views", "plugins/maps/a.cpp", "auto v = x | std::views::all;\n")
        self.assert_breaks("500 lines", "plugins/maps/a.cpp", "int a;\n" * 501)
        self.assert_clean("plugins/maps/a.cpp", "int a;\n" * 500)

    def test_suppressions_and_tests(self):
        self.assert_breaks("suppression", "plugins/maps/a.cpp", "int a;  // NOLINT\n")
        self.assert_clean("plugins/maps/a.cpp", "int a;  // NOLINT(some-check): the reason\n")
        self.assert_breaks("cannot fail", "tests/core/a.cpp", 'TEST_CASE("x", "[.]") {}\n')
        self.assert_breaks("cannot fail", "tests/core/a.cpp", 'TEST_CASE("x; y") {}\n')
        self.assert_breaks("cannot fail", "tests/core/a.cpp", 'TEST_CASE(\n    "x "\n    "y; z") {}\n')
        self.assert_clean("tests/core/a.cpp", 'TEST_CASE(\n    "x "\n    "y") {\n  CHECK(a == "b; c");\n}\n')

    def test_schema(self):
        self.assert_breaks("schema", "configs/pipelines/a.yaml", "window: {}\n")
        self.assert_clean("configs/pipelines/a.yaml", "# words\nschema: aslio/pipeline/1\n")


if __name__ == "__main__":
    unittest.main()
