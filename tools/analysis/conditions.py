#!/usr/bin/env python3
"""Where one arm of a study beats another: the ratio of their errors by condition, and what each factor does to it.

The name of a sequence is that of its scene and the levels of its factors, `indoor_1_known_imu50_turn250`; a method is its
arm and, where there are several bases, the level of one more factor, `adaptive_planes`. A world is a scene and a seed. The
figure of a condition is the mean over its worlds of log(arm / base), with its 95 % interval by Student's t. The main effect
of a level is the mean of the conditions that have it less the mean of all, with its 95 % interval by bootstrap over the
worlds. A lost run counts as twice the error of the other arm. The rules of where_it_pays and starvation.
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
DRAWS = 4000
SEED = 1


def split_name(name, scenes):
    """(scene, levels) of the name of a sequence."""
    scene = next((s for s in scenes if name == s or name.startswith(s + "_")), None)
    if scene is None:
        raise study_folder.FolderError(f"sequence {name}: begins with none of the scenes {', '.join(scenes)}; name them by --scenes")
    return scene, tuple(level for level in name[len(scene) + 1:].split("_") if level)


def ratios(study, arm, base, metric, scenes):
    """{levels: {world: log ratio}}; the level of the methods comes last, where their names have one."""
    errors = {}
    for run in study.runs:
        errors[run.method, run.data] = (run, run.value(metric))
    found, both_lost = collections.defaultdict(dict), 0
    for (method, data), (run, value) in errors.items():
        matched = re.fullmatch(f"{re.escape(arm)}(?:_(.+))?", method)
        other = matched and (f"{base}_{matched[1]}" if matched[1] else base, data)
        if not matched or other not in errors:
            continue
        against = errors[other][1]
        if value is None or against is None or value <= 0 or against <= 0:
            raise study_folder.FolderError(f"{study.folder}: {data}: no figure {metric} of {method} and {other[0]}")
        scene, levels = split_name(run.sequence, scenes)
        ratio = log_ratio(value, against)
        if ratio is None:
            both_lost += 1
            continue
        found[levels + ((matched[1],) if matched[1] else ())][scene, run.seed] = ratio
    if not found:
        raise study_folder.FolderError(f"{study.folder}: no run of {arm} beside one of {base}; there are {', '.join(study.methods)}")
    return dict(found), both_lost


def interval(values):
    """Mean of two values or more, and its 95 % interval by Student's t."""
    values = np.asarray(list(values), float)
    half = students_t(0.5 + CONFIDENCE / 2, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values))
    return values.mean(), values.mean() - half, values.mean() + half


def verdict(low, high, below="pays", above="harms", neither="not decided"):
    return below if high < 0 else above if low > 0 else neither


def condition_rows(conditions):
    for levels, worlds in conditions.items():
        if len(worlds) < 2:
            yield [*levels, len(worlds), "-", "-", "not decided"]
            continue
        mean, low, high = interval(worlds.values())
        yield [*levels, len(worlds), f"{math.exp(mean):.3f}", f"{math.exp(low):.3f} to {math.exp(high):.3f}", verdict(low, high)]


def effects(conditions, draws=DRAWS):
    """(factor, level, effect, low, high) of every level; of one world drawn again and again all conditions come along."""
    worlds = sorted({world for values in conditions.values() for world in values})
    table = np.array([[values.get(world, np.nan) for world in worlds] for values in conditions.values()])
    levels = list(conditions)
    drawn = np.random.default_rng(SEED).integers(0, len(worlds), (draws, len(worlds)))
    with np.errstate(invalid="ignore"):
        means = np.nanmean(table[:, drawn], axis=2)  # condition, draw
    middle = np.nanmean(table, axis=1)
    for factor in range(len(levels[0])):
        for level in dict.fromkeys(line[factor] for line in levels):
            at = np.array([line[factor] == level for line in levels])
            if at.all():
                continue
            spread = np.nanmean(means[at], axis=0) - np.nanmean(means, axis=0)
            low, high = np.nanquantile(spread, [0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2])
            yield factor, level, np.nanmean(middle[at]) - np.nanmean(middle), low, high


def effect_rows(conditions, names):
    for factor, level, effect, low, high in effects(conditions):
        yield [names[factor], level, f"{math.exp(effect):.3f}", f"{math.exp(low):.3f} to {math.exp(high):.3f}",
               verdict(low, high, "lowers the ratio", "raises the ratio", "not shown")]


def show(study, options, pair):
    arm, base = pair.split(":")
    conditions, both_lost = ratios(study, arm, base, options.metric, options.scenes)
    count = {len(levels) for levels in conditions}
    if len(count) != 1:
        raise study_folder.FolderError(f"{study.folder}: the sequences have {' and '.join(map(str, sorted(count)))} levels: every one needs as many")
    names = options.factors or [f"factor {i + 1}" for i in range(count.pop())]
    if len(names) != len(next(iter(conditions))):
        raise study_folder.FolderError(f"--factors names {len(names)} factors, there are {len(next(iter(conditions)))}")
    print(f"{arm} to {base}, {both_lost} pairs with both lost:\n")
    print(markdown_table([*names, "worlds", "ratio", "95 % interval", "verdict"], list(condition_rows(conditions))))
    print(markdown_table(["factor", "level", "times the mean ratio", "95 % interval", "verdict"], list(effect_rows(conditions, names))))


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
