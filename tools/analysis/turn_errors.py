#!/usr/bin/env python3
"""Where the attitude of runs errs: what every sharp turn adds to it, and what as long a stretch of a straight adds.

  tools/analysis/turn_errors.py out/adaptivity [--against fixed_10] [--only 'outdoor_*'] [--each]

Takes the output folder of `aslio experiment` over simulated scenes. The error of the attitude is Log(R_est R_true^T) in W at the stamps of the
run, once its first second has been laid on the truth: the first two components are tilt, the third is heading. A turn is where the heading of
the truth, smoothed over 1 s (a gait swings), changes by more than 25 deg/s; turns less than 2 s apart are one, and a glance aside that comes
back is one of 0 deg. What a turn adds is the mean error from 0.7 to 4 s after it, less that from 4 to 0.7 s before it, as far as no other turn
is there. The same is asked of the middle of every straight of more than 8 s, for comparison. Over-turn: the part of the heading that has the
sign of the turn, of those above 30 deg; mean of recordings, which share one calibration, with its standard error.
A table by method, all turns of all runs that did not fail, each recording with its first order seed; with --against, the ratio of the root mean
square tilt to that of the other method in the same turns of the same recording. Runs without truth are left out, and counted on stderr.
Exit 2 when the folder is no study, or a run has no trajectory. Needs numpy.
"""
import argparse
import fnmatch
import math
import sys

from numerics import np

import pairs
from motion import Path, laid_on, rotation_vectors
from report import markdown_table, probability
from study_folder import FolderError, Study

STEP_S, SMOOTH_S, FAST_DEG_S, APART_S = 0.05, 1.0, 25.0, 2.0
NEAR_S, FAR_S, LEAST = 0.7, 4.0, 10
SWEPT_DEG = 30.0


class Errors:
    """Of one run: turns as (time [s], angle [deg], error added [deg] (3)), and what as long a stretch of each straight adds [deg] (3)."""

    def __init__(self, turns, straights):
        self.turns, self.straights = turns, straights


def turns_of(t, yaw):
    """[first, last] index of every sharp turn, t in seconds."""
    half = int(round(SMOOTH_S / STEP_S / 2))
    padded = np.pad(yaw, half, mode="edge")
    smooth = np.convolve(padded, np.full(2 * half + 1, 1 / (2 * half + 1)), "valid")
    fast = np.flatnonzero(np.abs(np.gradient(smooth, t)) > math.radians(FAST_DEG_S))
    found = []
    for i in fast:
        if found and t[i] - t[found[-1][1]] < APART_S:
            found[-1][1] = i
        else:
            found.append([i, i])
    return found


def change_over(t, values, begin, end, earliest=-math.inf, latest=math.inf):
    """Mean of `values` after `end` less that before `begin`; None where one of them has no data."""
    before = (t > max(begin - FAR_S, earliest)) & (t < begin - NEAR_S)
    after = (t > end + NEAR_S) & (t < min(end + FAR_S, latest))
    if min(before.sum(), after.sum()) < LEAST:
        return None
    return values[after].mean(axis=0) - values[before].mean(axis=0)


def errors_of(estimate, truth):
    inside = truth.covers(estimate.t)
    if inside.sum() < LEAST:
        return Errors([], [])
    estimate = Path(estimate.t[inside], estimate.p[inside], estimate.q[inside])
    # At its own stamps: between them a gait swings, which interpolation does not.
    true, since = truth.at(estimate.t), (estimate.t - truth.t[0]) * 1e-9
    begin = since < since[0] + 1.0
    lay, _ = laid_on(*(Path(path.t[begin], path.p[begin], path.q[begin]) for path in (estimate, true)))
    error = np.degrees(rotation_vectors(lay @ estimate.R() @ true.R().transpose(0, 2, 1)))
    t = np.arange(since[0], since[-1], STEP_S)
    if len(t) < 2 * LEAST:
        return Errors([], [])
    facing = truth.at(truth.t[0] + (t * 1e9).astype(np.int64)).R()[:, :, 0]
    yaw = np.unwrap(np.arctan2(facing[:, 1], facing[:, 0]))
    values = np.column_stack([*(np.interp(t, since, part) for part in error.T), np.degrees(yaw)])
    ends = [(t[a], t[b]) for a, b in turns_of(t, yaw)]
    turns, straights = [], []
    for i, (a, b) in enumerate(ends):
        earliest = ends[i - 1][1] + NEAR_S if i else -math.inf
        latest = ends[i + 1][0] - NEAR_S if i + 1 < len(ends) else math.inf
        added = change_over(t, values, a, b, earliest, latest)
        if added is not None:
            turns.append((a, added[3], added[:3]))
        if i and a - ends[i - 1][1] > 2 * FAR_S:
            middle = 0.5 * (a + ends[i - 1][1])
            straights.append(change_over(t, values, middle, middle)[:3])
    return Errors(turns, straights)


