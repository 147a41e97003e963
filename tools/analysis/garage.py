"""Errors on the stretch that binds nothing along the way: along it, across it, and in yaw.

The stretch are the first `world.bare` metres of the first edge of the route. Every passage is judged by itself: the estimate
is laid on the truth over the first second of the passage, rigidly, and what it is off by from there on is its error.
"""
import math

from numerics import np

import pairs
from motion import Path, laid_on, table
from report import number
from study_folder import FolderError

SETTLE_NS = 10**9     # over which the estimate is laid on the truth
LEAST_SHARE = 0.8     # of the stretch that a passage covers
ALONG, ACROSS_M, YAW_DEG = 0.05, 0.05, 0.5


class Stretch:
    """Of one recording: axis and passages, from the truth."""

    def __init__(self, study, data):
        self.truth = Path.read(study.data_file(data, "truth.tum"))
        bare = study.scene_value(data, "world.bare")
        if bare is None:
            raise FolderError(f"{study.data_file(data, 'scene.yaml')}: the world has no bare stretch (world.bare)")
        self.length = bare * study.scale(data)
        offset = self.truth.p - self.truth.p[0]
        beyond = np.flatnonzero(np.linalg.norm(offset[:, :2], axis=1) >= self.length)
        if not len(beyond):
            raise FolderError(f"{study.data_file(data, 'truth.tum')}: never goes {self.length:.1f} m from the start")
        self.axis = offset[beyond[0]] / np.linalg.norm(offset[beyond[0]])
        self.passages = self._passages(offset @ self.axis)

    def _passages(self, along):
        """(begin, end) [ns] of the times on the stretch that cover most of it."""
        inside = np.concatenate(([False], along <= self.length, [False]))
        begins, ends = np.flatnonzero(~inside[:-1] & inside[1:]), np.flatnonzero(inside[:-1] & ~inside[1:])
        return [(self.truth.t[b], self.truth.t[e - 1]) for b, e in zip(begins, ends)
                if np.ptp(along[b:e]) >= LEAST_SHARE * self.length]


def part(path, begin, end):
    keep = (path.t >= begin) & (path.t <= end)
    return Path(path.t[keep], path.p[keep], path.q[keep])


def passage_errors(estimate, truth, axis):
    """Largest error along the axis [m], across it [m], and in yaw [deg]."""
    settling = estimate.t <= estimate.t[0] + SETTLE_NS
    first = Path(estimate.t[settling], estimate.p[settling], estimate.q[settling])
    R, t = laid_on(first, truth.at(first.t))
    true = truth.at(estimate.t)
    error = estimate.p @ R.T + t - true.p
    along = error @ axis
    across = np.linalg.norm(error - along[:, None] * axis, axis=1)
    turned = (R @ estimate.R()) @ true.R().transpose(0, 2, 1)
    yaw = np.degrees(np.arctan2(turned[:, 1, 0] - turned[:, 0, 1], turned[:, 0, 0] + turned[:, 1, 1]))
    return np.max(np.abs(along)), np.max(across), np.max(np.abs(yaw))


def least_matches(run, passages):
    """Smallest number of matches of an update that had a map, on the stretch and anywhere."""
    updates = table(run.folder / "updates.csv", ["t_ns", "n_matches"], ["status"])
    known = np.array([status != "initialising" for status in updates["status"]], dtype=bool)
    on = np.zeros(len(known), dtype=bool)
    for begin, end in passages:
        on |= (updates["t_ns"] >= begin) & (updates["t_ns"] <= end)
    matches = updates["n_matches"]
    return [int(matches[mask].min()) if mask.any() else None for mask in (known & on, known)]


def run_errors(run, stretch):
    """Worst of the passages; infinite where the run failed or left a passage out."""
    if not run.good():
        return math.inf, math.inf, math.inf
    estimate, worst = Path.read(run.folder / "trajectory.tum"), [0.0, 0.0, 0.0]
    for begin, end in stretch.passages:
        piece = part(estimate, max(begin, stretch.truth.t[0]), min(end, stretch.truth.t[-1]))
        if len(piece.t) < 3:
            return math.inf, math.inf, math.inf
        worst = np.maximum(worst, passage_errors(piece, stretch.truth, stretch.axis))
    return tuple(float(w) for w in worst)


def degenerate_garage(report, _):
    study, lines, held = report.study, [], {}
    stretches = {run.data: Stretch(study, run.data) for run in study.runs}
    for method in study.methods:
        rows = []
        for run in study.of(method):
            stretch = stretches[run.data]
            along, across, yaw = run_errors(run, stretch)
            fewest = least_matches(run, stretch.passages) if run.good() else [None, None]
            rows.append((along / stretch.length, across, yaw, *fewest))
        held[method] = [a <= ALONG and c <= ACROSS_M and y <= YAW_DEG for a, c, y, *_ in rows]
        columns = list(zip(*rows))
        cells = [f"{number(pairs.median(c), 3)} (worst {number(max(c), 3)})" for c in (
            [100 * share for share in columns[0]], [100 * across for across in columns[1]], columns[2])]
        fewest = [min((n for n in column if n is not None), default="-") for column in columns[3:]]
        lines.append([method, *cells, *fewest, f"{sum(held[method])} of {len(rows)}", len(study.failures(method))])
    some = next(iter(stretches.values()))
    report.text(f"Bare stretch: {some.length:.1f} m, {len(some.passages)} passages. Per run the largest error of any moment of "
                "any passage; median over seeds.")
    report.table(["method", "along [% of the stretch]", "across [cm]", "yaw [deg]", "fewest matches there", "anywhere",
                  "seeds within limits", "failed"], lines)
    if report.needs("as_lio_plus"):
        report.claim(f"as_lio_plus keeps within 5 % along, 5 cm across and 0.5 deg on {sum(held['as_lio_plus'])} of {len(held['as_lio_plus'])} "
                     "seeds (needs all), with no failure", all(held["as_lio_plus"]))
