#!/usr/bin/env python3
"""The rules of docs/architecture.md that a compiler does not check.

usage: lint_rules.py [--tally FILE]

Each rule is one check: it passes, or every line that breaks it is named.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
CODE = (".cpp", ".hpp")
TEXT = CODE + (".py", ".sh", ".cmake", ".txt", ".md", ".yaml", ".yml", ".json", ".in", ".cff", ".js", ".mjs", ".css", "")
FAMILIES = ("windows", "overlaps", "stores", "maps", "estimators", "motions", "residuals", "samplers", "histories",
            "insertions")
# What a module of the framework may include: arrows point from the experiment down to the core.
MODULES = {
    "core": {"core"},
    "config": {"core", "config"},
    "exec": {"core", "exec"},
    "stages": {"core", "config", "exec", "stages"},
    "plugin": {"core", "config", "exec", "stages", "plugin"},
    "stream": {"core", "stages", "stream"},
    "pipeline": {"core", "config", "exec", "plugin", "stages", "stream", "pipeline"},
    "toolkit": {"core", "config", "exec", "stages", "toolkit"},
    "io": {"core", "config", "exec", "io"},
    "evaluation": {"core", "evaluation"},
    "statistics": {"core", "statistics"},
    "experiment": {"core", "config", "exec", "plugin", "stages", "stream", "pipeline", "io", "evaluation", "statistics",
                   "experiment"},
    "report": {"core", "config", "io", "evaluation", "experiment", "report"},
}
PLUGIN_MAY = {"core", "stages", "config", "exec", "toolkit"}
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]')
COMMENT = re.compile(r"//.*$")
EQUATION = re.compile(r"\*\*([A-Z]+-\d+)\*\* ")
NAMED_TEST = re.compile(r"`(tests/[\w/]+(?:\.cpp)?|test_\w+\.cpp|\w+_test\.cpp)`")
# Engines and containers whose order or sequence differs between libraries or runs.
FOREIGN_RANDOM = re.compile(r"std::(normal|uniform_real|uniform_int|bernoulli|poisson|exponential)_distribution|"
                            r"std::random_device|\bs?rand\s*\(")
UNORDERED = re.compile(r"unordered_(?:multi)?(?:map|set)<[^;]*>[&\s]+(\w+)")


class Source:
    """A tracked file and where it stands."""

    def __init__(self, name):
        self.name = name
        self.parts = name.split("/")
        self.suffix = pathlib.PurePosixPath(name).suffix
        self.lines = (ROOT / name).read_text(encoding="utf-8").splitlines()

    def within(self, *tops):
        return any(self.name.startswith(top + "/") for top in tops)

    def code(self):
        """(number, line without a // comment)"""
        return [(i, COMMENT.sub("", line)) for i, line in enumerate(self.lines, 1)]

    def includes(self):
        for i, line in enumerate(self.lines, 1):
            match = INCLUDE.match(line)
            if match:
                yield i, match.group(1)

    def module(self):
        """Room of the framework, or None."""
        if self.parts[0] != "framework" or len(self.parts) < 5:
            return None
        return self.parts[4] if self.parts[2] == "include" else self.parts[3]

    def family(self):
        return self.parts[1] if self.parts[0] == "plugins" and len(self.parts) > 2 else None


def tracked():
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    wanted = [n for n in names.split("\0") if n and pathlib.PurePosixPath(n).suffix in TEXT and (ROOT / n).is_file()]
    return [Source(name) for name in wanted if name != "tools/lint/lint_rules.py"]


def matching(sources, pattern, *tops, code=True, but=()):
    """Lines of C++ under `tops` that match."""
    for source in sources:
        if source.suffix in CODE and (not tops or source.within(*tops)) and not (but and source.within(*but)):
            for i, line in source.code() if code else enumerate(source.lines, 1):
                if re.search(pattern, line):
                    yield source, i, line.strip()


def framework_knows_no_plugin(sources):
    for source in sources:
        if source.within("framework"):
            for i, path in source.includes():
                if path.startswith("plugins/") or "register_all" in path or path.split("/")[0] in FAMILIES:
                    yield source, i, path


def modules_keep_their_arrows(sources):
    for source in sources:
        module = source.module()
        if module is None or source.suffix not in CODE:
            continue
        for i, path in source.includes():
            parts = path.split("/")
            if parts[0] == "aslio" and len(parts) > 2 and parts[1] not in MODULES.get(module, {module}):
                yield source, i, f"{module} may not include {path}"


def families_stay_apart(sources):
    for source in sources:
        family = source.family()
        if family is None or source.suffix not in CODE:
            continue
        for i, path in source.includes():
            parts = path.split("/")
            if parts[0] in FAMILIES and parts[0] != family or ".." in parts:
                yield source, i, f"{family} may not include {path}"
            registers = source.parts[-1].startswith("register") and path == "aslio/plugin/registry.hpp"
            if parts[0] == "aslio" and parts[1] not in PLUGIN_MAY and not registers:
                yield source, i, f"a plugin may not include {path}"


def threads_only_in_exec(sources):
    return matching(sources, r"#\s*pragma\s+omp|[<\"]omp\.h|std::(jthread|thread|async)\b", "framework", "plugins",
                    but=("framework/engine/src/exec",))


def no_printing(sources):
    return matching(sources, r"std::(cout|cerr|clog)\b|(?<![\w:.])(std::)?(printf|puts|putchar)\s*\(|fprintf\s*\(\s*std(out|err)",
                    "framework", "plugins")


def no_views(sources):
    return matching(sources, r"std::(ranges::)?views\b")


def own_random_numbers(sources):
    return matching(sources, FOREIGN_RANDOM, "framework", "plugins", "tools")


def no_unordered_iteration(sources):
    for source in sources:
        if source.suffix not in CODE or not source.within("framework", "plugins"):
            continue
        names = {name for _, line in source.code() for name in UNORDERED.findall(line)}
        for i, line in source.code():
            loop = re.search(r"for\s*\(.*:\s*\*?(\w+)\s*\)", line)
            if loop and loop.group(1) in names:
                yield source, i, line.strip()


def no_test_that_cannot_fail(sources):
    # A semicolon ends the name that ctest hands over: no test has the rest, none runs, and that passes.
    for source in sources:
        if source.suffix not in CODE or not source.within("tests"):
            continue
        code = list(source.code())
        text = "\n".join(line for _, line in code)  # a name may go over several lines
        for found in re.finditer(r'TEST_CASE\s*\(\s*(?:"[^"]*"\s*)*"[^"]*;', text):
            yield source, code[text.count("\n", 0, found.start())][0], found.group()
    yield from matching(sources, r"\bSUCCEED\s*\(|TEST_CASE\s*\(.*\[\.|REQUIRE\s*\(\s*true\s*\)|CHECK\s*\(\s*true\s*\)", "tests")


def files_of_one_purpose(sources):
    for source in sources:
        if source.suffix in CODE + (".py", ".sh", ".cmake", ".js", ".mjs", ".css") and len(source.lines) > 500:
            yield source, len(source.lines), "more than 500 lines"


def nothing_unfinished(sources):
    for source in sources:
        for i, line in enumerate(source.lines, 1):
            if re.search(r"\b(TODO|FIXME|XXX|HACK|TBD)\b|not (yet )?implemented", line):
                yield source, i, line.strip()


def no_machine_paths(sources):
    for source in sources:
        for i, line in enumerate(source.lines, 1):
            if re.search(r"(?<![\w.}])/(work|tmp|home|root|Users)/\w", line):
                yield source, i, line.strip()


def suppressions_have_reasons(sources):
    for source in sources:
        if source.suffix in CODE:
            for i, line in enumerate(source.lines, 1):
                if "NOLINT" in line and "NOLINTEND" not in line and not re.search(r"NOLINT\w*\([\w.,* -]+\):? ?\S", line):
                    yield source, i, line.strip()


def yaml_names_its_schema(sources):
    for source in sources:
        if source.suffix in (".yaml", ".yml") and source.within("configs", "experiments"):
            first = next((line for line in source.lines if line.strip() and not line.startswith("#")), "")
            if not re.match(r"schema: aslio/(pipeline|sensor|scene|dataset|family|study)/1$", first.strip()):
                yield source, 1, "does not begin with `schema: aslio/<kind>/1`"


def equations(doc):
    """(tag, line, tests it names or else those its section names)"""
    tag, start, own, of_section = None, 0, [], []
    for i, line in enumerate(doc.lines + ["## "], 1):
        begins = EQUATION.match(line)
        if begins or line.startswith("## "):
            if tag:
                yield tag, start, own or of_section
            of_section = of_section if begins else []
            tag, start, own = begins and begins.group(1), i, []
        (own if tag else of_section).extend(NAMED_TEST.findall(line))


def equations_are_cited_and_tested(sources):
    doc = next((s for s in sources if s.name == "docs/equations.md"), None)
    if doc is None:
        return
    texts = [(s, "\n".join(s.lines)) for s in sources if s.suffix in CODE + (".py",)]
    for tag, line, tests in equations(doc):
        tagged = [s for s, text in texts if re.search(rf"\b{tag}\b", text)]
        if not any(s.within("framework", "plugins", "tools") for s in tagged):
            yield doc, line, f"no code cites {tag}"
        if not any(s.within("tests") and (s.name.endswith("/" + t) or (s.name + "/").startswith(t + "/"))
                   for s in tagged for t in tests):
            yield doc, line, f"{tag} is in none of its tests: {', '.join(tests) or 'it names none'}"


RULES = (
    ("the framework includes no plugin", framework_knows_no_plugin),
    ("modules include only what lies below them", modules_keep_their_arrows),
    ("a plugin includes no other family and only core, config, exec, stages", families_stay_apart),
    ("threads and OpenMP only in exec", threads_only_in_exec),
    ("no printing in framework and plugins", no_printing),
    ("no std::views", no_views),
    ("own random distributions", own_random_numbers),
    ("no iteration over unordered containers", no_unordered_iteration),
    ("no test that cannot fail or is hidden", no_test_that_cannot_fail),
    ("no file beyond 500 lines", files_of_one_purpose),
    ("nothing left unfinished", nothing_unfinished),
    ("no paths of one machine", no_machine_paths),
    ("every lint suppression names its check and reason", suppressions_have_reasons),
    ("every YAML file names its schema", yaml_names_its_schema),
    ("every equation is cited in code and in the test it names", equations_are_cited_and_tested),
)


def main(arguments):
    if arguments and (len(arguments) != 2 or arguments[0] != "--tally"):
        print(__doc__, file=sys.stderr)
        return 2
    sources = tracked()
    failed = 0
    for title, rule in RULES:
        broken = list(rule(sources))
        failed += bool(broken)
        print(f"{'FAILED' if broken else 'ok':6} {title}")
        for source, line, text in broken:
            print(f"       {source.name}:{line}: {text}")
    if arguments:
        with open(arguments[1], "a", encoding="utf-8") as file:
            file.write(f"lint rules\t{len(RULES) - failed}\t{failed}\t0\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
