#!/usr/bin/env python3
"""Which sources may be compiled as one.

usage: neighbours.py [--size N] < SOURCES > GROUPS

Reads paths of C++ sources, one a line; writes `group:path` for each, N (8) sources to a group at most.
Two sources of a group share no name: what one declares for itself alone (in an unnamed namespace, static, or as a macro)
is no word of the other, nor a name of a header of ours that the other alone includes. So neither can the compiler find a
name twice, nor can a call mean the function of a neighbour.
A source that replaces `operator new` is alone: the compiler may take a neighbour's allocations for its own.
"""
import functools
import pathlib
import re
import sys

SIZE = 8
ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = (*sorted(ROOT.glob("framework/*/include")), ROOT / "plugins", ROOT / "tools", ROOT / "tools/simulator/include", ROOT)
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
WORD = re.compile(r"[A-Za-z_]\w*")
# Of a line at the margin of an unnamed namespace: the name before a bracket, a brace, an initialiser or the end.
TYPE = re.compile(r"(?:template\b.*>\s*)?(?:struct|class|union|enum(?:\s+class)?|concept|using)\s+(\w+)")
VALUE = re.compile(r"[\w:<>,&*\s\[\]()]*?\b(\w+)\s*(?:\(|\{|\[|=|;|$)")
ALIAS = re.compile(r"^(?:using|namespace) (\w+) = (.*);", re.MULTILINE)
MACRO = re.compile(r"^\s*#\s*define\s+(\w+)", re.MULTILINE)
NO_NAME = {"namespace", "template", "return", "requires", "public", "private", "using", "operator"}


class Source:
    """The words of a source, the names that are its own, and those of its headers."""

    def __init__(self, path):
        text = pathlib.Path(path).read_text(encoding="utf-8")
        headers = reachable(pathlib.Path(path))
        text = COMMENT_OR_TEXT.sub('""', text)
        self.path = path
        self.words = set(WORD.findall(text))
        self.names = set(MACRO.findall(text)) | own_names(text)
        self.aliases = set(ALIAS.findall(text))
        self.known = set().union(*map(margin_names, headers))
        self.alone = re.search(r"\boperator\s+(new|delete)\b", text) is not None

    def fits(self, other):
        same = {name for name, _ in self.aliases & other.aliases}  # the same alias twice is one
        return not (self.alone or other.alone or self.meets(other, same) or other.meets(self, same))

    def meets(self, other, same):
        return self.names & (other.words | other.known - self.known) - same


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
    text = COMMENT_OR_TEXT.sub('""', header.read_text(encoding="utf-8"))
    return frozenset(filter(None, map(name_of, text.splitlines())))


def name_of(line):
    """What a line at the margin declares; nothing, where it is none."""
    found = line[:1].isalpha() and (TYPE.match(line) or VALUE.match(line))
    return found[1] if found and found[1] not in NO_NAME and not found[1].isupper() else None  # TEST_CASE


def own_names(text):
    """What a source declares in unnamed namespaces and as static. The format puts declarations of a namespace at the margin."""
    names, inside = set(), False
    for line in text.splitlines():
        if line.startswith("namespace {"):
            inside = True
        elif line.startswith("}"):
            # The end of a function, a type or a namespace: the last has a comment, which is "" here.
            inside = inside and not line.endswith('""')
        elif inside or line.startswith("static "):
            names.add(name_of(line))
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


def main(arguments):
    size = int(arguments[1]) if arguments[:1] == ["--size"] else SIZE
    for number, group in enumerate(groups(sys.stdin.read().split("\n")[:-1], size)):
        for path in group:
            print(f"{number}:{path}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
