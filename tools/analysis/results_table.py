#!/usr/bin/env python3
"""Pages of docs/studies from output folders of `aslio experiment`.

  tools/analysis/results_table.py out/table_1 out/yoked --into docs/studies

Per study: question, the command that regenerates it, what its rule says, median (smallest to largest) over seeds, and all
values by seed in a folded block. With --into, every study has a page of its own, NAME.md, and README.md lists those of the
folder; without, the pages go to stdout. A run that failed is "x" (end to end: "-" when late, as in the paper), and counts as
worse than any figure. Needs numpy.
"""
import argparse
import json
import math
import pathlib
import re
import sys

import decide
import divergence
import pairs
from report import Report, markdown_table
from study_folder import FolderError, Study

# name in results.csv: title, factor, digits after the point
METRICS = {
    "ate_m": ("ATE [m]", 1, 4),
    "ate_deg": ("rotation [deg]", 1, 3),
    "rpe": ("RPE [m per m]", 1, 4),
    "end_to_end_m": ("end to end [cm]", 100, 1),
    "updates": ("updates", 1, 0),
    "rate_hz": ("median rate [Hz]", 1, 1),
    "cpu_s_per_s": ("CPU [s per s]", 1, 4),
    "peak_rss_mb": ("RSS [MB]", 1, 0),
    "weak_share": ("weak share", 1, 3),
    "coverage": ("coverage", 1, 3),
}
USUAL = "ate_m,ate_deg,rpe,end_to_end_m,updates,cpu_s_per_s"


FOOTNOTE = (
    "End to end: `x` where a run failed before a tenth of the way, `-` where it failed later or has no figure. It has failed when no update "
    "has been accepted for more than 1 s, or its position is not finite or off by more than 2 m and 5 % of the way travelled. The position is "
    "laid on the truth over the first second.")


COSTS = ("rate_hz", "cpu_s_per_s", "peak_rss_mb")
COSTS_FOOTNOTE = "Rate, CPU and RSS of runs that were lost are those until then if the study ends them there, else of their whole way."


def value_of(run, metric):
    """What a run cost until it was lost is a cost, too."""
    return run.figures.get(metric) if metric in COSTS else run.value(metric)


def text_of(value, metric, failure="x"):
    _, factor, digits = METRICS[metric]
    return "-" if value is None else failure if math.isinf(value) else f"{factor * value:.{digits}f}"


def spread(study, method, sequence, metric):
    """Median (smallest to largest) over the recordings, and how many of them failed."""
    runs, values = study.of(method, sequence), study.values(method, sequence, metric, value_of)
    good = [value for value in values if not math.isinf(value)]
    late = metric == "end_to_end_m" and 2 * sum(run.mark == "-" for run in runs) > len(values) - len(good)
    text = text_of(pairs.median(values), metric, "-" if late else "x")
    if len(values) > 1 and good:
        text += f" ({text_of(min(good), metric)} to {text_of(max(good), metric)})"
    failed = len(values) - len(good)
    return text + (f", {failed} of {len(values)} failed" if failed else "")


def ranges(numbers):
    """1-3,7 of 1 2 3 7."""
    out = []
    for n in sorted(numbers):
        if out and n == out[-1][1] + 1:
            out[-1][1] = n
        else:
            out.append([n, n])
    return ",".join(str(a) if a == b else f"{a}-{b}" for a, b in out)


def command(study, options):
    """What makes these runs again; more than these where sequences have seeds of their own, which is told."""
    words = ["aslio experiment", f"experiments/{study.name}.yaml", "--output", f"out/{study.name}"]
    seeds_of = {sequence: ranges({int(run.seed) for run in study.runs if run.sequence == sequence and run.seed}) for sequence in study.sequences}
    seeds = {int(seed) for seed in study.seeds() if seed}
    scales = {study.scale(run.data) for run in study.runs if study.data_file(run.data, "scene.yaml").exists()}
    if len(scales) > 1:
        raise FolderError(f"{study.folder}: has runs of several scales ({', '.join(f'{scale:g}' for scale in sorted(scales))}), which no one command makes")
    scaled = ["--scale", f"{scales.pop():g}"] if scales - {1.0} else []
    judged = [f"tools/analysis/{pathlib.Path(__file__).name}", f"out/{study.name}"]
    if options.best_fixed:
        judged += ["--best-fixed", options.best_fixed]
    if options.tuning:
        judged += ["--tuning", "out/tuning"]
    call = " ".join(words + (["--seeds", ranges(seeds)] if seeds else []) + scaled)
    text = "\n".join(["```", call, " ".join(judged), "```"])
    if len(set(seeds_of.values())) > 1:
        text += "\n\nSeeds, of which the command makes all for every sequence: " + ", ".join(f"{s} {n}" for s, n in seeds_of.items() if n) + "."
    return text


