#!/usr/bin/env python3
"""One table of several runs, from the summary.json that `aslio run` writes into each output folder.

usage: compare_runs.py [--markdown FILE] RUN_DIR...

A run's method is the name of its folder. "-" stands for what a run did not measure: without a reference trajectory there
is no ATE, no rotation error and no RPE. Lengths are in mm where all of a column is below 0.1 m, else in m. Exit 1 when a summary is missing or a run did not end ok or degraded.
"""
import json
import pathlib
import sys

DASH = "-"


def value_at(summary, path):
    """The number at a dotted path, or None."""
    value = summary
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return None if isinstance(value, bool) or not isinstance(value, (int, float)) else value


def number(summary, path, digits=3):
    """The number at a dotted path as text, or a dash where there is none."""
    value = value_at(summary, path)
    return DASH if value is None else f"{value:.{digits}f}"


def length(title, path):
    """A column of lengths, its unit chosen as in `aslio report`: (heading, cells) of the summaries."""
    def column(summaries):
        values = [value_at(summary, path) for summary in summaries]
        scale, unit, digits = (1000, "mm", 1) if all(abs(v) < 0.1 for v in values if v is not None) else (1, "m", 3)
        return f"{title} [{unit}]", [DASH if v is None else f"{scale * v:.{digits}f}" for v in values]
    return column


def each(title, cell):
    """A column whose cells depend on their own run alone."""
    return lambda summaries: (title, [cell(summary) for summary in summaries])


def rates(summary):
    values = [number(summary, f"rate_hz.{key}", digits=1) for key in ("min", "median", "max")]
    return DASH if values == [DASH] * 3 else " / ".join(values)


def cpu_share(summary):
    cpu, data = summary.get("cpu_s"), summary.get("data_s")
    if not isinstance(cpu, (int, float)) or not isinstance(data, (int, float)) or data <= 0:
        return DASH
    return f"{cpu / data:.3f}"


COLUMNS = (
    length("ATE", "metrics.ate_m"),
    each("rotation [deg]", lambda s: number(s, "metrics.ate_deg", digits=2)),
    length("end-to-end", "metrics.end_to_end_m"),
    each("RPE [m per m]", lambda s: number(s, "metrics.rpe", digits=4)),
    each("update rate min / median / max [Hz]", rates),
    each("CPU [s per s]", cpu_share),
    each("RSS [MB]", lambda s: number(s, "peak_rss_mb", digits=0)),
)


def read(folder):
    """Name and status of one run, its summary, and what is wrong with it (nothing: None)."""
    path = folder / "summary.json"
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        return [folder.name, "no summary"], {}, f"{path}: {error}"
    status = str(summary.get("status", DASH))
    problem = None
    if status not in ("ok", "degraded"):
        problem = f"{folder.name}: {status}: {summary.get('reason') or 'no reason given'}"
    return [folder.name, status], summary, problem


def aligned(table):
    widths = [max(len(line[i]) for line in table) for i in range(len(table[0]))]
    lines = []
    for line in table:
        cells = [cell.ljust(width) if i < 2 else cell.rjust(width) for i, (cell, width) in enumerate(zip(line, widths))]
        lines.append("  ".join(cells).rstrip())
    lines.insert(1, "  ".join("-" * width for width in widths))
    return "\n".join(lines)


def markdown(table):
    lines = ["| " + " | ".join(line) + " |" for line in table]
    lines.insert(1, "|---|---|" + "---:|" * (len(table[0]) - 2))
    return "\n".join(lines) + "\n"


def main(arguments):
    output = None
    if arguments[:1] == ["--markdown"] and len(arguments) > 1:
        output, arguments = pathlib.Path(arguments[1]), arguments[2:]
    if not arguments or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    runs = [read(folder) for folder in map(pathlib.Path, arguments)]
    problems = [problem for _, _, problem in runs if problem]
    table = [["method", "status"]] + [names for names, _, _ in runs]
    for column in COLUMNS:
        title, cells = column([summary for _, summary, _ in runs])
        for line, text in zip(table, [title, *cells]):
            line.append(text)
    print(aligned(table))
    if output:
        output.write_text(markdown(table), encoding="utf-8")
    for problem in problems:
        print(f"error: {problem}", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
