#!/usr/bin/env python3
"""Which sources may be compiled as one.

usage: neighbours.py [--size N] < SOURCES > GROUPS

Reads paths of C++ sources, one a line; writes `group:path` for each, N (8) sources to a group at most.
Two sources of a group share no name: what one declares for itself alone (in an unnamed namespace, static, or as a macro)
is no word of the other. So neither can the compiler find a name twice, nor can a call mean the function of a neighbour.
A source that replaces `operator new` is alone: the compiler may take a neighbour's allocations for its own.
"""
import pathlib
import re
import sys

SIZE = 8
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
WORD = re.compile(r"[A-Za-z_]\w*")
# Of a line at the margin of an unnamed namespace: the name before a bracket, a brace, an initialiser or the end.
TYPE = re.compile(r"(?:template\b.*>\s*)?(?:struct|class|union|enum(?:\s+class)?|concept|using)\s+(\w+)")
VALUE = re.compile(r"[\w:<>,&*\s\[\]()]*?\b(\w+)\s*(?:\(|\{|\[|=|;|$)")
ALIAS = re.compile(r"^(?:using|namespace) (\w+) = (.*);", re.MULTILINE)
MACRO = re.compile(r"^\s*#\s*define\s+(\w+)", re.MULTILINE)
NO_NAME = {"namespace", "template", "return", "requires", "public", "private", "using", "operator"}


class Source:
    """The words of a source, and the names that are its own."""

    def __init__(self, path):
        text = COMMENT_OR_TEXT.sub('""', pathlib.Path(path).read_text(encoding="utf-8"))
        self.path = path
        self.words = set(WORD.findall(text))
        self.names = set(MACRO.findall(text)) | own_names(text)
        self.aliases = set(ALIAS.findall(text))
        self.alone = re.search(r"\boperator\s+(new|delete)\b", text) is not None

    def fits(self, other):
        same = {name for name, _ in self.aliases & other.aliases}  # the same alias twice is one
        return not (self.alone or other.alone or self.names & other.words - same or other.names & self.words - same)


def own_names(text):
    """What a source declares in unnamed namespaces and as static. The format puts declarations of a namespace at the margin."""
    names, inside = set(), False
    for line in text.splitlines():
        if line.startswith("namespace {"):
            inside = True
        elif line.startswith("}"):
            # The end of a function, a type or a namespace: the last has a comment, which is "" here.
            inside = inside and not line.endswith('""')
        elif (inside or line.startswith("static ")) and line[:1].isalpha():
            found = TYPE.match(line) or VALUE.match(line)
            if found and found[1] not in NO_NAME and not found[1].isupper():  # TEST_CASE
                names.add(found[1])
    return names


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
