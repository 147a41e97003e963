"""The prose linter finds long sentences and words to avoid, and leaves code, tables and links alone."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/lint/prose.py"
SHORT = "One short sentence stands here."


def of(count, last="."):
    """A sentence of so many words."""
    return " ".join(["Word"] + ["word"] * (count - 1)) + last


class Prose(unittest.TestCase):
    def run_in(self, pages, *arguments, baseline=None):
        """Exit code, output, baseline and tally of a repository with these pages."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            files = {"tools/lint/prose.py": SCRIPT.read_text(), **pages}
            if baseline is not None:
                files["tools/lint/prose_baseline.txt"] = baseline
            for path, content in files.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(content)
            for command in (["init", "-q"], ["add", "."]):
                subprocess.run(["git", *command], cwd=root, check=True, capture_output=True)
            run = subprocess.run([sys.executable, root / "tools/lint/prose.py", *arguments], cwd=root, capture_output=True,
                                 text=True, check=False)
            self.assertEqual(run.stderr, "")
            self.baseline, self.tally = ((root / name).read_text() if (root / name).exists() else ""
                                         for name in ("tools/lint/prose_baseline.txt", "tally"))
        return run.returncode, run.stdout

    def findings(self, text):
        """Lines of a page that are named."""
        code, output = self.run_in({"README.md": text})
        named = [int(line.split(":")[1]) for line in output.splitlines() if line.startswith("README.md:")]
        self.assertEqual(code, 1 if named else 0, output)
        return named

    def test_length_of_sentences(self):
        self.assertEqual(self.findings(of(25) + " " + of(25) + "\n"), [])
        self.assertEqual(self.findings(of(26) + "\n"), [1])
        self.assertEqual(self.findings(SHORT + "\n" + of(20, "") + "\n" + of(6) + "\n"), [2], "over two lines")
        self.assertEqual(self.findings("> " + of(26) + "\n"), [1])
        self.assertEqual(self.findings("**" + of(26, ".**") + "\n"), [1])

    def test_what_begins_a_sentence(self):
        self.assertEqual(self.findings("- " + of(20, "") + "\n- " + of(20, "") + "\n1. " + of(20, "") + "\n"), [])
        self.assertEqual(self.findings(of(20, "") + "\n\n" + of(20, "") + "\n"), [])
        self.assertEqual(self.findings("- " + of(20, "") + "\n  " + of(20, "") + "\n"), [1])
        self.assertEqual(self.findings(of(20, "! ") + of(20, "? ") + "`word` " + of(20) + "\n"), [])

    def test_stops_that_end_no_sentence(self):
        self.assertEqual(self.findings(of(20, ", e.g. ") + of(20) + "\n"), [1])
        self.assertEqual(self.findings(of(20, " 1.5 ") + of(20) + "\n"), [1])
        self.assertEqual(self.findings(of(20, " of T. ") + of(20) + "\n"), [1])
        self.assertEqual(self.findings(of(20, " of `t`. ") + of(20) + "\n"), [], "a span of code is no initial")

    def test_what_is_no_prose(self):
        long = of(30) + " It told them."
        for text in (f"```\n{long}\n```\n", f"~~~\n{long}\n~~~\n", f"# {long}\n", f"| {long} |\n", f"<!-- {long} -->\n",
                     f"$$\n{long}\n$$\n", f"$$ {long} $$\n", f"A `{long}` stands here.\n", f"![{long}](a.png)\n",
                     f"A [link](a.md \"{long}\") stands here.\n", f"A $x {long}$ stands here.\n"):
            self.assertEqual(self.findings(text), [], text)
        self.assertEqual(self.findings(f"```\n{long}\n```\n{SHORT}\nThey told it.\n"), [5], "numbers go on behind code")
        self.assertEqual(self.findings("A `span\nof code` stands.\nThey told it.\n"), [3])

    def test_words_to_avoid(self):
        for word in ("told", "tells", "Tell", "anew", "of then", "begun", "thereof", "wherein", "mended", "held\nagainst"):
            self.assertEqual(len(self.findings(f"It is {word} here.\n")), 1, word)
        self.assertEqual(self.findings("A [word told](a.md) stands.\n"), [1])
        self.assertEqual(self.findings("Often then, toldo, `told`, [a](told.md), https://a.b/told are fine.\n"), [])
        code, output = self.run_in({"README.md": "It is told.\n"})
        self.assertEqual((code, output.splitlines()[0]), (1, 'README.md:1: "told": better reported, or said'))

    def test_which_pages(self):
        bad = "It is told.\n"
        code, output = self.run_in({"README.md": SHORT, "docs/studies/a.md": bad, "plugins/a.md": bad, "docs/a.txt": bad})
        self.assertEqual(code, 0, output)
        for page in ("CHANGELOG.md", "CONTRIBUTING.md", "docs/a.md", "docs/tutorials/a.md"):
            code, output = self.run_in({page: bad})
            self.assertIn(f"FAILED {page}: 1 findings, 0 allowed", output)
            self.assertEqual(code, 1)
        self.assertEqual(self.run_in({})[0], 1, "no page at all")

    def test_baseline(self):
        pages = {"README.md": SHORT + "\n", "docs/a.md": "It is told.\n\nIt is told anew.\n"}
        code, output = self.run_in(pages, baseline="# remark\n    3 docs/a.md\n")
        self.assertEqual((code, "lower" in output), (0, False), output)
        code, output = self.run_in(pages, baseline="4 docs/a.md\n")
        self.assertEqual(code, 0)
        self.assertIn("note: docs/a.md: 3 findings, 4 allowed: lower the number", output)
        code, output = self.run_in(pages, baseline="3 docs/a.md\n1 docs/gone.md\n")
        self.assertIn("docs/gone.md is in", output)
        code, output = self.run_in(pages, "--update")
        self.assertEqual(code, 0, output)
        self.assertEqual(self.baseline.splitlines()[1:], ["    3 docs/a.md"])

    def test_more_than_the_baseline(self):
        code, output = self.run_in({"docs/a.md": "It is told.\n\nIt is told anew.\n"}, baseline="2 docs/a.md\n")
        self.assertEqual(code, 1)
        self.assertIn("docs/a.md:3: \"anew\"", output)
        self.assertIn("FAILED docs/a.md: 3 findings, 2 allowed", output)

    def test_tally(self):
        self.run_in({"README.md": SHORT, "docs/a.md": "It is told.\n"}, "--tally", "tally")
        self.assertEqual(self.tally, "prose\t1\t1\t0\n")

    def test_usage(self):
        run = subprocess.run([sys.executable, SCRIPT, "--wrong"], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 2)
        self.assertIn("usage:", run.stderr)


if __name__ == "__main__":
    unittest.main()
