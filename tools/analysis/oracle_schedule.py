#!/usr/bin/env python3
"""A schedule for the window `replay` from the true overlap of simulated data: what AS-LIO would do if it knew.

  tools/analysis/oracle_schedule.py out/yoked --like as_lio_plus
  tools/analysis/oracle_schedule.py out/table_1 --into out/yoked
  tools/analysis/oracle_schedule.py data/indoor_1/overlap.csv --output oracle.csv

The segment rule and its echo (WIN-1, WIN-2, AS-LIO (7)-(8)) run over the true overlap in place of the measured one; an update
at t knows that of the window that ends there or, with --ahead S, that of S seconds later, which no causal method can know.
With --like METHOD the rule does not matter, only the order: intervals as long as those of that method's run over the same data, for as
large a share of the time, the shorter the less of the view is known. So it has as many updates, but for some percent.
Of the output folder of a study it writes data/DATA/oracle.csv for every recording, where {data}/oracle.csv of a study file
finds it; with --into, below the output folder of another study over the same data, before or after its first call. Columns:
t_ns, window_begin_ns. Needs numpy.

overlap.csv compares with all that was seen up to 10 ms before, the overlap degree with a map that is older (SOD-3). So what was
new within --memory counts as new: newness of 10 ms, summed over that time. At 0.02 s as many windows fall below 0.9 as measured
by as_lio_plus at 10 Hz (n_min 2, seg_step 0.1) on indoor_1 (scale 0.3, seeds 100 and 101: 34 and 35 against 34 and 33), with a correlation of 0.97.
It was not calibrated for the finer step of the current as_lio_plus: compare that one by --like.
"""
import argparse
import math
import pathlib
import sys

from numerics import np

from motion import nanoseconds, table
from study_folder import FolderError

SECOND = 10**9


class Overlap:
    """True overlap of any interval, from its blocks of 10 ms, against what was seen before `memory` [s]."""

    def __init__(self, path, memory):
        columns = table(path, ["static_rays", "true_overlap"], ["t"])
        self.end = np.array([nanoseconds(t) for t in columns["t"]], dtype=np.int64)
        if len(self.end) < 2:
            raise FolderError(f"{path}: has no two blocks")
        block = self.end[1] - self.end[0]
        self.begin = self.end[0] - block
        met = np.isfinite(columns["true_overlap"]) & (columns["static_rays"] > 0)
        new = np.concatenate(([0], np.cumsum(np.where(met, 1 - np.nan_to_num(columns["true_overlap"]), 0))))
        blocks = max(1, round(memory * SECOND / block))
        at = np.arange(1, len(new))
        known = np.clip(1 - (new[at] - new[np.maximum(0, at - blocks)]), 0, 1)
        self.weight = np.concatenate(([0], np.cumsum(met)))
        self.known = np.concatenate(([0], np.cumsum(np.where(met, known, 0))))

    def mean(self, begin, end):
        """Over the blocks that end in (begin, end]; None where no ray met anything."""
        a, b = np.searchsorted(self.end, [begin, end], side="right")
        weight = self.weight[b] - self.weight[a]
        return (self.known[b] - self.known[a]) / weight if weight > 0 else None


class Segments:
    """n and its echo, as the window sod_adaptive holds them."""

    def __init__(self, step, least, most, echo):
        self.step, self.least, self.most, self.echo = step, least, most, echo
        self.n, self.left = least, 1

    def wanted(self, overlap):  # eq. WIN-1
        return min(max(math.ceil((1 - overlap) / self.step - 1e-9) + 1, self.least), self.most)

    def observe(self, overlap):  # eq. WIN-2
        wanted = self.n if overlap is None else self.wanted(overlap)
        self.left -= 1
        if wanted > self.n or self.left <= 0 or not self.echo:
            self.n = wanted
            self.left = 1 if wanted <= 2 else wanted


def kept(ends, warmup):
    """The first of `ends` [ns], up to `warmup` [s] after the first of them: an adaptive window does not look at the overlap there."""
    return [end for end in ends if end - ends[0] <= round(warmup * SECOND)]


def quantiles(ends, least_gap=0.2):
    """Interval lengths of a run [ns], longest first, and the share of the time that is in intervals longer than each. A gap is none."""
    lengths = np.sort(np.diff(np.array(ends, dtype=np.int64)))[::-1]
    lengths = lengths[lengths < round(least_gap * SECOND)]
    return lengths, np.concatenate(([0.0], np.cumsum(lengths[:-1]))) / max(1, lengths.sum())


