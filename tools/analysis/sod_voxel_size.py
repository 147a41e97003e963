#!/usr/bin/env python3
"""The overlap degree over time for voxels of several sizes: table (Markdown and CSV) and pictures (SVG).

  tools/analysis/sod_voxel_size.py out/sod_voxel_size --output out/figures

Takes the output folder of `aslio experiment` for a study that varies overlap.voxel. Runs of one method and recording are
compared at the times of the updates that all sizes share. Exit 0, 2 when the folder is not what it has to be. Needs numpy.
"""
import argparse
import csv
import itertools
import pathlib
import sys

from numerics import np

import svg
from motion import table
from pairs import median
from report import markdown_table
from study_folder import FolderError, Study, in_order

AXIS = "overlap.voxel"
LEAST_COMMON = 10
COLUMNS = ("data", "sequence", "seed", "method", "voxel", "mean", "median", "lowest", "deviation")


class Group:
    """The runs of a method over one recording, one for each size of voxel; sizes as texts, ascending."""

    def __init__(self, runs, method):
        self.runs = dict(sorted(((run.axes[AXIS], run) for run in runs), key=lambda item: float(item[0])))
        first = runs[0]
        self.data, self.sequence, self.seed, self.method = first.data, first.sequence, first.seed, method
        self.t_ns, self.scores = self._common(self._read())

    def _read(self):
        found = {}
        for size, run in self.runs.items():
            columns = table(run.folder / "updates.csv", ["t_ns", "sod"])
            defined = np.isfinite(columns["sod"])
            found[size] = (columns["t_ns"][defined], columns["sod"][defined])
        return found

    def _common(self, found):
        shared = None
        for t_ns, _ in found.values():
            shared = t_ns if shared is None else np.intersect1d(shared, t_ns, assume_unique=True)
        if len(shared) < LEAST_COMMON:
            raise FolderError(f"{self.data}/{self.method}: the runs of different voxels have {len(shared)} updates at the same "
                              "times: the study needs a fixed window")
        return shared, {size: sod[np.searchsorted(t_ns, shared)] for size, (t_ns, sod) in found.items()}

    def seconds(self):
        return (self.t_ns - self.t_ns[0]) * 1e-9

    def after(self, skip):
        use = self.seconds() >= skip
        return {size: sod[use] for size, sod in self.scores.items()}

    def lines(self, skip):
        return [{"data": self.data, "sequence": self.sequence, "seed": self.seed, "method": self.method, "voxel": size,
                 "mean": float(np.mean(sod)), "median": float(np.median(sod)), "lowest": float(np.min(sod)),
                 "deviation": float(np.std(sod))} for size, sod in self.after(skip).items()]

    def correlations(self, skip):
        """{(size, other): correlation over time}; None where a score is constant."""
        scores = self.after(skip)
        return {(a, b): None if np.ptp(scores[a]) == 0 or np.ptp(scores[b]) == 0
                else float(np.corrcoef(scores[a], scores[b])[0, 1]) for a, b in itertools.combinations(scores, 2)}

    def spread(self, skip):
        """Between the means of the sizes."""
        means = [float(np.mean(sod)) for sod in self.after(skip).values()]
        return max(means) - min(means)


def groups(study):
    if any(AXIS not in run.axes for run in study.runs):
        raise FolderError(f"{study.folder / 'results.csv'}: has no column {AXIS}: the study does not vary it")
    for run in study.failures():
        print(f"left out: {run.data}/{run.method} ({run.status})", file=sys.stderr)
    by = {}
    for run in study.runs:
        if run.good():
            method = run.method.removesuffix(f"_{AXIS.split('.')[1]}_{run.axes[AXIS]}")
            by.setdefault((run.data, run.order_seed, method), []).append(run)
    return [Group(runs, method) for (_, _, method), runs in by.items() if len(runs) > 1]


def cell(value, digits=3):
    return "-" if value is None else f"{value:.{digits}f}"


