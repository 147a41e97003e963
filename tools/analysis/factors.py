#!/usr/bin/env python3
"""What each factor of a factorial of methods does: the ratio of the errors of its second level to its first, by kind of world.

The name of a method is its levels, joined by `_`: `adaptive_controlled_rigid`. A factor is FIRST:SECOND: every method that has
SECOND is compared with the one that has FIRST in its place, on the same recording. A step of a ladder is a pair of whole names. The
kind of a world is what follows the scene in the name of its sequence, `indoor_1_realistic`. The figure of a world is the mean of the
logarithm of the ratio over the levels of the other factors; that of a factor is the mean over the worlds, with its 95 % interval by
Student's t. A lost run counts as twice the error of the other arm; a pair that both lose is left out and counted. The rules of tuned,
ladder and what_should_adapt.
"""
import argparse
import collections
import sys

from numerics import np

import study_folder
from conditions import row, split_name
from pairs import log_ratio
from report import markdown_table

SCENES = "indoor_1,indoor_2,indoor_3,outdoor_1,outdoor_2,outdoor_3,outdoor_4,outdoor_5,outdoor_6"


def partner(method, first, second):
    """Name of the method with `first` where `method` has `second`; None where it has not."""
    if method == second:
        return first
    levels = method.split("_")
    if second not in levels:
        return None
    return "_".join(first if level == second else level for level in levels)


def effects(study, first, second, metric, scenes, only=""):
    """{kind of world: {world: mean log ratio over the other factors}}, {kind of world: number of pairs that both lost}."""
    runs = {(run.method, run.data): run for run in study.runs if run.method.startswith(only)}
    found = collections.defaultdict(lambda: collections.defaultdict(list))
    both_lost = collections.Counter()
    pairs = 0
    for (method, data), run in runs.items():
        other = runs.get((partner(method, first, second), data))
        if other is None:
            continue
        value, against = run.value(metric), other.value(metric)
        if value is None or against is None or value <= 0 or against <= 0:
            raise study_folder.FolderError(f"{study.folder}: {data}: no figure {metric} of {method} and {other.method}")
        pairs += 1
        ratio = log_ratio(value, against)
        scene, levels = split_name(run.sequence, scenes)
        kind = "_".join(levels) or "all"
        both_lost[kind] += ratio is None
        if ratio is not None:
            found[kind][scene, run.seed].append(ratio)
    if not pairs:
        raise study_folder.FolderError(f"{study.folder}: no method with {second} beside one with {first}; there are {', '.join(sorted({m for m, _ in runs}) or study.methods)}")
    return {kind: {world: float(np.mean(values)) for world, values in worlds.items()} for kind, worlds in found.items()}, both_lost


def rows_of(study, factors, metric, scenes, only=""):
    for first, second in factors:
        kinds, both_lost = effects(study, first, second, metric, scenes, only)
        for kind in sorted(both_lost):
            yield [f"{first} to {second}", kind, *row(kinds.get(kind, {}).values(), "helps", "harms"), both_lost[kind]]


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="output of aslio experiment")
    parser.add_argument("--factors", required=True, type=lambda text: [tuple(f.split(":")) for f in text.split(",")], help="FIRST:SECOND, separated by commas")
    parser.add_argument("--scenes", default=SCENES, type=lambda text: text.split(","))
    parser.add_argument("--only", default="", metavar="PREFIX", help="methods whose name begins so: one factorial of several")
    parser.add_argument("--metric", default="ate_m")
    options = parser.parse_args(arguments)
    if any(len(factor) != 2 or not all(factor) for factor in options.factors):
        parser.error("--factors: each is FIRST:SECOND, such as fixed:controlled")
    try:
        rows = list(rows_of(study_folder.Study(options.folder), options.factors, options.metric, options.scenes, options.only))
    except study_folder.FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(markdown_table(["factor", "worlds are", "worlds", "ratio", "95 % interval", "verdict", "pairs with both lost"], rows))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
