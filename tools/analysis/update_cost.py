#!/usr/bin/env python3
"""CPU time of single updates, and the overlap's share of it, from timings.csv: a table (Markdown).

  tools/analysis/update_cost.py out/table_1 --methods as_lio_plus,as_lio_plus_paper_rate

Takes the output folder of `aslio experiment`. An update's time is the sum of its stages. Medians over the runs of a sequence.
Times of runs that shared the machine with others are upper bounds: run with `--jobs 1` on an idle one for figures to report.
Exit 0, 2 when the folder is not what it has to be. Needs numpy.
"""
import argparse
import sys

from numerics import np

from motion import table
from pairs import median
from report import markdown_table
from study_folder import FolderError, Study, in_order

STAGES = ("window_s", "predict_s", "deskew_s", "sample_s", "associate_s", "solve_s", "overlap_s", "insert_s")


def cost(run):
    """(median [ms], 99th percentile [ms], share of the overlap) over the updates of a run."""
    columns = table(run.folder / "timings.csv", STAGES)
    update = sum(columns[stage] for stage in STAGES)
    if len(update) == 0:
        raise FolderError(f"{run.folder / 'timings.csv'}: has no updates")
    return 1e3 * float(np.median(update)), 1e3 * float(np.percentile(update, 99)), float(np.sum(columns["overlap_s"]) / np.sum(update))


def rows(study, methods):
    found = {}
    for run in study.runs:
        if run.good() and (not methods or run.method in methods):
            found.setdefault((run.sequence, run.method), []).append(cost(run))
    out = []
    for key in in_order(found):
        middle = [median(values) for values in zip(*found[key])]
        out.append([*key, len(found[key]), f"{middle[0]:.2f}", f"{middle[1]:.2f}", f"{100 * middle[2]:.1f}"])
    return out


def main(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", help="output folder of aslio experiment")
    parser.add_argument("--methods", default="", help="comma-separated; default all")
    options = parser.parse_args(words)
    try:
        found = rows(Study(options.study), [name for name in options.methods.split(",") if name])
        if not found:
            raise FolderError(f"{options.study}: has no good run of {options.methods or 'any method'}")
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(markdown_table(["sequence", "method", "runs", "update, median [ms]", "99th percentile [ms]", "of it the overlap [%]"], found))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