def score_table(lines):
    out = []
    for key in in_order((line["sequence"], line["method"], line["voxel"]) for line in lines):
        those = [line for line in lines if (line["sequence"], line["method"], line["voxel"]) == key]
        middle = [cell(median([line[name] for line in those])) for name in ("mean", "median", "lowest", "deviation")]
        out.append([*key, len(those), *middle])
    return markdown_table(["sequence", "method", "voxel [m]", "runs", "mean O", "median O", "lowest O", "deviation"], out)


def agreement_table(found, skip):
    """Medians over recordings."""
    out = []
    for key in in_order((group.sequence, group.method) for group in found):
        those = [group for group in found if (group.sequence, group.method) == key]
        by_pair = {}
        for group in those:
            for pair, value in group.correlations(skip).items():
                if value is not None:
                    by_pair.setdefault(pair, []).append(value)
        middle = {pair: median(values) for pair, values in by_pair.items()}
        worst = min(middle, key=middle.get, default=None)
        out.append([*key, len(those), cell(middle[worst]) if worst else "-", " and ".join(worst) if worst else "-",
                    cell(median([group.spread(skip) for group in those]))])
    return markdown_table(["sequence", "method", "recordings", "lowest correlation between sizes", "of [m]",
                           "spread of the mean O over sizes"], out)


def verdict(found, skip):
    """The rules of experiments/sod_voxel_size.yaml."""
    soft = [group for group in found if group.method in ("fixed_layers", "fixed_margin")]
    lowest = [value for group in soft for value in group.correlations(skip).values()]
    spread = {method: median([group.spread(skip) for group in soft if group.method == method])
              for method in ("fixed_layers", "fixed_margin")}
    if not lowest or None in lowest or None in spread.values():
        return "Robust to the size, and the margin is what counts: **not decided** (needs runs of fixed_layers and fixed_margin)"
    told = {True: "**holds**", False: "**does not hold**"}
    return (f"Robust to the size: the lowest correlation between two sizes is {min(lowest):.3f} (needs 0.9): {told[min(lowest) >= 0.9]}\n\n"
            f"The margin is what counts: the spread over sizes is {spread['fixed_margin']:.3f} at a fixed margin, "
            f"{spread['fixed_layers']:.3f} at fixed layers: {told[spread['fixed_margin'] < spread['fixed_layers']]}")


def picture(found):
    """Of one recording, a panel for each method."""
    lowest = min(float(np.min(sod)) for group in found for sod in group.scores.values())
    limits = (0.1 * np.floor(10 * lowest), 1.02)
    panels = []
    for group in found:
        panel = svg.Panel(group.method, limits)
        for size, sod in group.scores.items():
            panel.line(f"{size} m", group.seconds(), sod)
        panels.append(panel)
    end = max(float(group.seconds()[-1]) for group in found)
    return svg.chart(f"{found[0].data}: overlap degree by the size of voxels", panels, (0.0, end), "time [s]")


def write_csv(path, lines):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", help="output folder of aslio experiment")
    parser.add_argument("--output", required=True, type=pathlib.Path, help="folder for tables and pictures")
    parser.add_argument("--skip", type=float, default=3.0, help="seconds at the begin that do not count (default 3)")
    return parser.parse_args(words)


def main(words):
    options = arguments(words)
    try:
        found = groups(Study(options.study))
        if not found:
            raise FolderError(f"{options.study}: has no recording with good runs of more than one size")
        options.output.mkdir(parents=True, exist_ok=True)
        lines = [line for group in found for line in group.lines(options.skip)]
        for sequence in in_order(group.sequence for group in found):
            first = [group for group in found if group.sequence == sequence]
            first = [group for group in first if group.data == first[0].data]
            (options.output / f"sod_voxel_size_{sequence}.svg").write_text(picture(first), encoding="utf-8")
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    write_csv(options.output / "sod_voxel_size.csv", lines)
    text = "\n\n".join((score_table(lines), agreement_table(found, options.skip), verdict(found, options.skip))) + "\n"
    (options.output / "sod_voxel_size.md").write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
