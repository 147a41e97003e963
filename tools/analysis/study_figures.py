#!/usr/bin/env python3
"""Figures of a study for a paper, as SVG or PDF, drawn by gnuplot.

  tools/analysis/study_figures.py out/table_1 --output out/figures --format pdf

NAME_errors   every recording by sequence and method, with the median; failed runs stand in a band on top
NAME_ratios   median over that of the baseline, by method and sequence
NAME_cost     CPU against the figure, geometric means over the sequences; hollow where sequences failed, whose place is of the others

The plots of the report (`aslio report`), from the same output folder. Exit 2 when the folder is no study or has no such figure.
Needs gnuplot and numpy.
"""
import argparse
import math
import pathlib
import subprocess
import sys

import divergence
import pairs
from study_folder import FolderError, Study

NAMES = {"ate_m": "ATE [m]", "ate_deg": "rotation error [deg]", "rpe": "RPE [m]", "end_to_end_m": "end-to-end error [m]"}
COLOURS = ("#1f4e9c", "#c2410c", "#0f766e", "#7c3aed", "#b91c1c", "#0891b2", "#a16207", "#4d7c0f", "#be185d", "#4b5563",
           "#f59e0b", "#10b981", "#60a5fa", "#e879f9", "#78350f")
PIXELS_PER_INCH = 96
TERMINALS = {"svg": "svg size {},{} font 'sans,13' background rgb 'white'", "pdf": "pdfcairo size {}in,{}in font 'sans,10'"}
WORST = 2  # of |log2(ratio)|: where the colours end


def quoted(text):
    """A string of gnuplot in which nothing has a meaning."""
    return "'" + text.replace("'", "''").replace("\n", " ") + "'"


def block(name, lines):
    return f"${name} << EOD\n" + "".join(line + "\n" for line in lines) + "EOD\n"


