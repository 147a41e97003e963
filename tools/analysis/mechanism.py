"""What happens inside a window: the motion error of a slice, the error of the prediction, residuals and iterations.

An update at t_k takes the points of (t_{k-1}, t_k]. The motion error of the slice is what T_k^-1 T(t) is off by from the
truth, for the states T(t) inside the slice (trajectory_dense.tum of `aslio run --dense`) or, without them, for its begin
alone: what points are smeared by, as displacement at 5 m. The error of the prediction is that of the pose the IMU arrives at
from T_{k-1}, relative to T_{k-1}; it takes the columns prior_* of updates.csv.
"""

from numerics import np

import pairs
from motion import ACCEPTED, Path, angles, has_columns, rotations, table
from report import number
from study_folder import FolderError

FAST_RAD_S, ARM_M = 1.0, 5.0
PRIOR = ("prior_x", "prior_y", "prior_z", "prior_qx", "prior_qy", "prior_qz", "prior_qw")
COLUMNS = ("t_ns", "iterations", "residual_rms_m", "gyro_rms_rad_s", "n_fresh_matches")


def relative(R_a, p_a, R_b, p_b):
    """T_a^-1 T_b."""
    back = R_a.transpose(0, 2, 1)
    return back @ R_b, np.einsum("nij,nj->ni", back, p_b - p_a)


def smear(found, true):
    """Displacement of a point at ARM_M between two relative motions [m], and their angle [rad]."""
    R, p = found[0] @ true[0].transpose(0, 2, 1), found[1] - true[1]
    angle = angles(R)
    return np.linalg.norm(p, axis=1) + ARM_M * angle, angle


def slice_errors(inner, ends, begin_ns, end_ns, truth):
    """Largest smear [m] of every slice (begin, end], from the states `inner` that lie in it."""
    k = np.searchsorted(end_ns, inner.t)  # slice of every state
    ok = (k < len(end_ns)) & truth.covers(inner.t)
    ok[ok] &= inner.t[ok] >= begin_ns[k[ok]]
    k, states = k[ok], Path(inner.t[ok], inner.p[ok], inner.q[ok])
    true, true_end = truth.at(states.t), truth.at(end_ns)
    end_R, true_end_R = ends.R(), true_end.R()
    found = relative(end_R[k], ends.p[k], states.R(), states.p)
    size, _ = smear(found, relative(true_end_R[k], true_end.p[k], true.R(), true.p))
    worst = np.full(len(end_ns), np.nan)
    np.fmax.at(worst, k, size)
    return worst


def prediction_errors(run, updates, poses, before, truth):
    """Smear [m] of the motion predicted from one update to the next."""
    priors = table(run.folder / "updates.csv", PRIOR)
    p = np.stack([priors[name] for name in PRIOR[:3]], axis=1)[before + 1]
    q = np.stack([priors[name] for name in PRIOR[3:]], axis=1)[before + 1]
    t = updates["t_ns"]
    start, end = truth.at(t[before]), truth.at(t[before + 1])
    found = relative(poses.R()[before], poses.p[before], rotations(q), p)
    return smear(found, relative(start.R(), start.p, end.R(), end.p))[0]