def tilt(added):
    return math.hypot(added[0], added[1])


def root_mean_square(values):
    return math.sqrt(np.mean(np.square(values)))


def with_error(values):
    spread = f" +- {np.std(values, ddof=1) / math.sqrt(len(values)):.1f}" if len(values) > 1 else ""
    return f"{np.mean(values):.1f}{spread}"


def line_of(method, errors):
    """Cells of a method, of {recording: Errors}."""
    turns = [turn for of_run in errors.values() for turn in of_run.turns]
    if not turns:
        return [method, len(errors), 0, "-", "-", "-", "-"]
    tilts, straights = ([1000 * tilt(added) for added in some] for some in (
        [added for _, _, added in turns], [added for of_run in errors.values() for added in of_run.straights]))
    over = []
    for of_run in errors.values():
        swept = [1000 * added[2] * math.copysign(1, angle) for _, angle, added in of_run.turns if abs(angle) > SWEPT_DEG]
        over += [np.mean(swept)] if swept else []
    both = [f"{pairs.median(some):.1f} ({root_mean_square(some):.1f})" if some else "-" for some in (tilts, straights)]
    return [method, len(errors), len(turns), both[0], both[1], f"{1000 * root_mean_square([added[2] for _, _, added in turns]):.1f}",
            with_error(over) if over else "-"]


def shared(ours, others):
    """Tilts that both have of the same turns."""
    found = [(tilt(added), tilt(other)) for at, _, added in ours.turns for there, _, other in others.turns if abs(at - there) < 0.5 * APART_S]
    return [root_mean_square(side) for side in zip(*found)] if found else None


def comparison(method, other, of_method, of_other):
    both = [shared(errors, of_other[data]) for data, errors in of_method.items() if data in of_other]
    both = [pair for pair in both if pair and min(pair) > 0]
    if not both:
        return f"{method} and {other} have no recording with a turn in common"
    ratios = [math.log(a / b) for a, b in both]
    ratio, tally = math.exp(np.mean(ratios)), pairs.Tally.of(both)
    spread = f" +- {ratio * np.std(ratios, ddof=1) / math.sqrt(len(ratios)):.2f}" if len(ratios) > 1 else ""
    return (f"{method} to {other}: a turn adds {ratio:.2f}{spread} times the tilt (r.m.s. by recording), less on {tally.won} of "
            f"{tally.count()}, p = {probability(pairs.sign_test(tally))}")


def read(study, only):
    """{method: {recording: Errors}}, and how many runs have no truth."""
    found, truths, without = {method: {} for method in study.methods}, {}, 0
    for run in study.runs:
        if not run.good() or run.data in found[run.method] or not fnmatch.fnmatch(run.data, only):
            continue
        path = study.data_file(run.data, "truth.tum")
        if not path.exists():
            without += 1
            continue
        if run.data not in truths:
            truths = {run.data: Path.read(path)}  # runs of one recording stand together
        found[run.method][run.data] = errors_of(Path.read(run.folder / "trajectory.tum"), truths[run.data])
    return found, without


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", help="output folder of aslio experiment")
    parser.add_argument("--against", metavar="METHOD", help="method that all others are compared with")
    parser.add_argument("--only", metavar="GLOB", default="*", help="recordings whose name matches")
    parser.add_argument("--each", action="store_true", help="every turn of every run, too")
    return parser.parse_args(words)


def main(words):
    options = arguments(words)
    try:
        study = Study(options.study)
        if options.against and options.against not in study.methods:
            raise FolderError(f"{options.study}: has no method {options.against}; there are {', '.join(study.methods)}")
        found, without = read(study, options.only)
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if without:
        print(f"note: {without} runs left out: their recordings have no truth.tum in {study.folder / 'data'}", file=sys.stderr)
    print(markdown_table(["method", "recordings", "turns", "tilt of a turn, median (r.m.s.) [mdeg]", "tilt of as much straight [mdeg]",
                          "heading of a turn, r.m.s. [mdeg]", "over-turn [mdeg]"],
                         [line_of(method, errors) for method, errors in found.items()]))
    if options.against:
        print("\n" + "\n".join(f"- {comparison(method, options.against, errors, found[options.against])}"
                               for method, errors in found.items() if method != options.against))
    if options.each:
        print("\n" + markdown_table(["method", "recording", "at [s]", "turn [deg]", "tilt x, y [mdeg]", "heading [mdeg]"], [
            [method, data, f"{at:.1f}", f"{angle:.0f}", f"{1000 * added[0]:.1f}, {1000 * added[1]:.1f}", f"{1000 * added[2]:.1f}"]
            for method, errors in found.items() for data, of_run in errors.items() for at, angle, added in of_run.turns]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
