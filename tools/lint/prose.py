#!/usr/bin/env python3
"""Long sentences and words to avoid in README.md, CHANGELOG.md, CONTRIBUTING.md and docs.

usage: prose.py [--tally FILE] [--update] [--counts] [FILE.md...]

Prints "file:line: message". Without files it checks all tracked pages but docs/studies, which a script writes, and
compares the number of findings per page with tools/lint/prose_baseline.txt. A page not listed there may have none.
More findings than listed are a failure; fewer print a request to lower the number, and --update writes it.
--counts prints words, sentences, words per sentence and the longest sentence of each page instead.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BASELINE = ROOT / "tools/lint/prose_baseline.txt"
PAGES = re.compile(r"(README|CHANGELOG|CONTRIBUTING)\.md|docs/(?!studies/).*\.md")
LONGEST = 25
# What to write instead, by the words to avoid. Patterns ignore case; code and targets of links do not count.
AVOID = tuple((re.compile(r"\b(?:" + words.replace(" ", r"\s+") + r")\b", re.IGNORECASE), better) for words, better in (
    ("told", "reported, or said"),
    ("tells?", "reports, prints, or says"),
    ("anew", "again"),
    ("of then", "at that time"),
    ("of today|today's", "current"),
    ("begun", "started"),
    ("thereof|therein|herein|hereby", "name the thing"),
    ("wherein", "in which"),
    ("whereof|whereby", "of which, by which"),
    ("whilst", "while"),
    ("amongst", "among"),
    ("upon", "on"),
    ("utili[sz]e[sd]?", "use"),
    ("prior to", "before"),
    ("in order to", "to"),
    ("mend(?:s|ed|ing)?", "fix"),
    ("held against", "compared with"),
    ("(?:to|by) the letter", "name the pipeline: as_lio, or say exactly"),
    ("recorded(?: Avia)? corridor", "the corridor of the independent simulator: it is not a recording"),
))
FENCE = re.compile(r"\s*(```+|~~~+)")
ITEM = re.compile(r"\s*(?:[-*+]|\d+[.)])\s+(?:\[[ x]\]\s+)?")
# One word each, whatever is inside; the newlines inside stay, for the line numbers.
SPANS = (
    re.compile(r"<!--.*?-->", re.DOTALL),
    re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)", re.DOTALL),
    re.compile(r"\$\$.+?\$\$|\$(?=\S)[^$]+?(?<=\S)\$(?!\d)", re.DOTALL),
)
IMAGE = re.compile(r"!\[[^\]]*\]\([^)]*\)")
LINK = re.compile(r"\[([^\]]*)\](?:\([^)]*\)|\[[^\]]*\])")
ADDRESS = re.compile(r"<?https?://[^\s>]*[^\s>.,;)]>?")
# A full stop that ends no sentence.
SHORT = re.compile(r"(?:\b(?:e\.g|i\.e|cf|vs|etc|al|eqs?|Eqs?|[Ff]igs?|[Ss]ec|[Tt]ab|approx|resp|no|No|St)|(?:^|\s|\()[A-Z])\.$")
END = re.compile(r"[.!?][\"')\]*_]*(?=\s+[\"'(\[*_]*[A-Z0-9]|\s*$)")


def blocks(text):
    """(line, text) of every paragraph and list item."""
    start, lines, fence, math = 0, [], "", False
    for number, line in enumerate(text.splitlines() + [""], 1):
        found = FENCE.match(line)
        if fence:
            if found and found[1].startswith(fence):
                fence = ""
            continue
        math_line = line.strip()
        if math:
            math = not math_line.endswith("$$")
            continue
        bare = re.sub(r"^\s*(?:>\s?)+", "", line)
        skip = found or math_line.startswith("$$") or bare.lstrip().startswith(("|", "#")) \
            or re.match(r"\[[^\]]+\]: ", bare) or not bare.strip() or re.fullmatch(r"\s*[-=*_]{3,}\s*", bare)
        item = ITEM.match(bare)
        if (skip or item) and lines:
            yield start, "\n".join(lines)
            lines = []
        if skip:
            fence = found[1] if found else ""
            math = math_line.startswith("$$") and not (len(math_line) > 2 and math_line.endswith("$$"))
            continue
        if not lines:
            start = number
        lines.append(bare[item.end():] if item else bare)


def plain(text):
    """Without what is not prose: a span of code or mathematics is one word X."""
    for span in SPANS:
        text = span.sub(lambda found: "X" + "\n" * found[0].count("\n"), text)
    text = IMAGE.sub(lambda found: "\n" * found[0].count("\n"), text)
    text = LINK.sub(lambda found: found[1] + "\n" * (found[0].count("\n") - found[1].count("\n")), text)
    return ADDRESS.sub("X", text)


def sentences(text):
    """(offset, sentence) of a block."""
    begin = 0
    for end in END.finditer(text):
        # The two letters before "X." may be an initial, but a span of code is an X of our own.
        head = text[begin:end.start() + 1]
        if end[0].startswith(".") and SHORT.search(head) and not head.endswith("X.") and end.end() < len(text.rstrip()):
            continue
        yield begin, text[begin:end.end()]
        begin = end.end()
    if text[begin:].strip():
        yield begin, text[begin:]


def words(sentence):
    return sum(any(letter.isalnum() for letter in word) for word in sentence.split())


def line_at(start, text, offset):
    return start + text.count("\n", 0, offset)


def measured(text):
    """Words of every sentence of a page."""
    return [count for _, block in blocks(text) for _, sentence in sentences(plain(block)) if (count := words(sentence))]


def findings(text):
    """(line, message) of a page, in the order of its lines."""
    found = []
    for start, block in blocks(text):
        prose = plain(block)
        for offset, sentence in sentences(prose):
            offset += len(sentence) - len(sentence.lstrip())
            if (count := words(sentence)) > LONGEST:
                found.append((line_at(start, prose, offset), f"a sentence of {count} words; at most {LONGEST}"))
        for pattern, better in AVOID:
            for use in pattern.finditer(prose):
                word = " ".join(use[0].split())
                found.append((line_at(start, prose, use.start()), f"\"{word}\": better {better}"))
    return sorted(found)


def tracked():
    listed = subprocess.run(["git", "ls-files", "-z", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True)
    return sorted(name for name in listed.stdout.split("\0") if PAGES.fullmatch(name) and (ROOT / name).is_file())


def read_baseline():
    if not BASELINE.is_file():
        return {}
    rows = (line.split() for line in BASELINE.read_text(encoding="utf-8").splitlines() if line and line[0] != "#")
    return {name: int(count) for count, name in rows}


def write_baseline(counts):
    rows = [f"{count:5} {name}\n" for name, count in sorted(counts.items()) if count]
    BASELINE.write_text("# Findings of prose.py that each page may still have; `prose.py --update` writes this file.\n"
                        + "".join(rows), encoding="utf-8")


def print_counts(texts):
    for name, text in texts.items():
        lengths = measured(text)
        each = sum(lengths) / len(lengths) if lengths else 0.0
        print(f"{name}: {sum(lengths)} words, {len(lengths)} sentences, {each:.1f} words each, "
              f"longest {max(lengths, default=0)}")


def check(texts, allowed):
    """The number of pages with more findings than allowed."""
    failed = 0
    for name, text in texts.items():
        found = findings(text)
        limit = allowed.get(name, 0)
        if len(found) > limit:
            failed += 1
            for line, message in found:
                print(f"{name}:{line}: {message}")
            print(f"FAILED {name}: {len(found)} findings, {limit} allowed")
        elif len(found) < limit:
            print(f"note: {name}: {len(found)} findings, {limit} allowed: lower the number (tools/lint/prose.py --update)")
    return failed


def main(arguments):
    tally, names, options = None, [], set()
    rest = list(arguments)
    while rest:
        argument = rest.pop(0)
        if argument == "--tally" and rest:
            tally = rest.pop(0)
        elif argument in ("--update", "--counts"):
            options.add(argument)
        elif argument.startswith("-"):
            print(__doc__, file=sys.stderr)
            return 2
        else:
            names.append(argument)
    texts = {name: (pathlib.Path(name) if names else ROOT / name).read_text(encoding="utf-8") for name in names or tracked()}
    if "--counts" in options:
        print_counts(texts)
        return 0
    if names:
        return 1 if check(texts, {}) else 0
    if "--update" in options:
        write_baseline({name: len(findings(text)) for name, text in texts.items()})
    failed = check(texts, read_baseline())
    gone = sorted(set(read_baseline()) - set(texts))
    for name in gone:
        print(f"note: {name} is in tools/lint/prose_baseline.txt and not in the repository (tools/lint/prose.py --update)")
    print(f"prose: {len(texts) - failed} pages passed, {failed} failed")
    if tally:
        with open(tally, "a", encoding="utf-8") as file:
            file.write(f"prose\t{len(texts) - failed}\t{failed}\t0\n")
    return 1 if failed or not texts else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
