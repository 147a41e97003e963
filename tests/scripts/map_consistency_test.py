"""Entropy and distances of maps, against closed forms."""
import struct
import unittest

import numpy as np

from hand_made_study import StudyCase, printed, write_tum, yaw

import decide
import map_consistency as consistency


def ply(vertices, triangles=None, intensity=False):
    text = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
    text += "property float intensity\n" if intensity else ""
    if triangles is not None:
        text += f"element face {len(triangles)}\nproperty list uchar uint vertex_indices\n"
    body = b"".join(struct.pack("<3f", *v) + (struct.pack("<f", 7) if intensity else b"") for v in vertices)
    body += b"".join(struct.pack("<B3I", 3, *t) for t in triangles or ())
    return (text + "end_header\n").encode() + body


class MapConsistency(StudyCase):
    def test_files_as_aslio_writes_them(self):
        (self.root / "map.ply").write_bytes(ply([(1, 2, 3), (4, 5, 6)], intensity=True))
        points, triangles = consistency.read_ply(self.root / "map.ply")
        np.testing.assert_array_equal(points, [[1, 2, 3], [4, 5, 6]])
        self.assertEqual(len(triangles), 0)
        (self.root / "world.ply").write_bytes(ply([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 1, 3)]))
        np.testing.assert_array_equal(consistency.read_ply(self.root / "world.ply")[1], [[0, 1, 2], [0, 1, 3]])

    def test_distances_to_inside_edges_and_corners(self):
        corners = np.array([[[0.0, 0, 0], [2, 0, 0], [0, 2, 0]]])
        for p, expected in (((0.5, 0.5, 0.3), 0.3), ((-0.4, 1, 0), 0.4), ((2, 2, 0), np.sqrt(2)), ((-3, -4, 0), 5), ((2.3, 0, 0.4), 0.5)):
            self.assertAlmostEqual(consistency.distances(np.array(p), corners)[0], expected, places=12, msg=str(p))
        flat = np.array([[[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]])  # a triangle without area is a line
        self.assertAlmostEqual(consistency.distances(np.array([0.5, 0.2, 0]), flat)[0], 0.2)

    def test_nearest_of_many_agrees_with_trying_all(self):
        random = np.random.default_rng(3)
        base = random.uniform(-3, 3, (40, 1, 3))
        corners = base + random.uniform(-2, 2, (40, 3, 3)) * random.choice([0.05, 1], (40, 1, 1))
        vertices, triangles = corners.reshape(-1, 3), np.arange(120).reshape(-1, 3)
        queries = random.uniform(-4, 4, (2000, 3))
        brute = np.array([consistency.distances(q, corners).min() for q in queries])
        found = consistency.surface_distances(queries, vertices, triangles, 0.25)
        np.testing.assert_allclose(found, np.where(brute <= 0.25, brute, np.inf), atol=1e-12)
        self.assertGreater(np.isfinite(found).sum(), 100)

    def test_entropy_of_a_noisy_plane(self):
        random, radius = np.random.default_rng(4), 0.3
        for sigma in (0.005, 0.02):
            xy = random.uniform(-1, 1, (60000, 2))
            points = np.column_stack([xy, sigma * random.standard_normal(60000)])
            queries = np.column_stack([random.uniform(-0.6, 0.6, (50, 2)), np.zeros(50)])
            # A disc of this radius has the variance radius^2 / 4 along each axis of its plane.
            expected = 0.5 * np.log((2 * np.pi * np.e)**3 * (radius**2 / 4)**2 * sigma**2)
            self.assertAlmostEqual(np.mean(consistency.entropies(points, queries, radius)), expected, delta=0.02)
        self.assertTrue(np.isnan(consistency.entropies(np.zeros((3, 3)), np.zeros((1, 3)), radius)).all())

    def test_a_map_in_the_frame_of_its_run(self):
        random = np.random.default_rng(5)
        turn, shift = 0.6, np.array([2.0, -1, 0.5])
        R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        t = np.arange(0, 3, 0.1)
        truth = np.column_stack([t, np.sin(t), 0.1 * t * t])
        write_tum(self.root / "truth.tum", t, truth, [yaw(0)] * len(t))
        write_tum(self.root / "run.tum", t, (truth - shift) @ R, [yaw(-turn)] * len(t))
        floor = np.column_stack([random.uniform(-2, 2, (3000, 2)), np.full(3000, 0.03)])
        floor[:30, 2] = 1.5  # 1 % of people
        (self.root / "map.ply").write_bytes(ply((floor - shift) @ R, intensity=True))
        (self.root / "world.ply").write_bytes(ply([(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)], [(0, 1, 2), (0, 2, 3)]))
        code, out, err = printed(consistency.main, self.root / "map.ply", "--world", self.root / "world.ply", "--trajectory",
                                 self.root / "run.tum", "--truth", self.root / "truth.tum")
        self.assertEqual((code, err), (0, ""))
        self.assertIn("| distance to the surface, median [mm] | 30.0 |", out)
        self.assertIn("| RMS [mm] | 30.0 |", out)
        self.assertIn("| farther than 0.25 m | 1.00% |", out)

    def test_the_rule_of_the_study(self):
        random = np.random.default_rng(6)
        thickness = {"fixed_10": 0.02, "as_lio_plus": 0.01}
        self.study("map_consistency", [(s, 1, m, 0.1) for s in ("indoor_1", "indoor_3") for m in thickness])
        for sequence in ("indoor_1", "indoor_3"):
            t = self.straight_truth(f"{sequence}_1", seconds=2.0)
            (self.root / f"data/{sequence}_1/world.ply").write_bytes(
                ply([(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)], [(0, 1, 2), (0, 2, 3)]))
            for method, sigma in thickness.items():
                folder = self.root / f"runs/{sequence}_1/{method}"
                write_tum(folder / "trajectory.tum", t, np.stack([t, np.sin(t), 0 * t], axis=1), [yaw(0)] * len(t))
                write_tum(self.root / f"data/{sequence}_1/truth.tum", t, np.stack([t, np.sin(t), 0 * t], axis=1), [yaw(0)] * len(t))
                floor = np.column_stack([random.uniform(-1, 1, (2000, 2)), sigma * random.standard_normal(2000)])
                (folder / "map.ply").write_bytes(ply(floor))
        code, out, err = printed(decide.main, self.root)
        self.assertEqual((code, err), (0, ""))
        self.assertIn("entropy of as_lio_plus below that of fixed_10 on 2 of 2 (needs 2 of 2): **holds**", out)
        self.assertIn("RMS distance to the surface of as_lio_plus below that of fixed_10 on 2 of 2 (needs 2 of 2): **holds**", out)
        line = next(line for line in out.splitlines() if line.startswith("| as_lio_plus |"))
        self.assertAlmostEqual(float(line.split("|")[3]), 10, delta=0.6)

    def test_what_is_no_map_is_told(self):
        (self.root / "map.ply").write_text("ply\nformat ascii 1.0\nend_header\n")
        code, _, err = printed(consistency.main, self.root / "map.ply")
        self.assertEqual(code, 2)
        self.assertIn("map.ply", err)


if __name__ == "__main__":
    unittest.main()