def revisions(study):
    """Source revisions that the runs were made with."""
    found = set()
    for run in study.runs:
        try:
            manifest = json.loads((run.folder / "manifest.json").read_text(encoding="utf-8"))
            found.add(manifest["build"]["revision"])
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return sorted(revision[:12] + ("-dirty" if revision.endswith("-dirty") else "") for revision in found)


def verdict(study, options):
    """What was compared with, where the rule leaves that open, and the lines of the rule."""
    report = Report(study)
    decide.rule_of(study)(report, options)
    choice = [part for part in report.parts if part.startswith("Best fixed rate")]
    return "\n\n".join([*choice, "\n".join(part for part in report.parts if part.startswith("- "))])


def left_out(study):
    """Arms of the study's file in this repository that no run is of; none where the file varies keys, which makes others."""
    path = pathlib.Path(__file__).resolve().parents[2] / "experiments" / f"{study.name}.yaml"
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    if re.search(r"^vary:", text, re.MULTILINE):
        return []
    arms = re.findall(r"^  - (?:\{ *)?name: ([^\s,}]+)", text.partition("\nmethods:")[2], re.MULTILINE)
    return [arm for arm in arms if arm not in study.methods]


def summary(study, metrics):
    """One sequence: a line per method and a column per metric. Several: a table per metric."""
    if len(study.sequences) == 1:
        sequence = study.sequences[0]
        lines = [[method, *(spread(study, method, sequence, metric) for metric in metrics)]
                 for method in study.methods]
        return markdown_table([sequence, *(METRICS[metric][0] for metric in metrics)], lines)
    tables = []
    for metric in metrics:
        lines = [[method, *(spread(study, method, sequence, metric) for sequence in study.sequences)]
                 for method in study.methods]
        tables.append(markdown_table([METRICS[metric][0], *study.sequences], lines))
    return "\n\n".join(tables)


def all_values(study, metrics):
    seeds = study.seeds()
    tables = []
    for metric in metrics:
        lines = []
        for sequence in study.sequences:
            for method in study.methods:
                by_seed = {}
                for run in study.of(method, sequence):
                    by_seed.setdefault(run.seed, []).append(
                        text_of(value_of(run, metric), metric, (metric == "end_to_end_m" and run.mark) or "x"))
                lines.append([sequence, method, *(" ".join(by_seed.get(seed, ["-"])) for seed in seeds)])
        tables.append(markdown_table([METRICS[metric][0], "method", *(f"seed {seed}" if seed else "run" for seed in seeds)], lines))
    return tables and "<details><summary>All values by seed</summary>\n\n" + "\n\n".join(tables) + "\n\n</details>"


MOST_TOLD = 8


def caption(study):
    """What the figures of the tables are."""
    single = all(len(study.of(method, sequence)) <= 1 for method in study.methods for sequence in study.sequences)
    return "One run each" if single else "Median (smallest to largest) over seeds"


def told_failures(study):
    """Each with its reason; of many, how many of which method."""
    failures = study.failures()
    if len(failures) <= MOST_TOLD:
        return "; ".join(f"{run.data}/{run.method}: {run.status}" + (f" ({run.reason})" if run.reason else "") for run in failures)
    counts = [(method, len(study.failures(method)), len(study.of(method))) for method in study.methods]
    return ", ".join(f"{method} {failed} of {runs}" for method, failed, runs in counts if failed) + " (reasons: `table.md`)"


