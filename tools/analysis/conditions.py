#!/usr/bin/env python3
"""Where one arm of a study beats another: the ratio of their errors by condition, and what each factor does to it.

The name of a sequence is that of its scene and the levels of its factors, `indoor_1_known_imu50_turn250`; a method is its
arm and, where there are several bases, the level of one more factor, `adaptive_planes`. A world is a scene and a seed. The
figure of a condition is the mean over its worlds of log(arm / base), with its 95 % interval by Student's t. A factor matters
if its contrast does: per world, the mean over the other factors of its last level less its first, with the 95 % interval
over the worlds by Student's t. Levels are in the order of the study. A lost run counts as twice the error of the other arm;
where both are lost the pair is left out and counted. The rules of where_it_pays and starvation.
"""
import argparse
import collections
import math
import re
import sys

from numerics import np

import study_folder
from pairs import log_ratio, students_t
from report import markdown_table

CONFIDENCE = 0.95


def split_name(name, scenes):
    """(scene, levels) of the name of a sequence."""
    scene = next((s for s in scenes if name == s or name.startswith(s + "_")), None)
    if scene is None:
        raise study_folder.FolderError(f"sequence {name}: begins with none of the scenes {', '.join(scenes)}; name them by --scenes")
    return scene, tuple(level for level in name[len(scene) + 1:].split("_") if level)


def ratios(study, arm, base, metric, scenes):
    """{levels: {world: log ratio, None where both are lost}}; the level of the methods comes last, where they have one."""
    runs = {(run.method, run.data): run for run in study.runs}
    found = collections.defaultdict(dict)
    for (method, data), run in runs.items():
        matched = re.fullmatch(f"{re.escape(arm)}(?:_(.+))?", method)
        other = matched and runs.get((f"{base}_{matched[1]}" if matched[1] else base, data))
        if not other:
            continue
        value, against = run.value(metric), other.value(metric)
        if value is None or against is None or value <= 0 or against <= 0:
            raise study_folder.FolderError(f"{study.folder}: {data}: no figure {metric} of {method} and {other.method}")
        scene, levels = split_name(run.sequence, scenes)
        found[levels + ((matched[1],) if matched[1] else ())][scene, run.seed] = log_ratio(value, against)
    if not found:
        raise study_folder.FolderError(f"{study.folder}: no run of {arm} beside one of {base}; there are {', '.join(study.methods)}")
    return dict(found)


def interval(values):
    """Mean of two values or more, and its 95 % interval by Student's t."""
    values = np.asarray(list(values), float)
    half = students_t(0.5 + CONFIDENCE / 2, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values))
    return values.mean(), values.mean() - half, values.mean() + half


def verdict(low, high, below="pays", above="harms", neither="not decided"):
    return below if high < 0 else above if low > 0 else neither


def row(values, *words):
    values = [value for value in values if value is not None]
    if len(values) < 2:
        return [len(values), "-", "-", "not decided"]
    mean, low, high = interval(values)
    return [len(values), f"{math.exp(mean):.3f}", f"{math.exp(low):.3f} to {math.exp(high):.3f}", verdict(low, high, *words)]


def condition_rows(conditions):
    for levels, worlds in conditions.items():
        yield [*levels, *row(worlds.values())]


def contrasts(conditions, factor):
    """(first level, last level, {world: contrast}); a pair of conditions that differ in this factor alone counts if both have a ratio."""
    order = list(dict.fromkeys(levels[factor] for levels in conditions))
    found = collections.defaultdict(list)
    for levels, worlds in conditions.items():
        partner = conditions.get(levels[:factor] + (order[-1],) + levels[factor + 1:], {})
        for world, ratio in worlds.items():
            if levels[factor] == order[0] and ratio is not None and partner.get(world) is not None:
                found[world].append(partner[world] - ratio)
    return order[0], order[-1], {world: float(np.mean(values)) for world, values in found.items()}


def effect_rows(conditions, names):
    for factor, name in enumerate(names):
        first, last, worlds = contrasts(conditions, factor)
        if first != last:
            yield [name, f"{first} to {last}", *row(worlds.values(), "lowers the ratio", "raises the ratio", "not shown")]


def show(study, options, pair):
    arm, base = pair.split(":")
    conditions = ratios(study, arm, base, options.metric, options.scenes)
    count = {len(levels) for levels in conditions}
    if len(count) != 1:
        raise study_folder.FolderError(f"{study.folder}: the sequences have {' and '.join(map(str, sorted(count)))} levels: every one needs as many")
    both_lost = sum(ratio is None for worlds in conditions.values() for ratio in worlds.values())
    names = options.factors or [f"factor {i + 1}" for i in range(count.pop())]
    if len(names) != len(next(iter(conditions))):
        raise study_folder.FolderError(f"--factors names {len(names)} factors, there are {len(next(iter(conditions)))}")
    print(f"{arm} to {base}, {both_lost} pairs with both lost:\n")
    print(markdown_table([*names, "worlds", "ratio", "95 % interval", "verdict"], list(condition_rows(conditions))))
    print(markdown_table(["factor", "from to", "worlds", "times the ratio", "95 % interval", "verdict"], list(effect_rows(conditions, names))))


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="output of aslio experiment")
    parser.add_argument("--pairs", required=True, type=lambda text: text.split(","), help="ARM:BASE, separated by commas")
    parser.add_argument("--scenes", default="indoor_1,indoor_2,indoor_3", type=lambda text: text.split(","))
    parser.add_argument("--factors", type=lambda text: text.split(","), help="names of the factors, that of the methods last")
    parser.add_argument("--metric", default="ate_m")
    options = parser.parse_args(arguments)
    if any(pair.count(":") != 1 for pair in options.pairs):
        parser.error("--pairs: each is ARM:BASE, such as adaptive:steady_20")
    try:
        study = study_folder.Study(options.folder)
        for pair in options.pairs:
            show(study, options, pair)
    except study_folder.FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
