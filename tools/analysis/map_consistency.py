#!/usr/bin/env python3
"""How thin and how true the map of a run is: mean map entropy, and distance to the surfaces of the simulated world.

  aslio simulate configs/scenes/indoor_1.yaml --seed 101 --output sim --save-world world.ply
  aslio run configs/pipelines/as_lio_plus.yaml --dataset sim --output run --save-map map.ply
  tools/analysis/map_consistency.py map.ply --world world.ply --trajectory run/trajectory.tum --truth sim/truth.tum

Entropy (Droeschel and Behnke's MME): mean over points of ln det(2 pi e S) / 2, S the covariance of all points within
--radius; lower is sharper. It takes no truth, and no alignment. Distances are to the nearest triangle, after the trajectory
has been laid on the truth; points farther than --reach from every surface are people, outliers and gross errors, and are
counted apart. Both are taken at --points points of the map, drawn with a fixed seed. Needs numpy.
"""
import argparse
import pathlib
import sys

from numerics import np

from motion import Path
from report import markdown_table
from study_folder import FolderError

LEAST_NEIGHBOURS = 10
DRAWN, RADIUS_M, REACH_M = 5000, 0.3, 0.25
TYPES = {"float": "<f4", "float32": "<f4", "double": "<f8", "uchar": "u1", "uint8": "u1", "uint": "<u4", "int": "<i4",
         "uint32": "<u4", "int32": "<i4"}


def read_ply(path):
    """Vertices (N, 3) and triangles (M, 3) of a binary little-endian PLY as aslio writes it; no faces: M = 0."""
    try:
        data = pathlib.Path(path).read_bytes()
    except OSError as error:
        raise FolderError(f"{path}: {error.strerror}") from error
    end = data.find(b"end_header\n")
    header = data[:max(end, 0)].decode("ascii", "replace").splitlines()
    if end < 0 or "format binary_little_endian 1.0" not in header:
        raise FolderError(f"{path}: is no binary little-endian PLY file")
    counts, fields, element = {}, [], None
    for words in map(str.split, header):
        if words[:1] == ["element"]:
            element = words[1]
            counts[element] = int(words[2])
        elif words[:1] == ["property"] and element == "vertex":
            fields.append((words[2], TYPES[words[1]]))
    record = np.dtype(fields)
    vertices = np.frombuffer(data, record, counts["vertex"], end + len("end_header\n"))
    points = np.stack([vertices[axis].astype(float) for axis in "xyz"], axis=1)
    if not counts.get("face"):
        return points, np.empty((0, 3), dtype=int)
    face = np.dtype([("n", "u1"), ("corners", "<u4", 3)])
    faces = np.frombuffer(data, face, counts["face"], end + len("end_header\n") + record.itemsize * len(vertices))
    return points, faces["corners"].astype(int)


class Cells:
    """Items by the cubic cell they are in."""

    def __init__(self, points, items, edge):
        self.edge, self.low = edge, np.floor(points.min(axis=0) / edge).astype(np.int64) - 1
        keys = self._keys(np.floor(points / edge).astype(np.int64))
        order = np.argsort(keys, kind="stable")
        self.keys, self.items = keys[order], items[order]

    def _keys(self, cells):
        c = cells - self.low
        return (c[:, 0] * 2**21 + c[:, 1]) * 2**21 + c[:, 2]

    def around(self, points):
        """For each point the items of its cell and the 26 about it."""
        steps = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
        cells = np.floor(points / self.edge).astype(np.int64)
        near = (cells[:, None, :] + steps[None, :, :]).reshape(-1, 3)
        inside = np.all((near >= self.low) & (near < self.low + 2**21), axis=1)
        keys = np.where(inside, self._keys(near), -1)
        begin = np.searchsorted(self.keys, keys).reshape(len(points), -1)
        end = np.searchsorted(self.keys, keys, side="right").reshape(len(points), -1)
        for b, e in zip(begin, end):
            yield np.concatenate([self.items[i:j] for i, j in zip(b, e)])


def entropies(points, queries, radius):
    """Of the neighbourhood of each query; NaN where it has too few points."""
    cells, out = Cells(points, np.arange(len(points)), radius), []
    for query, near in zip(queries, cells.around(queries)):
        near = points[near] - query
        near = near[np.einsum("ij,ij->i", near, near) <= radius * radius]
        value = np.nan
        if len(near) >= LEAST_NEIGHBOURS:
            sign, log_det = np.linalg.slogdet(2 * np.pi * np.e * np.cov(near.T))
            value = 0.5 * log_det if sign > 0 else np.nan
        out.append(value)
    return np.array(out)


def spread_over(corners, spacing):
    """Points no farther than `spacing` apart on every triangle (M, 3, 3), and the triangle of each."""
    longest = np.max(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)
    parts = np.maximum(1, np.ceil(longest / spacing)).astype(int)
    points, owners = [], []
    for n in np.unique(parts):
        which = np.flatnonzero(parts == n)
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        keep = i + j <= n
        weight = np.stack([n - i[keep] - j[keep], i[keep], j[keep]], axis=1) / n
        points.append(np.einsum("wk,mkd->mwd", weight, corners[which]).reshape(-1, 3))
        owners.append(np.repeat(which, len(weight)))
    return np.concatenate(points), np.concatenate(owners)