def round_values(low, high):
    """1, 2 and 5 times powers of ten."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return ", ".join(f"{digit * 10.0**power:.6g}" for power in powers for digit in (1, 2, 5) if low <= digit * 10.0**power <= high)


class Figures:
    def __init__(self, study, metric, methods):
        self.study, self.metric = study, metric
        self.methods = methods or study.methods
        self.label = NAMES.get(metric, metric)

    def medians(self, method, metric=None):
        """By sequence; None where there is no run, infinite where the median is one that failed."""
        return [pairs.median(self.study.values(method, sequence, metric or self.metric)) for sequence in self.study.sequences]

    def finite(self):
        return [v for m in self.methods for s in self.study.sequences for v in self.study.values(m, s, self.metric)
                if 0 < v < math.inf]

    def errors(self):
        low, high = min(self.finite()) / 1.3, max(self.finite()) * 1.3
        band, count = high * (high / low) ** 0.06, len(self.methods)
        data, plots = "", []
        for m, method in enumerate(self.methods):
            colour, points, middles = f"lc rgb '{COLOURS[m % len(COLOURS)]}'", [], []
            for s, sequence in enumerate(self.study.sequences):
                x = s + 0.8 * ((m + 0.5) / count - 0.5)
                values = self.study.values(method, sequence, self.metric)
                points += [f"{x} {v if v < math.inf else band} {2 if v == math.inf else 7 + 2 * (m // len(COLOURS))}" for v in values if v > 0]
                middle = pairs.median(values)
                if middle is not None and 0 < middle < math.inf:
                    middles.append(f"{x - 0.36 / count} {middle} {0.72 / count} 0")
            data += block(f"runs{m}", points or ["NaN NaN 7"]) + block(f"medians{m}", middles or ["NaN NaN NaN NaN"])
            plots += [f"$runs{m} using 1:2:3 with points pt variable ps 0.45 {colour} notitle",
                      f"$medians{m} with vectors nohead lw 2.5 {colour} notitle",
                      f"NaN with points pt {7 + 2 * (m // len(COLOURS))} ps 0.8 {colour} title {quoted(method)}"]
        tics = ", ".join(f"{quoted(sequence)} {s}" for s, sequence in enumerate(self.study.sequences))
        return data + "\n".join([
            "set logscale y", f"set ytics ({round_values(low, high)})", f"set ylabel {quoted(self.label)} noenhanced", "set grid ytics lc rgb '#e5e7eb'", "set key outside right noenhanced",
            f"set xtics ({tics}) noenhanced rotate by -25", f"set xrange [-0.6:{len(self.study.sequences) - 0.4}]",
            f"set yrange [{low}:{band * (high / low) ** 0.05}]",
            f"set arrow from graph 0, first {high} to graph 1, first {high} nohead dt 2 lc rgb '#9ca3af'",
            f"set label 'failed' at graph 0.005, first {band} tc rgb '#6b7280'", "plot " + ", \\\n".join(plots)])

    def against(self, method, default):
        return next((base for name, base in self.study.baselines if name == method), default)

    def ratios(self):
        default = self.study.baselines[0][1] if self.study.baselines else self.methods[0]
        cells, texts = [], []
        for row, method in enumerate(self.methods):
            for column, (own, base) in enumerate(zip(self.medians(method), self.medians(self.against(method, default)))):
                if own is None or base is None:
                    continue
                failed, ratio = own == math.inf, math.nan
                if not failed and 0 < base < math.inf:
                    ratio = own / base
                colour = WORST if failed else math.log2(ratio) if ratio > 0 else 0
                cells.append(f"{column} {row} {max(-WORST, min(WORST, colour))}")
                texts.append(f"{column} {row} {'x' if failed else '-' if math.isnan(ratio) else f'{ratio:.2f}'}")
        rows = ", ".join(f"{quoted(method)} {m}" for m, method in enumerate(self.methods))
        columns = ", ".join(f"{quoted(sequence)} {s}" for s, sequence in enumerate(self.study.sequences))
        return block("cells", cells) + block("texts", texts) + "\n".join([
            f"set title {quoted(f'{self.label}: median over that of the baseline (mostly {default}); x: failed')} noenhanced",
            "set palette defined (-1 '#1b8a5f', 0 '#f7f5f0', 1 '#cf5a2b')", f"set cbrange [-{WORST}:{WORST}]", "unset colorbox", "unset key",
            f"set ytics ({rows}) noenhanced", f"set xtics ({columns}) noenhanced rotate by -25",
            f"set xrange [-0.5:{len(self.study.sequences) - 0.5}]", f"set yrange [{len(self.methods) - 0.5}:-0.5]",
            "plot $cells using 1:2:3 with image pixels, $texts using 1:2:3 with labels noenhanced"])

    def cost(self):
        data, plots, places = "", [], []
        for m, method in enumerate(self.methods):
            own, cpu = self.medians(method), self.medians(method, "cpu_s_per_s")
            good = [(v, c) for v, c in zip(own, cpu) if v and c and v < math.inf and c < math.inf]
            if not good:
                continue
            v, c = (math.exp(sum(math.log(pair[k]) for pair in good) / len(good)) for k in (0, 1))
            failed = sum(value == math.inf for value in own)
            places.append((c, v))
            data += block(f"point{m}", [f"{c} {v}"])
            plots.append(f"$point{m} with points pt {(6 if failed else 7) + 2 * (m // len(COLOURS))} ps 1.2 lw 2 lc rgb '{COLOURS[m % len(COLOURS)]}' "
                         f"title {quoted(method + (f' ({failed} failed)' if failed else ''))}")
        if not places:
            return None
        ranges = [f"[{min(axis) / 1.3}:{max(axis) * 1.3}]" for axis in zip(*places)]
        return data + "\n".join([
            "set logscale xy", f"set ytics ({round_values(min(v for _, v in places) / 1.3, max(v for _, v in places) * 1.3)})", "set xlabel 'CPU [s per s of data], one thread'", f"set ylabel {quoted(self.label)} noenhanced", "set grid lc rgb '#e5e7eb'",
            "set format '%g'", "set xtics (0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5, 1)", "set key outside right noenhanced", f"set xrange {ranges[0]}", f"set yrange {ranges[1]}",
            "plot " + ", \\\n".join(plots)])

    def size(self, kind):
        if kind == "ratios":
            return 240 + 76 * len(self.study.sequences), 130 + 30 * len(self.methods)
        return (1150, 480) if kind == "errors" else (760, 480)


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", help="output folder of aslio experiment")
    parser.add_argument("--output", required=True, type=pathlib.Path, help="folder for the figures")
    parser.add_argument("--metric", default="ate_m", help="column of results.csv, smaller is better (default: ate_m)")
    parser.add_argument("--methods", help="these alone, separated by commas, in this order")
    parser.add_argument("--format", choices=sorted(TERMINALS), default="svg")
    return parser.parse_args(words)


def chosen(study, names):
    methods = names.split(",") if names else study.methods
    for method in methods:
        if method not in study.methods:
            raise FolderError(f"--methods {method}: the study has {', '.join(study.methods)}")
    return methods


def draw(script, path, form, size):
    """Raises FolderError where gnuplot cannot."""
    unit = 1 if form == "svg" else PIXELS_PER_INCH
    terminal = TERMINALS[form].format(*(round(pixels / unit, 2) for pixels in size))
    ended = subprocess.run(["gnuplot"], input=f"set terminal {terminal}\nset output {quoted(str(path))}\n{script}\n", text=True,
                           capture_output=True)
    if ended.returncode != 0:
        raise FolderError(f"{path}: gnuplot failed: {ended.stderr.strip()}")


def main(words):
    options = arguments(words)
    try:
        study = Study(options.study)
        if options.metric == "end_to_end_m":
            divergence.set_marks(study)
        figures = Figures(study, options.metric, chosen(study, options.methods))
        if not figures.finite():
            raise FolderError(f"--metric {options.metric}: no run of {options.study} has such a figure above 0")
        options.output.mkdir(parents=True, exist_ok=True)
        for kind in ("errors", "ratios", "cost"):
            script = getattr(figures, kind)()
            if script is None:
                continue
            path = options.output / f"{study.name}_{kind}.{options.format}"
            draw(script, path, options.format, figures.size(kind))
            print(f"wrote {path}")
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except FileNotFoundError:
        print("error: gnuplot is not there: apt install gnuplot-nox", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
