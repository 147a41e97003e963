"""The pages of the documentation: their links hold, and a link that does not is named."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tools/docs/stage.py"


class DocsSite(unittest.TestCase):
    def run_in(self, files, *arguments):
        """Exit code, output and the files that were staged, of a repository with these files."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            for path, content in {**files, "tools/docs/stage.py": SCRIPT.read_text()}.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(content)
            for command in (["init", "-q"], ["add", "."]):
                subprocess.run(["git", *command], cwd=root, check=True, capture_output=True)
            run = subprocess.run([sys.executable, root / "tools/docs/stage.py", *arguments], cwd=root, capture_output=True,
                                 text=True, check=False)
            self.assertEqual(run.stderr, "")
            site = root / "site"
            staged = {path.relative_to(site).as_posix(): path.read_text() for path in site.rglob("*") if path.is_file()}
        return run.returncode, run.stdout, staged

    def broken(self, files):
        code, output, _ = self.run_in(files, "--check")
        messages = output.splitlines()[:-1]
        self.assertEqual(code, 1 if messages else 0, output)
        return messages

    def test_links_of_this_repository(self):
        run = subprocess.run([sys.executable, SCRIPT, "--check"], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_pages_of_the_navigation(self):
        pages = [line.split(": ")[-1] for line in (ROOT / "tools/docs/mkdocs.yml").read_text().splitlines()
                 if line.lstrip().startswith("- ") and line.endswith(".md")]
        made = ("docs/reference_stages.md", "docs/reference_files.md")
        self.assertGreater(len(pages), 20)
        self.assertEqual([page for page in pages if page not in made and not (ROOT / page).is_file()], [])

    def test_broken_links(self):
        self.assertEqual(self.broken({"README.md": "[a](docs/a.md) [b](LICENSE)\n", "docs/a.md": "[r](../README.md)\n", "LICENSE": ""}), [])
        self.assertEqual(self.broken({"README.md": "\n[a](docs/a.md)\n"}), ["README.md:2: docs/a.md is no file"])
        self.assertEqual(self.broken({"docs/a.md": "![a](figures/a.png)\n"}), ["docs/a.md:1: figures/a.png is no file"])
        self.assertEqual(self.broken({"README.md": "[a](../../a.md)\n"}), ["README.md:1: ../../a.md is outside the repository"])

    def test_broken_anchors(self):
        page = "# One\n\n## What `a.csv` has\n\n## Two\n\n## Two\n\n```\n# no heading\n```\n"
        good = "".join(f"[x](docs/a.md#{anchor})\n" for anchor in ("one", "what-acsv-has", "two", "two-1"))
        self.assertEqual(self.broken({"README.md": good, "docs/a.md": page + "[here](#one)\n"}), [])
        for anchor in ("three", "no-heading", "two-2"):
            self.assertEqual(self.broken({"README.md": f"[x](docs/a.md#{anchor})\n", "docs/a.md": page}),
                             [f"README.md:1: docs/a.md has no heading #{anchor}"])

    def test_what_is_no_link(self):
        self.assertEqual(self.broken({"README.md": "`[a](gone.md)`\n\n```\n[a](gone.md)\n```\n<https://a.b> [a](https://a.b/c)\n"}), [])

    def test_what_is_staged(self):
        files = {"README.md": "[a](docs/a.md) [l](LICENSE)\n", "docs/a.md": "# A\n", "LICENSE": "text", "other.txt": "not linked to"}
        code, output, staged = self.run_in(files, "site")
        self.assertEqual(code, 0, output)
        self.assertEqual(sorted(staged), ["LICENSE", "README.md", "docs/a.md", "docs/reference_files.md", "docs/reference_stages.md"])
        self.assertIn("was not built", staged["docs/reference_stages.md"])

    def test_reference_of_the_program(self):
        program = "#!/bin/sh\necho \"# $*\"\necho text\n"
        files = {"README.md": "a\n", "aslio": program}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "aslio"
            path.write_text(program)
            path.chmod(0o755)
            code, output, staged = self.run_in(files, "site", "--program", str(path))
        self.assertEqual(code, 0, output)
        self.assertEqual(staged["docs/reference_stages.md"], "# Stages and their keys\n\ntext\n")
        self.assertIn("## describe scene --markdown\ntext\n", staged["docs/reference_files.md"])


if __name__ == "__main__":
    unittest.main()