def distances(p, corners):
    """From p to each triangle (M, 3, 3)."""
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(ab, ac)
    area = np.einsum("ij,ij->i", normal, normal)
    safe = np.where(area > 0, area, 1)
    v = np.einsum("ij,ij->i", np.cross(p - a, ac), normal) / safe
    w = np.einsum("ij,ij->i", np.cross(ab, p - a), normal) / safe
    inside = (v >= 0) & (w >= 0) & (v + w <= 1) & (area > 0)
    to_plane = np.abs(np.einsum("ij,ij->i", p - a, normal)) / np.sqrt(safe)
    to_edge = np.full(len(corners), np.inf)
    for k in range(3):
        begin, along = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        length = np.einsum("ij,ij->i", along, along)
        share = np.clip(np.einsum("ij,ij->i", p - begin, along) / np.where(length > 0, length, 1), 0, 1)
        to_edge = np.minimum(to_edge, np.linalg.norm(p - begin - share[:, None] * along, axis=1))
    return np.where(inside, to_plane, to_edge)


def surface_distances(queries, vertices, triangles, reach):
    """To the nearest surface; infinite beyond `reach`."""
    corners = vertices[triangles]
    # A surface within reach of a point has a sample within reach + spacing: in the cells about it.
    samples, owners = spread_over(corners, reach)
    cells, out = Cells(samples, owners, 2 * reach), []
    for query, near in zip(queries, cells.around(queries)):
        near = np.unique(near)
        out.append(distances(query, corners[near]).min() if len(near) else np.inf)
    out = np.array(out)
    return np.where(out <= reach, out, np.inf)


def alignment(trajectory, truth):
    """R, t that lay the poses of a run on the truth: positions by least squares, as for the ATE."""
    estimate = Path.read(trajectory)
    truth = Path.read(truth)
    seen = truth.covers(estimate.t)
    if seen.sum() < 3:
        raise FolderError(f"{trajectory}: has no three poses in the time of the truth")
    p, q = estimate.p[seen], truth.at(estimate.t[seen]).p
    u, _, vt = np.linalg.svd((q - q.mean(axis=0)).T @ (p - p.mean(axis=0)))
    R = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    return R, q.mean(axis=0) - R @ p.mean(axis=0)


def measured(path, world=None, trajectory=None, truth=None, drawn=DRAWN, radius=RADIUS_M, reach=REACH_M):
    """Figures of a map by name; those of distance only with a world and a point within reach."""
    points, _ = read_ply(path)
    if not len(points):
        raise FolderError(f"{path}: has no point")
    some = np.random.default_rng(1).choice(len(points), min(drawn, len(points)), replace=False)
    values = entropies(points, points[some], radius)
    known = values[np.isfinite(values)]
    out = {"points": len(points), "few": 1 - len(known) / len(values)}
    if len(known):
        out["entropy"] = float(known.mean())
    if not world:
        return out
    vertices, triangles = read_ply(world)
    if not len(triangles):
        raise FolderError(f"{world}: has no triangle")
    R, t = alignment(trajectory, truth)
    far = surface_distances(points[some] @ R.T + t, vertices, triangles, reach)
    near = 1000 * far[np.isfinite(far)]
    out["far"] = 1 - len(near) / len(far)
    if len(near):
        out.update(median_mm=float(np.median(near)), rms_mm=float(np.sqrt(np.mean(near**2))), below_mm=float(np.quantile(near, 0.95)))
    return out


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", help="PLY file of aslio run --save-map")
    parser.add_argument("--world", metavar="PLY", help="surfaces, of aslio simulate --save-world")
    parser.add_argument("--trajectory", metavar="TUM", help="trajectory.tum of the run")
    parser.add_argument("--truth", metavar="TUM", help="truth.tum of the simulation")
    parser.add_argument("--points", type=int, default=DRAWN)
    parser.add_argument("--radius", type=float, default=RADIUS_M, metavar="M")
    parser.add_argument("--reach", type=float, default=REACH_M, metavar="M")
    options = parser.parse_args(words)
    if options.world and not (options.trajectory and options.truth):
        parser.error("--world needs --trajectory and --truth: the map begins where the run did")
    return options


def main(words):
    options = arguments(words)
    try:
        found = measured(options.map, options.world, options.trajectory, options.truth, options.points, options.radius,
                         options.reach)
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    lines = [["points", found["points"]], ["mean map entropy", f"{found['entropy']:.4f}" if "entropy" in found else "-"],
             ["points with too few neighbours", f"{found['few']:.2%}"]]
    if "rms_mm" in found:
        lines += [["distance to the surface, median [mm]", f"{found['median_mm']:.1f}"], ["RMS [mm]", f"{found['rms_mm']:.1f}"],
                  ["95 % below [mm]", f"{found['below_mm']:.1f}"]]
    if "far" in found:
        lines.append([f"farther than {options.reach:g} m", f"{found['far']:.2%}"])
    print(markdown_table(["figure", options.map], lines))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
