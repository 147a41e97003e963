"""What turns and straights add to the attitude, of a made walk with known errors."""
import math
import unittest

import numpy as np

from hand_made_study import StudyCase, printed, write_tum

import turn_errors
from motion import Path, rotation_vectors


def product(a, b):
    """Of quaternions (N, 4), x y z w."""
    ax, ay, az, aw = np.moveaxis(np.atleast_2d(a), -1, 0)
    bx, by, bz, bw = np.moveaxis(np.atleast_2d(b), -1, 0)
    return np.stack([aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                     aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz], axis=-1)


def turned(vectors):
    """Quaternions of rotation vectors (N, 3)."""
    vectors = np.atleast_2d(np.asarray(vectors, dtype=float))
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.concatenate([vectors * 0.5 * np.sinc(angle / 2 / math.pi), np.cos(angle / 2)], axis=1)


T = np.arange(0, 40.001, 0.01)


def ramp(begin, end, height):
    return height * np.clip((T - begin) / (end - begin), 0, 1)


# 90 deg to the left at 10 s, 90 deg to the right at 20 s, a glance of 40 deg at 30 s; swings and rolls by 4 deg at 2 Hz throughout.
HEADING = (ramp(10, 10.5, math.pi / 2) - ramp(20, 20.5, math.pi / 2) + ramp(30, 30.3, 0.7) - ramp(31, 31.3, 0.7)
           + 0.07 * np.sin(4 * math.pi * T))
TRUE = product(turned(np.outer(HEADING, [0, 0, 1])), turned(np.outer(0.07 * np.sin(4 * math.pi * T + 1), [1, 0, 0])))
DEG = math.radians(1e-3)  # of a thousandth of a degree


class TurnErrors(StudyCase):
    def made(self, errors, methods=("fixed_10", "as_lio_plus"), statuses=("ok", "ok"), every=1):
        """A study whose methods have these errors (N, 3) of the attitude in W, in frames of their own."""
        root = self.study("study", [("hall", 1, method, 0.1, status) for method, status in zip(methods, statuses)])
        write_tum(root / "data/hall_1/truth.tum", T, np.outer(T, [1, 0, 0]), TRUE)
        for i, (method, error) in enumerate(zip(methods, errors)):
            frame, kept = turned([0.02 * i, -0.01, 0.5 + i]), slice(5, -5, every)
            write_tum(root / f"runs/hall_1/{method}/trajectory.tum", T[kept], np.outer(T, [1, 0, 0])[kept],
                      product(frame, product(turned(error), TRUE))[kept])
        return root

    def test_rotation_vectors(self):
        wanted = np.array([[0.1, -0.2, 0.3], [1e-9, 0, -2e-9], [0, 0, 0], [2.0, 0, 0]])
        path = Path(np.arange(4), np.zeros((4, 3)), turned(wanted))
        np.testing.assert_allclose(rotation_vectors(path.R()), wanted, atol=1e-15, rtol=1e-9)

    def test_turns_and_straights_get_what_they_added(self):
        error = np.zeros((len(T), 3))
        error += ramp(10.1, 10.2, 1)[:, None] * np.array([30, 40, 20]) * DEG   # in the turn to the left: 50 of tilt
        error += ramp(20.1, 20.2, 1)[:, None] * np.array([0, -30, -10]) * DEG  # in that to the right: both over-turn
        error += ramp(15.1, 15.4, 1)[:, None] * np.array([6, 8, 0]) * DEG      # in the middle of the straight between
        root = self.made([error, 0.5 * error])
        code, out, _ = printed(turn_errors.main, root, "--against", "fixed_10", "--each")
        self.assertEqual(code, 0)
        # Turns of 50, 30 and (the glance) 0 thousandths; straights of 10 and 0.
        self.assertIn("| fixed_10 | 1 | 3 | 30.0 (33.7) | 5.0 (7.1) | 12.9 | 15.0 |", out)
        self.assertIn("| as_lio_plus | 1 | 3 | 15.0 (16.8) | 2.5 (3.5) | 6.5 | 7.5 |", out)
        self.assertIn("- as_lio_plus to fixed_10: a turn adds 0.50 times the tilt (r.m.s. by recording), less on 1 of 1", out)
        self.assertRegex(out, r"\| fixed_10 \| hall_1 \| 9\.\d \| 9\d \| 30\.\d, 40\.\d \| 20\.0 \|")
        self.assertRegex(out, r"\| fixed_10 \| hall_1 \| 19\.\d \| -\d\d \| -?0\.\d, -30\.\d \| -10\.0 \|")
        self.assertRegex(out, r"\| fixed_10 \| hall_1 \| 29\.\d \| -?\d \| ")

    def test_a_right_run_of_few_poses_adds_nothing(self):
        root = self.made([np.zeros((len(T), 3))] * 2, every=10)
        _, out, _ = printed(turn_errors.main, root)
        self.assertRegex(out, r"\| fixed_10 \| 1 \| 3 \| 0\.0 \(0\.0\) \| 0\.0 \(0\.0\) \| 0\.0 \| -?0\.0 \|")

    def test_a_swinging_gait_is_no_turn(self):
        turns = turn_errors.turns_of(np.arange(0, 40, 0.05), 0.07 * np.sin(4 * math.pi * np.arange(0, 40, 0.05)))
        self.assertEqual(turns, [])

    def test_failed_runs_have_no_attitude(self):
        root = self.made([np.zeros((len(T), 3))] * 2, statuses=("ok", "failed"))
        code, out, _ = printed(turn_errors.main, root, "--against", "fixed_10")
        self.assertEqual(code, 0)
        self.assertIn("| as_lio_plus | 0 | 0 | - | - | - | - |", out)
        self.assertIn("as_lio_plus and fixed_10 have no recording with a turn in common", out)

    def test_what_is_not_there_is_told(self):
        root = self.made([np.zeros((len(T), 3))] * 2)
        code, _, err = printed(turn_errors.main, root, "--against", "fixed_11")
        self.assertEqual((code, "has no method fixed_11; there are fixed_10, as_lio_plus" in err), (2, True))
        code, out, _ = printed(turn_errors.main, root, "--only", "outdoor_*")
        self.assertIn("| as_lio_plus | 0 | 0 | - |", out)
        (root / "runs/hall_1/as_lio_plus/trajectory.tum").unlink()
        code, _, err = printed(turn_errors.main, root)
        self.assertEqual((code, "trajectory.tum" in err), (2, True))
        (root / "data/hall_1/truth.tum").unlink()
        code, out, err = printed(turn_errors.main, root)
        self.assertEqual((code, "2 runs left out" in err), (0, True))
        self.assertEqual(printed(turn_errors.main, self.root / "nothing")[0], 2)


if __name__ == "__main__":
    unittest.main()
