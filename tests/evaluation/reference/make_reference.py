#!/usr/bin/env python3
"""Writes the fixture trajectories and the figures the tests compare with (needs numpy; run by hand, results committed).

evo itself was not at hand: this re-implements its published rule in numpy, independently of the C++ code (nearest stamp
within 0.01 s for each pose of the shorter trajectory, unweighted, SE(3) Umeyama without scale, statistics with ddof 0).
So it checks our reading of that rule against a second implementation, not against evo.
"""
import json
import pathlib

import numpy as np

FOLDER = pathlib.Path(__file__).parent
MAX_DIFFERENCE = 0.01  # s


def rotation(phi):
    angle = np.linalg.norm(phi)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = phi / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def quaternion(r):
    """(x, y, z, w) of a rotation by less than 180 degrees."""
    w = 0.5 * np.sqrt(1 + np.trace(r))
    return np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 4 * w * w]) / (4 * w)


def matrix(q):
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def truth(t):
    p = np.array([4 * np.cos(0.5 * t), 3 * np.sin(0.5 * t), 0.4 * np.sin(1.3 * t)])
    return rotation(np.array([0.05 * np.sin(2 * t), 0.04 * np.cos(3 * t), 1.2 * np.sin(0.45 * t)])), p


def write(name, stamps, poses):
    with open(FOLDER / name, "w") as out:
        for t, (r, p) in zip(stamps, poses):
            out.write(f"{t:.6f} " + " ".join(f"{v:.9f}" for v in (*p, *quaternion(r))) + "\n")


def make_fixture():
    random = np.random.default_rng(7)
    t_reference = 100 + np.arange(0, 12, 0.025)
    write("reference.tum", t_reference, [truth(t - 100) for t in t_reference])
    t_estimate = 100.3 + np.cumsum(random.uniform(0.05, 0.15, 110))
    t_estimate = t_estimate[(t_estimate < 105.1) | (t_estimate > 105.5)]
    world, shift = rotation(np.array([0.3, -0.2, 1.9])), np.array([5.0, -7.0, 1.0])
    poses = []
    for t in t_estimate:
        r, p = truth(t - 100)
        r, p = r @ rotation(random.normal(0, 0.01, 3)), p + random.normal(0, 0.03, 3)
        poses.append((world.T @ r, world.T @ (p - shift)))
    write("estimate.tum", t_estimate, poses)


def read(name):
    data = np.loadtxt(FOLDER / name)
    return data[:, 0], data[:, 1:4], np.array([matrix(q) for q in data[:, 4:8]])


def associate(t_reference, t_estimate):
    pairs = []
    swap = len(t_estimate) > len(t_reference)
    short, long = (t_reference, t_estimate) if swap else (t_estimate, t_reference)
    for i, t in enumerate(short):
        j = int(np.argmin(np.abs(long - t)))
        if abs(long[j] - t) <= MAX_DIFFERENCE:
            pairs.append((i, j) if swap else (j, i))
    return np.array(pairs)


def umeyama(x, y):
    mx, my = x.mean(0), y.mean(0)
    u, _, v = np.linalg.svd((y - my).T @ (x - mx) / len(x))
    s = np.diag([1, 1, -1 if np.linalg.det(u) * np.linalg.det(v) < 0 else 1])
    r = u @ s @ v
    return r, my - r @ mx


def angle_deg(r):
    axial = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
    return np.degrees(np.arctan2(np.linalg.norm(axial), (np.trace(r) - 1) / 2))


def statistics(e):
    return {"n": len(e), "rmse": float(np.sqrt(np.mean(e**2))), "mean": float(np.mean(e)),
            "median": float(np.median(e)), "std": float(np.std(e)), "min": float(e.min()), "max": float(e.max())}


def evaluate(estimate, reference):
    t_r, p_r, r_r = read(reference)
    t_e, p_e, r_e = read(estimate)
    i, j = associate(t_r, t_e).T
    r, shift = umeyama(p_e[j], p_r[i])
    translation = np.linalg.norm(p_e[j] @ r.T + shift - p_r[i], axis=1)
    angle = np.array([angle_deg(r_r[a].T @ r @ r_e[b]) for a, b in zip(i, j)])
    return {"translation_m": statistics(translation), "rotation_deg": statistics(angle),
            "alignment": {"rotation": r.tolist(), "translation": shift.tolist()}}


if __name__ == "__main__":
    make_fixture()
    expected = {"forward": evaluate("estimate.tum", "reference.tum"), "swapped": evaluate("reference.tum", "estimate.tum")}
    (FOLDER / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")