def run_figures(study, run):
    """Arrays over the updates of a run: turning fast, iterations, residual, slice error, prediction error or None."""
    updates = table(run.folder / "updates.csv", COLUMNS, ["status"])
    truth, posterior = Path.read(study.data_file(run.data, "truth.tum")), Path.read(run.folder / "trajectory.tum")
    t = updates["t_ns"]
    at = np.searchsorted(posterior.t, t)
    if at[-1] >= len(posterior.t) or not np.array_equal(posterior.t[at], t):
        raise FolderError(f"{run.folder}: trajectory.tum and updates.csv do not have the same stamps")
    poses = Path(t, posterior.p[at], posterior.q[at])
    accepted = np.array([status in ACCEPTED for status in updates["status"]])
    before = np.flatnonzero(accepted[1:] & truth.covers(t[:-1]) & truth.covers(t[1:]))
    dense = run.folder / "trajectory_dense.tum"
    ends = Path(t[before + 1], poses.p[before + 1], poses.q[before + 1])
    if dense.exists():
        errors = slice_errors(Path.read(dense), ends, t[before], t[before + 1], truth)
    else:
        begin, true_begin, true_end = Path(t[before], poses.p[before], poses.q[before]), truth.at(t[before]), truth.at(ends.t)
        errors, _ = smear(relative(ends.R(), ends.p, begin.R(), begin.p),
                          relative(true_end.R(), true_end.p, true_begin.R(), true_begin.p))
    known = has_columns(run.folder / "updates.csv", PRIOR)
    return {
        "fast": updates["gyro_rms_rad_s"][before + 1] > FAST_RAD_S,
        "iterations": updates["iterations"][before + 1],
        "residual": updates["residual_rms_m"][before + 1],
        "slice": errors,
        "prediction": prediction_errors(run, updates, poses, before, truth) if known else None,
        "shift": (t[before + 1] - t[before]) * 1e-9,
    }


def pooled(study, method, sequence, name):
    """Median over all updates in fast turns of all good runs, and the mean; None without any."""
    values = []
    for run in study.of(method, sequence):
        figures = run_figures(study, run) if run.good() else None
        if figures is not None and figures[name] is not None:
            values.append(figures[name][figures["fast"]])
    values = np.concatenate(values) if values else np.array([])
    values = values[np.isfinite(values)]
    return (float(np.median(values)), float(np.mean(values))) if len(values) else (None, None)


def falls(values):
    """Each below the one before it; None when one is missing."""
    if None in values:
        return None
    return all(b < a for a, b in zip(values, values[1:]))


def both(outcomes):
    return False if False in outcomes else None if None in outcomes or not outcomes else True


def why(report, _):
    study, medians, means = report.study, {}, {}
    names = {"residual": "residual RMS [mm]", "iterations": "iterations", "slice": "motion error of the slice at 5 m [mm]",
             "prediction": "error of the prediction at 5 m [mm]"}
    for sequence in study.sequences:
        lines = []
        for method in study.methods:
            cells = [method, number(report.median(method, sequence))]
            for name in names:
                median, mean = pooled(study, method, sequence, name)
                medians[sequence, method, name], means[sequence, method, name] = median, mean
                scale = 1 if name == "iterations" else 1000
                cells.append("-" if median is None else f"{scale * median:.3g} (mean {scale * mean:.3g})")
            lines.append(cells)
        report.text(f"{sequence}, updates in turns above {FAST_RAD_S:g} rad/s: median (mean)")
        report.table(["method", "ATE [m]", *names.values()], lines)
    if any(medians[key] is None for key in medians if key[2] == "prediction"):
        report.text("No prediction error: updates.csv of these runs has no columns prior_*.")
    rates = [method for method in ("fixed_10", "fixed_20", "fixed_50") if method in study.methods]
    history = [m for m in ("fixed_10_history", "fixed_20_history", "fixed_50_history") if m in study.methods]
    if not report.needs("fixed_10", "fixed_50", "fixed_10_history", "fixed_50_history"):
        return
    for name in names:
        # Iterations are few whole numbers: their medians tie, and the mean decides.
        source = means if name == "iterations" else medians
        outcomes = [falls([source[sequence, method, name] for method in (rates[0], rates[-1])]) for sequence in study.sequences]
        report.claim(f"{names[name]} falls from 10 to 50 Hz on {outcomes.count(True)} of {len(outcomes)} sequences (needs all)",
                     both(outcomes))
    ate = [falls([pairs.median(study.values(method, sequence, "ate_m")) for method in history]) for sequence in study.sequences]
    report.claim(f"ATE with history falls over {', '.join(history)} on {ate.count(True)} of {len(ate)} (needs all)", both(ate))
