#!/usr/bin/env python3
"""What share of the error is the map's, the IMU's and the window's: the rule of floor.

Each world has a run with the IMU of a data sheet and one with a perfect IMU. A share is the median over the worlds of what
a change takes away, over the median error of the baseline with the IMU of a data sheet. Its 95 % interval is that of the
median by bootstrap over the worlds; a share is shown if it leaves out 0. The window's is the largest of all pairs, so its
interval is that of 1 - 0.05 / pairs (Bonferroni). A lost run counts as an infinite error, which the median bears; a world
that both arms lose is left out and counted.
"""
import argparse
import itertools
import math
import re
import statistics
import sys

from numerics import np

import study_folder
from pairs import LEAST_PAIRS
from report import markdown_table

DRAWS = 10000
SEED = 1
HEADER = ["share", "worlds", "both lost", "taken away [mm]", "95 % interval [mm]", "of the error", "verdict"]


def errors(study, metric, ending):
    """{method: {world: error}} of the sequences with this ending; a world is the name without it, and the seed."""
    found = {}
    for run in study.runs:
        if not run.sequence.endswith(ending):
            continue
        value = run.value(metric)
        if value is None:
            raise study_folder.FolderError(f"{study.folder}: {run.data}: no figure {metric} of {run.method}")
        world = (re.sub(f"{re.escape(ending)}$", "", run.sequence), run.seed)
        found.setdefault(run.method, {})[world] = value
    return found


def differences(before, after):
    """What is taken away in each world, and the number of worlds that both lose."""
    pairs = [(before[world], after[world]) for world in before if world in after]
    found = [a - b for a, b in pairs if not (math.isinf(a) and math.isinf(b))]
    return found, len(pairs) - len(found)


def interval(values, tests=1):
    """Median, and its 95 % interval by bootstrap, wider for the largest of several; NaN where infinities of both signs meet."""
    sample = np.asarray(values, float)
    draw = np.random.default_rng(SEED).integers(0, len(sample), (DRAWS, len(sample)))
    with np.errstate(invalid="ignore"):
        medians = np.median(sample[draw], axis=1)
    if np.isnan(medians).any():
        return statistics.median(values), math.nan, math.nan
    medians.sort()
    tail = 0.025 / tests
    return statistics.median(values), float(medians[int(tail * DRAWS)]), float(medians[int((1 - tail) * DRAWS) - 1])


def row(name, before, after, whole, tests=1):
    found, both_lost = differences(before, after)
    if not found:
        return [name, 0, both_lost, "-", "-", "-", "no pair"]
    middle, low, high = interval(found, tests)
    shown = "not decided" if math.isnan(low) or len(found) < LEAST_PAIRS else "shown" if low > 0 or high < 0 else "not shown"
    return [name, len(found), both_lost, f"{1e3 * middle:.1f}", f"{1e3 * low:.1f} to {1e3 * high:.1f}", f"{middle / whole:.0%}", shown]


def largest_difference(data, methods, whole):
    """The two windows whose median difference is largest, as a row; the larger error is the one before."""
    def median_of(pair):
        found, _ = differences(data[pair[0]], data[pair[1]])
        return statistics.median(found) if found else -math.inf

    before, after = max(itertools.permutations(methods, 2), key=median_of)
    return row(f"window: {before} to {after}", data[before], data[after], whole, math.comb(len(methods), 2))


def rows(study, options):
    sheet, perfect = (errors(study, options.metric, ending) for ending in options.worlds)
    needed = [options.baseline, *options.windows]
    for data, ending in ((sheet, options.worlds[0]), (perfect, options.worlds[1])):
        missing = [method for method in needed if method not in data]
        if missing:
            raise study_folder.FolderError(f"{study.folder}: no run of {', '.join(missing)} on sequences with {ending}")
    whole = statistics.median(sheet[options.baseline].values())
    if not 0 < whole < math.inf:
        raise study_folder.FolderError(f"{study.folder}: the median error of {options.baseline} is {whole}: it has no shares")
    true_map = options.windows[0]
    yield [f"all: {options.baseline}", len(sheet[options.baseline]), "-", f"{1e3 * whole:.1f}", "-", "100%", "-"]
    for data, ending in ((sheet, options.worlds[0]), (perfect, options.worlds[1])):
        yield [*row(f"map{ending}", data[options.baseline], data[true_map], whole)]
    yield row("IMU, on the true map", sheet[true_map], perfect[true_map], whole)
    for data, ending in ((sheet, options.worlds[0]), (perfect, options.worlds[1])):
        found = largest_difference(data, options.windows, whole)
        yield [f"{found[0]}{ending}", *found[1:]]
    for data, ending in ((sheet, options.worlds[0]), (perfect, options.worlds[1])):
        left = statistics.median(data[true_map].values())
        yield [f"left on the true map{ending}", len(data[true_map]), "-", f"{1e3 * left:.1f}", "-", f"{left / whole:.0%}", "-"]


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="output of aslio experiment")
    parser.add_argument("--baseline", default="as_lio_plus")
    parser.add_argument("--windows", default="true_map,true_map_10,true_map_125", type=lambda text: text.split(","),
                        help="methods on the true map that differ in the window; the first has the baseline's")
    parser.add_argument("--metric", default="ate_m")
    parser.add_argument("--worlds", default="_datasheet,_perfect", type=lambda text: text.split(","),
                        help="endings of the sequences: the IMU of a data sheet, and the perfect one")
    options = parser.parse_args(arguments)
    if len(options.worlds) != 2 or len(options.windows) < 2:
        parser.error("--worlds needs two endings, --windows two methods or more")
    try:
        print(markdown_table(HEADER, list(rows(study_folder.Study(options.folder), options))))
    except study_folder.FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
