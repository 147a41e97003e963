"""Updates, matched points and information per second of data, for arms that must be alike in them.

Over the updates that had a map. Matches are those of fresh points: old ones of the window are matched again, at the weight that
the history gives them. Information is the trace of what they tell of the pose, rotation at a lever arm of 5 m (IESKF-7, the sum of
eig_1 to eig_6) [1/m^2]: with the error that the matches of a plane share.
"""
from numerics import np

import pairs
from motion import table
from report import number

ALIKE = 0.1
SPECTRUM = tuple(f"eig_{i}" for i in range(1, 7))
TITLES = {"updates": "updates per second", "matches": "matched points per second", "information": "information per second"}


def per_second(run):
    """Nothing for a run that failed, or whose folder is not there."""
    if not run.good() or not (run.folder / "updates.csv").exists():
        return None
    updates = table(run.folder / "updates.csv", ["t_ns", "n_fresh_matches", *SPECTRUM], ["status"])
    known = [k for k, status in enumerate(updates["status"]) if status != "initialising"]
    if len(known) < 2:
        return None
    seconds = (updates["t_ns"][known[-1]] - updates["t_ns"][known[0]]) * 1e-9
    # The first of them begins the time, and its own points lie before it.
    return {"updates": (len(known) - 1) / seconds, "matches": float(updates["n_fresh_matches"][known[1:]].sum()) / seconds,
            "information": sum(float(np.nansum(updates[name][known[1:]])) for name in SPECTRUM) / seconds}


class Rates:
    """Of all runs of a study, each read once."""

    def __init__(self, study):
        self.study, self.found = study, {}

    def median(self, method, sequence, name):
        values = []
        for run in self.study.of(method, sequence):
            if run.folder not in self.found:
                self.found[run.folder] = per_second(run)
            if self.found[run.folder]:
                values.append(self.found[run.folder].get(name))
        return pairs.median([value for value in values if value is not None])

    def apart(self, method, other, name):
        """Largest relative difference of the two on a sequence; None where one of them is not known."""
        largest = None
        for sequence in self.study.sequences:
            a, b = self.median(method, sequence, name), self.median(other, sequence, name)
            if not a or not b:
                return None
            largest = max(largest or 0, max(a, b) / min(a, b) - 1)
        return largest

    def tell(self, report, name):
        report.text(f"{TITLES[name].capitalize()}, median over seeds:")
        report.table(["sequence", *self.study.methods], [
            [sequence, *(number(self.median(method, sequence, name)) for method in self.study.methods)]
            for sequence in self.study.sequences])
