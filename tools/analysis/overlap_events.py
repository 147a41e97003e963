"""Sudden changes of view, from the true overlap and the true motion, and how well a signal detects them.

V is the share of the rays of 10 ms whose cell had been hit before (overlap.csv of `aslio simulate`). A fall is where
V < 0.8; stretches less than 0.3 s apart are one, and fewer than three samples are none. A turn is where the turn rate is
above 1 rad/s. Green: a fall in a turn. Blue: a fall in none, which the IMU cannot see. Red: a turn with V above 0.95 on
average, away and back for example, where nothing is new.
"""
import dataclasses

from numerics import np

from motion import Path, angles, nanoseconds, rotations, table
from study_folder import FolderError

LOW, HIGH, FAST_RAD_S = 0.8, 0.95, 1.0
JOIN_FALLS_S, JOIN_TURNS_S, LEAST_SAMPLES = 0.3, 0.2, 3
BEFORE_S, AFTER_S = 0.5, 0.3  # around an event, what a signal does there counts as its doing
MEDIAN_S = 2.0
GRAVITY = 9.80665
COLOURS = {"green": "#16a34a", "blue": "#2563eb", "red": "#dc2626"}


def stretches(mask, t, join):
    """(first, last) index of the runs of `mask`; runs whose times `t` are less than `join` apart are one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(mask, dtype=np.int8), [0]])))
    out = []
    for first, last in zip(edges[::2], edges[1::2] - 1):
        if out and t[first] - t[out[-1][1]] < join:
            out[-1] = (out[-1][0], last)
        else:
            out.append((first, last))
    return out


@dataclasses.dataclass
class Event:
    kind: str
    begin: float  # [s] of the recording; of a green or blue event the begin of the fall
    end: float


class Truth:
    """True overlap every 10 ms and the true motion; t [s] from the first sample of the overlap."""

    def __init__(self, folder):
        cells = table(folder / "overlap.csv", ["true_overlap"], ["t"])
        t_ns = np.array([nanoseconds(text) for text in cells["t"]], dtype=np.int64)
        if len(t_ns) < 2:
            raise FolderError(f"{folder / 'overlap.csv'}: holds no overlap")
        self.zero_ns = int(t_ns[0])
        self.t, self.V = self.seconds(t_ns), cells["true_overlap"]
        self.motion_t, self.rate, self.force = self._motion(Path.read(folder / "truth.tum"))

    def seconds(self, t_ns):
        return (np.asarray(t_ns, dtype=np.int64) - self.zero_ns) * 1e-9

    def _motion(self, path):
        """Turn rate [rad/s], and by how much the specific force is off gravity [m/s^2], between poses."""
        t, R = self.seconds(path.t), rotations(path.q)
        step = np.diff(t)
        turned = np.einsum("nji,njk->nik", R[:-1], R[1:])
        rate = angles(turned) / step
        velocity = np.diff(path.p, axis=0) / step[:, None]
        acceleration = np.diff(velocity, axis=0) / (0.5 * (step[1:] + step[:-1]))[:, None]
        force = np.abs(np.linalg.norm(acceleration + [0, 0, GRAVITY], axis=1) - GRAVITY)
        return t[1:-1], 0.5 * (rate[1:] + rate[:-1]), force

    def events(self, skip):
        """In order of time, without the first `skip` seconds, in which everything is new."""
        found = []
        fast = np.interp(self.t, self.motion_t, self.rate) > FAST_RAD_S
        turns = stretches(fast, self.t, JOIN_TURNS_S)
        step = float(np.median(np.diff(self.t)))
        for first, last in stretches(self.V < LOW, self.t, JOIN_FALLS_S):
            if np.count_nonzero(self.V[first:last + 1] < LOW) < LEAST_SAMPLES:
                continue
            kind = "green" if np.any(fast[first:last + 1]) else "blue"
            found.append(Event(kind, self.t[first] - step, self.t[last]))
        falls = list(found)
        for first, last in turns:
            begin, end = self.t[first] - step, self.t[last]
            apart = all(fall.end < begin or fall.begin > end for fall in falls)
            if apart and np.mean(self.V[first:last + 1]) > HIGH:
                found.append(Event("red", begin, end))
        return sorted((event for event in found if event.begin > skip), key=lambda event: event.begin)


def largest_between(t, values, begin, end):
    """Largest of `values` at times in each (begin, end]; NaN where there is none."""
    first, last = np.searchsorted(t, begin, side="right"), np.searchsorted(t, end, side="right")
    out = np.full(len(first), np.nan)
    for i in np.flatnonzero(last > first):
        out[i] = np.max(values[first[i]:last[i]])
    return out


def mean_between(t, values, begin, end):
    sums = np.concatenate([[0.0], np.cumsum(values)])
    first, last = np.searchsorted(t, begin, side="right"), np.searchsorted(t, end, side="right")
    return np.where(last > first, (sums[last] - sums[first]) / np.maximum(last - first, 1), np.nan)


def around(t, events):
    """Which of the times lie in an event or near it."""
    near = np.zeros(len(t), dtype=bool)
    for event in events:
        near |= (t > event.begin - BEFORE_S) & (t <= event.end + AFTER_S)
    return near


def without_slow_part(t, values):
    """Less the median of the MEDIAN_S around each."""
    first, last = np.searchsorted(t, t - 0.5 * MEDIAN_S), np.searchsorted(t, t + 0.5 * MEDIAN_S, side="right")
    return values - np.array([np.median(values[a:b]) for a, b in zip(first, last)])


def auc(values, positive):
    """Share of the pairs of a positive and a negative in which the positive is larger; ties count half."""
    order = np.argsort(values, kind="stable")
    ranks = np.empty(len(values))
    ranks[order] = np.arange(1, len(values) + 1)
    for first, last in stretches(np.concatenate([np.diff(values[order]) == 0, [False]]), np.arange(len(values)), 0):
        tied = order[first:last + 2]
        ranks[tied] = np.mean(ranks[tied])
    n = int(np.count_nonzero(positive))
    m = len(values) - n
    return float((np.sum(ranks[positive]) - 0.5 * n * (n + 1)) / (n * m)) if n and m else None


@dataclasses.dataclass
class Detection:
    """What a signal that should rise at an event does; None where there is nothing to tell it from."""
    snr_db: float = None
    auc: float = None
    delay_s: float = None  # median, from the begin of the fall to the first value beyond the threshold
    threshold: float = None
    found: dict = dataclasses.field(default_factory=dict)  # kind: (found, all)
    alarms_per_min: float = None  # of stretches beyond the threshold outside all events


def peaks(t, values, events):
    """Largest value in or near each event; events without a value are left out."""
    out = []
    for event in events:
        inside = values[(t > event.begin - BEFORE_S) & (t <= event.end + AFTER_S)]
        if len(inside):
            out.append(float(np.max(inside)))
    return out


def detect(t, values, low, events, skip):
    """`values` [rising at an event] known at times `t`, `low` where the true overlap fell since the time before. The
    threshold lies half way between the median outside events and the median peak of green and blue ones."""
    use = np.isfinite(values) & (t > skip)
    t, values, low = t[use], values[use], low[use]
    quiet = ~around(t, events)
    falls = [event for event in events if event.kind != "red"]
    tops = peaks(t, values, falls)
    out = Detection(auc=auc(values, low))
    if not tops or np.count_nonzero(quiet) < 10:
        return out
    level = float(np.median(values[quiet]))
    rest = without_slow_part(t[quiet], values[quiet])
    noise = 1.4826 * float(np.median(np.abs(rest - np.median(rest))))
    rise = float(np.median(tops)) - level
    if noise > 0 and rise > 0:
        out.snr_db = 20 * float(np.log10(rise / noise))
    if rise <= 0:
        return out
    out.threshold = level + 0.5 * rise
    delays = []
    for event in events:
        hits = t[(values >= out.threshold) & (t > event.begin - BEFORE_S) & (t <= event.end + AFTER_S)]
        found, total = out.found.get(event.kind, (0, 0))
        out.found[event.kind] = (found + (len(hits) > 0), total + 1)
        if len(hits) and event.kind != "red":
            delays.append(hits[0] - event.begin)
    out.delay_s = float(np.median(delays)) if delays else None
    alarms = len(stretches((values >= out.threshold) & quiet, t, JOIN_FALLS_S))
    out.alarms_per_min = 60 * alarms / max(t[-1] - t[0], 1e-9)
    return out
