"""Trajectories and tables as numpy arrays: TUM files, the CSV files of runs and simulations, poses between stamps."""
import csv

from numerics import np

from study_folder import FolderError

ACCEPTED = ("ok", "degenerate", "not_converged")  # statuses of updates that moved the state


def nanoseconds(text):
    """Seconds in decimal, exact to the nanosecond."""
    whole, _, rest = text.partition(".")
    return int(whole) * 10**9 + int((rest + "000000000")[:9])


def rotations(quaternions):
    """(N, 4) x y z w to (N, 3, 3)."""
    q = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    x, y, z, w = q.T
    return np.stack([
        np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1),
        np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1),
        np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1),
    ], axis=1)


def sines(R):
    """Axis times sine of the angle of each (N, 3, 3)."""
    return 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)


def angles(R):
    """Rotation angle of each (N, 3, 3) [rad]; exact for small ones too."""
    return np.arctan2(np.linalg.norm(sines(R), axis=1), 0.5 * (np.trace(R, axis1=1, axis2=2) - 1))


def rotation_vectors(R):
    """Log of each (N, 3, 3), for angles well below 180 deg [rad]."""
    sine = sines(R)
    size = np.linalg.norm(sine, axis=1)
    return sine * np.where(size > 1e-12, angles(R) / np.maximum(size, 1e-12), 1.0)[:, None]


class Path:
    """Poses in time order: t [ns], p (N, 3) [m], q (N, 4) x y z w."""

    def __init__(self, t, p, q):
        self.t, self.p, self.q = t, p, q

    @staticmethod
    def read(path):
        t, values = [], []
        try:
            with open(path, encoding="utf-8") as lines:
                for line in lines:
                    words = line.split()
                    if words and not words[0].startswith("#"):
                        t.append(nanoseconds(words[0]))
                        values.append([float(word) for word in words[1:8]])
        except (OSError, ValueError) as error:
            raise FolderError(f"{path}: cannot be read as a TUM trajectory: {error}") from error
        if not values or any(len(line) != 7 for line in values):
            raise FolderError(f"{path}: is no TUM trajectory of lines t x y z qx qy qz qw")
        values = np.array(values)
        return Path(np.array(t, dtype=np.int64), values[:, :3], values[:, 3:])

    def R(self):
        return rotations(self.q)

    def covers(self, t):
        return (t >= self.t[0]) & (t <= self.t[-1])

    def at(self, t):
        """Poses at stamps inside the path, interpolated: positions linearly, rotations along the shortest arc."""
        t = np.asarray(t, dtype=np.int64)
        after = np.clip(np.searchsorted(self.t, t), 1, len(self.t) - 1)
        share = ((t - self.t[after - 1]) / (self.t[after] - self.t[after - 1]))[:, None]
        p = self.p[after - 1] + share * (self.p[after] - self.p[after - 1])
        a, b = self.q[after - 1], self.q[after]
        b = np.where(np.sum(a * b, axis=1, keepdims=True) < 0, -b, b)
        # Steps are a few degrees at most: the normalised chord is the arc to 1e-6 of it.
        q = (1 - share) * a + share * b
        return Path(t, p, q / np.linalg.norm(q, axis=1, keepdims=True))


def laid_on(estimate, truth):
    """R, t that lay poses of an estimate on those of the truth, by their rotations."""
    u, _, vt = np.linalg.svd(np.sum(truth.R() @ estimate.R().transpose(0, 2, 1), axis=0))
    R = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return R, np.mean(truth.p - estimate.p @ R.T, axis=0)


def table(path, numbers, texts=()):
    """Columns of a CSV file by name: arrays of floats (empty cells are NaN), int64 for names that end in _ns, lists of text."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.reader(file)
            header = next(reader, [])
            lines = [line for line in reader if line]
    except OSError as error:
        raise FolderError(f"{path}: {error.strerror}") from error
    out = {}
    for name in [*numbers, *texts]:
        if name not in header:
            raise FolderError(f"{path}: has no column {name}")
        column = header.index(name)
        cells = [line[column] for line in lines]
        if name in texts:
            out[name] = cells
        elif name.endswith("_ns"):
            out[name] = np.array([int(cell) for cell in cells], dtype=np.int64)
        else:
            out[name] = np.array([float(cell) if cell else np.nan for cell in cells])
    return out


def has_columns(path, names):
    with open(path, newline="", encoding="utf-8") as file:
        header = next(csv.reader(file), [])
    return all(name in header for name in names)