def schedule_like(overlap, ends, options):
    """(t_ns, window_begin_ns) of every update: the warm-up of `ends` [ns] as it is, then lengths as between the others, by the order of
    the true overlap over 50 ms."""
    length, around = round(options.frame_length * SECOND), SECOND // 20
    if ends[0] < overlap.begin - length or ends[-1] > overlap.end[-1] + SECOND:
        raise FolderError("the run to be like is of other data: its updates are not within the time of overlap.csv")
    warm = kept(ends, options.warmup)
    lengths, longer = quantiles(ends[len(warm) - 1:])
    if len(lengths) == 0:
        raise FolderError("the run to be like has no two updates")
    ahead = round(options.ahead * SECOND)
    means = [overlap.mean(t + ahead - around, t + ahead) for t in overlap.end]
    known = np.array([1.0 if mean is None else mean for mean in means])
    later = np.flatnonzero(overlap.end > warm[-1])
    if len(later) == 0:
        raise FolderError("the run to be like ends within its warm-up")
    rank = np.ones(len(known))
    rank[later[np.argsort(-known[later], kind="stable")]] = np.arange(len(later)) / len(later)  # 0: most of the view is known
    updates = [(end, min(end - length, begin)) for begin, end in zip([warm[0] - length, *warm], warm)]
    t, last = warm[-1], int(overlap.end[-1])
    while t < last:
        now = rank[min(len(rank) - 1, int(np.searchsorted(overlap.end, t, side="right")))]
        end = t + int(lengths[int(np.searchsorted(longer, now, side="right")) - 1])
        updates.append((end, min(end - length, t)))
        t = end
    return updates


def schedule(overlap, options):
    """(t_ns, window_begin_ns) of every update."""
    length = round(options.frame_length * SECOND)
    most = min(options.n_max, 2 * length // round(options.shift_min * SECOND))
    segments = Segments(options.seg_step, options.n_min, most, not options.no_echo)
    t, last, updates = int(overlap.begin), int(overlap.end[-1]), []
    warm = t + round(options.warmup * SECOND)
    while t < last:
        end = t + 2 * length // segments.n
        updates.append((end, min(end - length, t)))
        ahead = round(options.ahead * SECOND)
        if end >= warm:
            segments.observe(overlap.mean(t + ahead, end + ahead))
        t = end
    return updates


def write(updates, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("t_ns,window_begin_ns\n" + "".join(f"{t},{begin}\n" for t, begin in updates), encoding="utf-8")


def places(options):
    """(overlap.csv, schedule) of what was named."""
    named = pathlib.Path(options.source)
    found = [named] if named.is_file() else sorted(named.glob("data/*/overlap.csv")) or sorted(named.glob("overlap.csv"))
    if not found:
        raise FolderError(f"{named}: is no overlap.csv, nor a folder of a study or of simulated data with one")
    if options.output and len(found) > 1:
        raise FolderError(f"--output {options.output}: one file for {len(found)} recordings; leave it out")
    if options.output:
        return [(found[0], pathlib.Path(options.output))]
    if options.into:
        return [(path, pathlib.Path(options.into) / "data" / path.parent.name / "oracle.csv") for path in found]
    return [(path, path.with_name("oracle.csv")) for path in found]


def ends_of(overlap_csv, method, into):
    """Ends of the updates of `method` over these data, in the study that reads the schedules."""
    overlap_csv = overlap_csv.absolute()
    study = pathlib.Path(into) if into else overlap_csv.parent.parent.parent
    run = study / "runs" / overlap_csv.parent.name / method / "updates.csv"
    if not run.is_file():
        raise FolderError(f"--like {method}: there is no {run}: run that method first")
    return [int(t) for t in table(run, [], ["t_ns"])["t_ns"]]


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", help="overlap.csv, folder of simulated data, or output folder of aslio experiment")
    parser.add_argument("--output", metavar="FILE", help="default: oracle.csv beside overlap.csv")
    parser.add_argument("--into", metavar="STUDY", help="output folder of the study that reads the schedules")
    parser.add_argument("--like", metavar="METHOD", help="lengths as in that method's run of the study, in place of the rule")
    parser.add_argument("--frame-length", type=float, default=0.1, metavar="S")
    parser.add_argument("--seg-step", type=float, default=0.005, help="that of as_lio_plus")
    parser.add_argument("--n-min", type=int, default=2, help="n where all is known: 2, as in as_lio_plus and the paper, is 10 Hz, and 4 is 20 Hz")
    parser.add_argument("--n-max", type=int, default=25)
    parser.add_argument("--shift-min", type=float, default=0.008, metavar="S")
    parser.add_argument("--warmup", type=float, default=1.0, metavar="S", help="n is least until this long after the begin; with --like, updates keep their place until this long after the first")
    parser.add_argument("--ahead", type=float, default=0.0, metavar="S", help="knows the overlap of this much later")
    parser.add_argument("--memory", type=float, default=0.02, metavar="S", help="what is younger than this counts as new")
    parser.add_argument("--no-echo", action="store_true")
    return parser.parse_args(words)


def main(words):
    options = arguments(words)
    try:
        for source, target in places(options):
            overlap = Overlap(source, options.memory)
            updates = (schedule_like(overlap, ends_of(source, options.like, options.into), options) if options.like
                       else schedule(overlap, options))
            write(updates, target)
            seconds = (updates[-1][0] - updates[0][0]) / SECOND
            print(f"{target}: {len(updates)} updates in {seconds:.1f} s, shortest interval "
                  f"{1e-6 * min(np.diff([t for t, _ in updates]), default=0):.1f} ms")
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
