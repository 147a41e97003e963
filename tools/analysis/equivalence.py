#!/usr/bin/env python3
"""Whether two methods differ, or are the same to within a tenth, over worlds of their own: the rule of adaptivity_worlds.

The figure is the mean over the worlds of log(arm / baseline), with its 90 % interval by Student's t. Worlds of one kind of
scene are a cluster: their deviations add up (sandwich variance, one degree of freedom less than kinds). Within [0.9, 1.1]
it makes no difference, which is what two one-sided tests of 5 % each show; else the side of 1 decides, where there is one.
A lost run counts as twice the error of the other arm; where both are lost the world tells nothing and is counted.
"""
import argparse
import collections
import math
import sys

from numerics import np

import study_folder
from pairs import log_ratio, students_t
from report import markdown_table

MARGIN = (0.9, 1.1)
CONFIDENCE = 0.90


def log_ratios(study, arm, baseline, metric, suffix):
    """{kind of scene: [log ratio of each world]}, and the number of worlds in which both are lost."""
    values = {(run.method, run.data): (run.sequence, run.value(metric)) for run in study.runs}
    kinds, both_lost = collections.defaultdict(list), 0
    for (method, data), (sequence, base) in values.items():
        if method != baseline or not sequence.endswith(suffix) or (arm, data) not in values:
            continue
        other = values[arm, data][1]
        if base is None or other is None or base <= 0 or other <= 0:
            raise study_folder.FolderError(f"{study.folder}: {data}: no figure {metric} of {arm} and {baseline}")
        ratio = log_ratio(other, base)
        if ratio is None:
            both_lost += 1
        else:
            kinds[sequence].append(ratio)
    return kinds, both_lost


def interval(kinds):
    """Mean and 90 % interval of the logarithms, clustered by kind. Needs two kinds or more."""
    everything = np.concatenate([np.asarray(v, float) for v in kinds.values()])
    mean, count, clusters = everything.mean(), len(everything), len(kinds)
    meat = sum((np.asarray(v) - mean).sum() ** 2 for v in kinds.values())
    error = math.sqrt(clusters / (clusters - 1) * meat) / count
    half = students_t(0.5 + CONFIDENCE / 2, clusters - 1) * error
    return mean, mean - half, mean + half


def verdict(low, high):
    """Of an interval of ratios, arm to baseline. The baseline is what is asked about."""
    if MARGIN[0] <= low and high <= MARGIN[1]:
        return "no difference"
    if low > 1:
        return "the baseline helps"
    if high < 1:
        return "the baseline harms"
    return "not decided"


HEADER = ["worlds", "arm", "pairs", "kinds", "both lost", "ratio", "90 % interval", "verdict"]


def rows(study, baseline, metric, suffixes):
    for suffix in suffixes:
        for arm in study.methods:
            if arm == baseline:
                continue
            kinds, both_lost = log_ratios(study, arm, baseline, metric, suffix)
            count = sum(len(v) for v in kinds.values())
            row = [suffix.lstrip("_") or "all", arm, count, len(kinds), both_lost]
            if len(kinds) < 2:
                yield [*row, "-", "-", "not decided"]
                continue
            mean, low, high = (math.exp(x) for x in interval(kinds))
            yield [*row, f"{mean:.3f}", f"{low:.3f} to {high:.3f}", verdict(low, high)]


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="output of aslio experiment")
    parser.add_argument("--baseline", default="adaptive", help="method that is asked about (default: adaptive)")
    parser.add_argument("--metric", default="ate_m")
    parser.add_argument("--worlds", default="_ideal,_realistic", help="endings of sequences, each decided apart")
    options = parser.parse_args(arguments)
    try:
        study = study_folder.Study(options.folder)
        if options.baseline not in study.methods:
            raise study_folder.FolderError(
                f"{options.folder}: has no method {options.baseline}; there are {', '.join(study.methods)}")
        print(markdown_table(HEADER, list(rows(study, options.baseline, options.metric, options.worlds.split(",")))))
    except study_folder.FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
