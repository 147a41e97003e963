#!/usr/bin/env python3
"""Which sources may be compiled as one.

usage: neighbours.py < SOURCES > GROUPS

Reads paths of C++ sources, one a line; writes `group:path` for each, eight sources to a group at most.
Two sources of a group share no name: what one declares for itself alone (in an unnamed namespace, static, constexpr, as an
alias or a macro) is no word of the other, nor a name of a header of ours that the other alone includes. Neither calls or names
what only the other's headers declare: so a source cannot lean on an include of a neighbour.
A source that replaces `operator new`, or has a #pragma or #undef, is alone.
"""
import functools
import pathlib
import re
import sys

SIZE = 8
ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = (*sorted(ROOT.glob("framework/*/include")), ROOT / "plugins", ROOT / "tools", ROOT / "tools/simulator/include",
           ROOT / "tests", ROOT)
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
WORD = re.compile(r"[A-Za-z_]\w*")
# What names a function or a type, and not a member: `run(`, `Stage`.
USE = re.compile(r"(?<![\w.])(?<!->)(?:([A-Za-z_]\w*)\s*\(|([A-Z]\w*))")
# The format writes the end of an unnamed namespace so, and no other line.
END = re.compile(r"^\}\s+// namespace$", re.MULTILINE)
ATTRIBUTES = re.compile(r"\[\[.*?\]\]\s*|\balignas\([^)]*\)\s*|\bextern\s+\"\"\s*")
ARGUMENTS = re.compile(r"<[^<>]*>")
TYPE = re.compile(r"(?:struct|class|union|enum(?:\s+class)?|concept)\s+(\w+)")
ENUMERATORS = re.compile(r"\benum\b(?!\s+(?:class|struct)\b)[^{;]*\{([^}]*)\}")
ALIAS = re.compile(r"^(?:using|namespace) (\w+) = (.*);", re.MULTILINE)
BROUGHT = re.compile(r"^using ([\w:]+::(\w+));", re.MULTILINE)
MACRO = re.compile(r"^\s*#\s*define\s+(\w+)", re.MULTILINE)
ALONE = re.compile(r"\boperator\s+(?:new|delete)\b|^\s*#\s*(?:pragma|undef)\b|\busing\s+enum\b", re.MULTILINE)
NO_NAME = {"namespace", "template", "return", "requires", "public", "private", "protected", "using", "operator", "TEST_CASE", "const"}
# Of lines at the margin outside of an unnamed namespace: what is still of this source alone.
OWN = ("static ", "constexpr ", "const ", "using ", "namespace ")


def bare(path):
    """The code of a file: an empty text for each text and comment, but for the ends of unnamed namespaces, which are "}@"."""
    return COMMENT_OR_TEXT.sub('""', END.sub("}@", path.read_text(encoding="utf-8")))


class Source:
    """The words of a source, the names that are its own, and those of its headers."""

    def __init__(self, path):
        text = bare(pathlib.Path(path))
        self.path = path
        self.words = set(WORD.findall(text))
        self.uses = {call or kind for call, kind in USE.findall(text)}
        self.brought = {(name, whole) for whole, name in BROUGHT.findall(text)}
        self.names = set(MACRO.findall(text)) | own_names(text)
        self.aliases = set(ALIAS.findall(text))
        self.headers = reachable(pathlib.Path(path))
        self.alone = ALONE.search(text) is not None

    def fits(self, other):
        if self.alone or other.alone:
            return False
        same = {name for name, _ in self.aliases & other.aliases}  # the same alias twice is one
        return not (self.meets(other, same) or other.meets(self, same))

    def meets(self, other, same):
        only = names_of(other.headers - self.headers)
        brought = {name for name, _ in other.brought - self.brought}
        return self.names & (other.words | only) - same or self.uses & only or (self.names | self.uses) & brought


def names_of(headers):
    return set().union(*map(margin_names, headers))


@functools.lru_cache(None)
def included(path):
    """The headers of ours that a file names, as far as they are found."""
    found = []
    for name in INCLUDE.findall(path.read_text(encoding="utf-8")):
        for folder in (path.parent, *FOLDERS):
            if (folder / name).is_file():
                found.append((folder / name).resolve())
                break
    return found


def reachable(path):
    """The headers of ours that a file includes, directly or through others."""
    seen, open_ones = set(), [path]
    while open_ones:
        for header in included(open_ones.pop()):
            if header not in seen:
                seen.add(header)
                open_ones.append(header)
    return seen


@functools.lru_cache(None)
def margin_names(header):
    """What a header declares outside of classes: the format puts it at the margin."""
    text = bare(header)
    return frozenset({name_of(line) for line in text.splitlines()} - {None}) | set(MACRO.findall(text))


def name_of(line):
    """What a line at the margin declares; None where it is nothing."""
    line = ATTRIBUTES.sub("", line)
    if not line[:1].isalpha() or line.startswith("using ") and " = " not in line:
        return None
    head = line
    while (shorter := ARGUMENTS.sub("", head)) != head:
        head = shorter
    if found := TYPE.search(head):
        return found[1]
    # The name stands before the parameters, an initialiser or the end; an alias has its own before the `=`.
    words = WORD.findall(re.split(r"[({=;\[]", head, maxsplit=1)[0])
    return words[-1] if words and words[-1] not in NO_NAME else None


def own_names(text):
    """What a source declares for itself alone. The format puts declarations of a namespace at the margin."""
    names, inside = set(), False
    for line in text.splitlines():
        if line.startswith("namespace {"):
            inside = True
        elif line.startswith("}@"):
            inside = False
        elif inside or line.startswith(OWN) and not line.rstrip().endswith("{"):
            names.add(name_of(line))
    for enumerators in ENUMERATORS.findall(text):
        names.update(WORD.findall(enumerators))
    return names - {None}


def groups(paths, size=SIZE):
    """Lists of paths: the groups, in the order of their first sources."""
    made = []
    for path in paths:
        source = Source(path)
        for group in made:
            if len(group) < size and all(source.fits(other) for other in group):
                group.append(source)
                break
        else:
            made.append([source])
    return [[source.path for source in group] for group in made]


def main():
    for number, group in enumerate(groups(sys.stdin.read().split("\n")[:-1])):
        for path in group:
            print(f"{number}:{path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