def section(study, metrics, options):
    metrics = [metric for metric in metrics if any(run.figures.get(metric) is not None for run in study.runs)]
    told_marks = "end_to_end_m" in metrics
    if told_marks:
        divergence.set_marks(study)
    failures = study.failures()
    told = told_failures(study)
    made = revisions(study)
    extent = f"{len(study.runs)} runs" + (f" of {study.planned}" if len(study.runs) < study.planned else "")
    extent += f", {len(failures)} failed" + (f": {told}" if told else "") + "."
    mixed = study.mixed()
    extent += f" **Not one configuration: runs of {', '.join(mixed)} differ in resolved.yaml.**" if mixed else ""
    extent += f" Revision {', '.join(made)}." if made else ""
    extent += " All recordings are simulated."  # command() asks each for the scale of its scene
    missing = left_out(study)
    extent += f" Of the file, which the command runs whole, without {', '.join(missing)}." if missing else ""
    parts = [f"{PAGE_BEGIN}{study.name}`", study.question, command(study, options), extent, verdict(study, options),
             f"{caption(study)}:", summary(study, metrics), FOOTNOTE if told_marks else "",
             COSTS_FOOTNOTE if failures and set(COSTS) & set(metrics) else "",
             all_values(study, [metric for metric in metrics if options.values is None or metric in options.values])]
    return "\n\n".join(part for part in parts if part) + "\n"


INDEX = "README.md"
INDEX_BEGIN = "# Studies\n"
PAGE_BEGIN = "# Study `"


def foreign(folder, names):
    """Files that would be written over and are no pages or index of this program, sorted."""
    begins = {f"{name}.md": PAGE_BEGIN for name in names} | {INDEX: INDEX_BEGIN}
    return [name for name, begin in sorted(begins.items())
            if (folder / name).is_dir() or (folder / name).exists() and not (folder / name).read_text(encoding="utf-8", errors="replace").startswith(begin)]


def listed(folder):
    """The index of a folder of pages: of every page its question, and of how many runs and which program it is."""
    lines = []
    for page in sorted(page for page in folder.glob("*.md") if page.is_file()):
        text = page.read_text(encoding="utf-8", errors="replace")
        if not text.startswith(PAGE_BEGIN):
            continue
        parts = [part.strip() for part in text.split("\n\n")]
        extent = next((part for part in parts if re.match(r"\d+ runs", part)), "")
        runs = extent.partition(",")[0].replace(" runs", "")
        revision = re.search(r"Revision ([^.]*)\.", extent)
        question = parts[1].replace("\n", " ") if len(parts) > 1 else ""
        lines.append([f"[{page.stem}]({page.name})", question, runs, revision.group(1) if revision else ""])
    return (INDEX_BEGIN + "\nA page per study, made by `tools/analysis/results_table.py`: question, command, verdict, tables. All their recordings are simulated. What they say is "
            "read in [results.md](../results.md) and [ablations.md](../ablations.md).\n\n"
            + markdown_table(["study", "question", "runs", "revision"], lines) + "\n")


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="+", help="output folders of aslio experiment")
    parser.add_argument("--metrics", default=USUAL, help=f"of {', '.join(METRICS)}; default {USUAL}")
    parser.add_argument("--values", help="those whose values by seed are listed, too, or 'none'; default: all of --metrics")
    parser.add_argument("--into", metavar="DIR", help="folder whose pages are renewed; without, they go to stdout")
    parser.add_argument("--best-fixed", metavar="METHOD", help="as for decide.py")
    parser.add_argument("--tuning", metavar="STUDY", help="as for decide.py")
    options = parser.parse_args(words)
    options.metrics = options.metrics.split(",")
    if options.values == "none":
        options.values = []
    elif options.values is not None:
        options.values = options.values.split(",")
    for option, metrics in (("--metrics", options.metrics), ("--values", options.values or [])):
        unknown = [metric for metric in metrics if metric not in METRICS]
        if unknown:
            parser.error(f"{option}: {', '.join(unknown)} is none of {', '.join(METRICS)}")
    return options


def main(words):
    options = arguments(words)
    try:
        options.tuning = Study(options.tuning) if options.tuning else None
        studies = [Study(folder) for folder in options.studies]
        sections = [(study.name, section(study, options.metrics, options)) for study in studies]
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if not options.into:
        sys.stdout.write("\n".join(text for _, text in sections))
        return 0
    folder = pathlib.Path(options.into)
    if folder.is_file():
        print(f"error: --into {folder}: is a file; name a folder, which gets a page per study", file=sys.stderr)
        return 2
    others = foreign(folder, [name for name, _ in sections])
    if others:
        print(f"error: --into {folder}: {', '.join(others)} would be written over, and was not made by this program; "
              "name another folder", file=sys.stderr)
        return 2
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in sections:
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
    (folder / INDEX).write_text(listed(folder), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
