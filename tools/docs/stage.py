#!/usr/bin/env python3
"""Collects the pages of the documentation for mkdocs, and checks their links.

usage: stage.py --check                     checks the links, anchors included
       stage.py DIR [--program ASLIO]       checks, then copies the pages and the files that they link to into DIR, and
                                            writes the reference pages from `aslio describe`

Pages keep their places relative to the repository, so their links work here and there.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = re.compile(r"(README|CHANGELOG|CONTRIBUTING)\.md|docs/.*\.md")
LINK = re.compile(r"!?\[[^\]]*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
FILES = ("pipeline", "sensor", "dataset", "family", "scene", "study")
GENERATED = {
    "docs/reference_stages.md": "Stages and their keys",
    "docs/reference_files.md": "Keys of the files",
}


def without_code(text):
    text = re.sub(r"^(\s*)(```+|~~~+).*?^\s*\2\s*$", lambda found: "\n" * found[0].count("\n"), text, flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"(`+)(?!`).+?(?<!`)\1(?!`)", "", text)


def links(text):
    """(line, target) of every link and image."""
    for number, line in enumerate(without_code(text).splitlines(), 1):
        for found in LINK.finditer(line):
            yield number, found[1]


def anchors(text):
    """Anchors of the headings, as GitHub and the site make them."""
    names = set()
    body = re.sub(r"^(\s*)(```+|~~~+).*?^\s*\2\s*$", "", text, flags=re.DOTALL | re.MULTILINE)
    for title in re.findall(r"^#{1,6}\s+(.+?)\s*#*$", body, re.MULTILINE):
        title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).replace("`", "").replace("*", "")
        slug = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        number = 1
        unique = slug
        while unique in names:
            unique, number = f"{slug}-{number}", number + 1
        names.add(unique)
    return names


def pages():
    listed = subprocess.run(["git", "ls-files", "-z", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True)
    return sorted(name for name in listed.stdout.split("\0") if PAGES.fullmatch(name) and (ROOT / name).is_file())


def broken_and_used(names):
    """(messages, files other than pages that are linked to)"""
    messages, used = [], set()
    texts = {name: (ROOT / name).read_text(encoding="utf-8") for name in names}
    for name, text in texts.items():
        for line, target in links(text):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = urllib.parse.unquote(target).partition("#")
            file = (ROOT / name).parent / path if path else ROOT / name
            try:
                other = file.resolve().relative_to(ROOT).as_posix()
            except ValueError:
                messages.append(f"{name}:{line}: {target} is outside the repository")
                continue
            if other in texts:
                if anchor and anchor not in anchors(texts[other]):
                    messages.append(f"{name}:{line}: {other} has no heading #{anchor}")
            elif not file.is_file():
                messages.append(f"{name}:{line}: {target} is no file")
            else:
                used.add(other)
    return messages, used


def described(program, *arguments):
    run = subprocess.run([program, "describe", *arguments, "--markdown"], check=True, capture_output=True, text=True)
    return run.stdout


def write_reference(folder, program):
    texts = dict.fromkeys(GENERATED, "This page is made from `aslio describe --markdown`, and the program was not built.\n")
    if program:
        texts["docs/reference_stages.md"] = re.sub(r"\A# .*\n", "", described(program))
        texts["docs/reference_files.md"] = "\n".join(re.sub(r"\A# ", "## ", described(program, file)) for file in FILES)
    for name, text in texts.items():
        (folder / name).write_text(f"# {GENERATED[name]}\n\n{text}", encoding="utf-8")


def main(arguments):
    program = None
    if len(arguments) == 3 and arguments[1] == "--program":
        program = arguments[2]
        arguments = arguments[:1]
    if len(arguments) != 1 or (arguments[0].startswith("-") and arguments[0] != "--check"):
        print(__doc__, file=sys.stderr)
        return 2
    names = pages()
    messages, used = broken_and_used(names)
    for message in messages:
        print(message)
    print(f"links: {len(names)} pages, {len(messages)} broken links")
    if messages or not names:
        return 1
    if arguments[0] != "--check":
        folder = pathlib.Path(arguments[0])
        shutil.rmtree(folder, ignore_errors=True)
        for name in (*names, *used):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / name)
        (folder / "docs").mkdir(exist_ok=True)
        write_reference(folder, program)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
