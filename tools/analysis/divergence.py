"""The paper's marks of its Table I, from truth: "x" where a run failed before a tenth of the way, "-" where it failed later.

A run has failed from the first moment on at which its position is off by more than 2 m and by more than 5 % of the way
travelled, is not finite, or no update has been accepted for more than 1 s. The estimate is laid on the truth over its first
second, rigidly: an alignment of the whole would share a late failure out over the way before it.
"""
import functools

from numerics import np

from motion import ACCEPTED, Path, laid_on, table
from study_folder import FolderError

FAR_M, FAR_SHARE, SILENT_NS, SETTLE_NS, EARLY_SHARE = 2.0, 0.05, 10**9, 10**9, 0.1


@functools.lru_cache(maxsize=2)
def read_truth(path):
    return Path.read(path)


def far_from(truth, travelled, estimate):
    """Stamp [ns] of the first pose that is too far off or not finite, or None."""
    finite = np.isfinite(estimate.p).all(axis=1) & np.isfinite(estimate.q).all(axis=1)
    first = (estimate.t <= estimate.t[0] + SETTLE_NS) & finite
    if not first.any():
        return estimate.t[0]
    start = Path(estimate.t[first], estimate.p[first], estimate.q[first])
    R, t = laid_on(start, truth.at(start.t))
    error = np.linalg.norm(estimate.p @ R.T + t - truth.at(estimate.t).p, axis=1)
    way = np.interp(estimate.t, truth.t, travelled)
    failed = np.flatnonzero(~finite | ((error > FAR_M) & (error > FAR_SHARE * way)))
    return estimate.t[failed[0]] if len(failed) else None


def silent_from(updates, end):
    """Stamp of the last accepted update before more than 1 s without one, up to the end of the truth; or None."""
    accepted = updates["t_ns"][np.array([status in ACCEPTED for status in updates["status"]], dtype=bool)]
    if not len(accepted):
        return updates["t_ns"][0] if len(updates["t_ns"]) else 0
    gaps = np.flatnonzero(np.diff(np.append(accepted, max(end, accepted[-1]))) > SILENT_NS)
    return accepted[gaps[0]] if len(gaps) else None


def mark(study, run):
    """"x", "-", or None for a run that has not failed. Runs of older versions do not tell; without the truth of its data, the status of the run decides alone."""
    if "failed_at" in run.figures:  # told by the run itself
        at = run.figures["failed_at"]
        if at is None:
            return None if run.good() else "-" if run.status == "diverged" else "x"
        return "x" if at < EARLY_SHARE else "-"
    path = study.data_file(run.data, "truth.tum")
    if not path.exists():
        return None if run.good() else "x"
    try:
        truth, estimate = read_truth(path), Path.read(run.folder / "trajectory.tum")
        updates = table(run.folder / "updates.csv", ["t_ns"], ["status"])
    except FolderError:
        return None if run.good() else "x"
    inside = truth.covers(estimate.t)
    if not inside.any():
        return "x"
    estimate = Path(estimate.t[inside], estimate.p[inside], estimate.q[inside])
    travelled = np.concatenate(([0], np.cumsum(np.linalg.norm(np.diff(truth.p, axis=0), axis=1))))
    moments = [far_from(truth, travelled, estimate), silent_from(updates, truth.t[-1]), None if run.good() else estimate.t[-1]]
    moments = [moment for moment in moments if moment is not None]
    if not moments:
        return None
    return "x" if np.interp(min(moments), truth.t, travelled) < EARLY_SHARE * travelled[-1] else "-"


def set_marks(study):
    """Marks every run, of which end_to_end_m then takes notice."""
    for run in study.runs:
        run.mark = mark(study, run)
