#!/usr/bin/env python3
"""How well the overlap degree and the IMU detect sudden changes of view: table (Markdown and CSV) and pictures (SVG).

  tools/analysis/sod_against_imu.py out/sod_against_imu --output out/figures
  tools/analysis/sod_against_imu.py --run out/indoor_1/as_lio_plus --data out/indoor_1/data --output out/figures

Takes the output folder of `aslio experiment`, or runs of `aslio run` over data of `aslio simulate`. Per run the signals are
1 - O of every update (updates.csv), and the largest turn rate and deviation of the specific force from gravity since the
update before, both from the true motion: without noise, to the advantage of the IMU. overlap_events.py defines the
events and the measures of a signal. Exit 0, or 2 when a folder is not of the right kind. Needs numpy.
"""
import argparse
import csv
import pathlib
import sys

from numerics import np

import overlap_events
import svg
from motion import table
from overlap_events import Truth, detect, largest_between, mean_between
from pairs import median
from report import markdown_table
from study_folder import FolderError, Study, in_order

SIGNALS = {"sod": "overlap degree (1 - O)", "turn_rate": "turn rate", "acceleration": "specific force off g"}
KINDS = ("green", "blue", "red")
COLUMNS = ("data", "sequence", "seed", "method", "signal", "snr_db", "auc", "delay_s", "threshold", "alarms_per_min",
           "correlation", *(f"{kind}_{what}" for kind in KINDS for what in ("found", "events")))


class Source:
    """A run and its data."""

    def __init__(self, run, data, name=None, sequence=None, seed="", method=None):
        self.run, self.data = pathlib.Path(run), pathlib.Path(data)
        self.name, self.method = name or self.data.name, method or self.run.name
        self.sequence, self.seed = sequence or self.name, seed


def sources(options):
    if options.study:
        study = Study(options.study)
        good = [run for run in study.runs if run.good()]
        for run in study.failures():
            print(f"left out: {run.data}/{run.method} ({run.status})", file=sys.stderr)
        return [Source(run.folder, study.folder / "data" / run.data, run.data, run.sequence, run.seed, run.method)
                for run in good]
    if not options.run or len(options.run) != len(options.data or []):
        raise FolderError("name the output folder of aslio experiment, or --run and --data once for each run")
    return [Source(run, data) for run, data in zip(options.run, options.data)]


class Record:
    """The signals of a run at the times of its updates [s], with the true overlap beside them."""

    def __init__(self, source, truth):
        columns = table(source.run / "updates.csv", ["t_ns", "sod"])
        t_ns = columns["t_ns"]
        if len(t_ns) < 3 or t_ns[-1] < truth.zero_ns or truth.seconds(t_ns[:1])[0] > truth.t[-1]:
            raise FolderError(f"{source.run / 'updates.csv'}: has no update within {source.data / 'overlap.csv'}")
        self.t = truth.seconds(t_ns)
        before = np.concatenate([[self.t[0]], self.t[:-1]])
        lowest = -largest_between(truth.t, -truth.V, before, self.t)
        self.low = np.nan_to_num(lowest, nan=1.0) < overlap_events.LOW
        self.V = mean_between(truth.t, truth.V, before, self.t)
        self.signals = {"sod": 1.0 - columns["sod"],
                        "turn_rate": largest_between(truth.motion_t, truth.rate, before, self.t),
                        "acceleration": largest_between(truth.motion_t, truth.force, before, self.t)}

    def correlation(self, signal, skip):
        """With 1 - V; None where one of the two is constant."""
        values, other = self.signals[signal], 1.0 - self.V
        use = np.isfinite(values) & np.isfinite(other) & (self.t > skip)
        if np.count_nonzero(use) < 3 or np.ptp(values[use]) == 0 or np.ptp(other[use]) == 0:
            return None
        return float(np.corrcoef(values[use], other[use])[0, 1])


def judge(source, skip):
    """(lines of the table by signal, record, truth, events)."""
    truth = Truth(source.data)
    events, record = truth.events(skip), Record(source, truth)
    lines = []
    for signal, values in record.signals.items():
        found = detect(record.t, values, record.low, events, skip)
        line = {"data": source.name, "sequence": source.sequence, "seed": source.seed, "method": source.method,
                "signal": signal, "snr_db": found.snr_db, "auc": found.auc, "delay_s": found.delay_s,
                "threshold": found.threshold, "alarms_per_min": found.alarms_per_min,
                "correlation": record.correlation(signal, skip)}
        for kind in KINDS:
            line[f"{kind}_found"] = found.found.get(kind, (0, 0))[0]
            line[f"{kind}_events"] = sum(event.kind == kind for event in events)
        lines.append(line)
    return lines, record, truth, events


def picture(source, record, truth, events):
    spans = [(event.begin, event.end, overlap_events.COLOURS[event.kind]) for event in events]
    panels = [
        svg.Panel("overlap", (-0.02, 1.02)).line("O of the updates", record.t, 1.0 - record.signals["sod"])
        .line("true overlap V of 10 ms", truth.t, truth.V),
        svg.Panel("turn rate [rad/s]").line("true, 200 Hz", truth.motion_t, truth.rate),
        svg.Panel("specific force off g [m/s^2]").line("true, 200 Hz", truth.motion_t, truth.force)]
    title = f"{source.name}, {source.method}: events green (seen by both), blue (only by the overlap), red (nothing new)"
    return svg.chart(title, panels, (0.0, float(truth.t[-1])), "time [s]", spans)


def middle(lines, column):
    return median([line[column] for line in lines if line[column] is not None])


def cell(value, digits=2):
    return "-" if value is None else f"{value:.{digits}f}"


def summary(lines):
    """Medians over the runs of a sequence and method, and how many of all their events were found."""
    out = []
    for sequence, method in in_order((line["sequence"], line["method"]) for line in lines):
        for signal in SIGNALS:
            those = [line for line in lines if (line["sequence"], line["method"], line["signal"]) == (sequence, method, signal)]
            counts = [f"{sum(line[kind + '_found'] for line in those)} / {sum(line[kind + '_events'] for line in those)}"
                      for kind in KINDS]
            delay = middle(those, "delay_s")
            out.append([sequence, method, SIGNALS[signal], len(those), cell(middle(those, "snr_db"), 1),
                        cell(middle(those, "auc"), 3), cell(None if delay is None else 1e3 * delay, 0), *counts,
                        cell(middle(those, "alarms_per_min")), cell(middle(those, "correlation"))])
    return markdown_table(["sequence", "method", "signal", "runs", "SNR [dB]", "AUC (V < 0.8)", "delay [ms]", "green", "blue",
                           "red (alarms)", "other alarms per min", "correlation with 1 - V"], out)


def verdict(lines):
    """The rule of experiments/sod_against_imu.yaml."""
    higher, total = 0, 0
    for group in in_order((line["sequence"], line["method"]) for line in lines):
        auc = {signal: middle([line for line in lines if (line["sequence"], line["method"], line["signal"]) == (*group, signal)],
                              "auc") for signal in SIGNALS}
        if None not in auc.values():
            total += 1
            higher += all(auc["sod"] > value for signal, value in auc.items() if signal != "sod")
    own = [line for line in lines if line["signal"] == "sod"]
    found, events = (sum(line[column] for line in own) for column in ("blue_found", "blue_events"))
    outcome = "not decided" if total == 0 or events == 0 else "holds" if higher == total and found > 0 else "does not hold"
    return (f"The overlap degree has the highest AUC for V < 0.8 in {higher} of {total} sequences and windows (needs all), and finds "
            f"{found} of {events} blue events (needs one): **{outcome}**")


def write_csv(path, lines):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", nargs="?", help="output folder of aslio experiment")
    parser.add_argument("--run", action="append", help="output folder of aslio run; goes with --data, may be repeated")
    parser.add_argument("--data", action="append", help="folder with the truth.tum and overlap.csv of that run")
    parser.add_argument("--output", required=True, type=pathlib.Path, help="folder for table and pictures")
    parser.add_argument("--skip", type=float, default=3.0, help="seconds at the begin that do not count (default 3)")
    return parser.parse_args(words)


def main(words):
    options = arguments(words)
    lines, drawn = [], set()
    try:
        found = sources(options)
        options.output.mkdir(parents=True, exist_ok=True)
        for source in found:
            judged, record, truth, events = judge(source, options.skip)
            lines += judged
            if (source.sequence, source.method) not in drawn:  # the first seed of each
                drawn.add((source.sequence, source.method))
                name = f"sod_against_imu_{source.sequence}_{source.method}.svg".replace("/", "_")
                (options.output / name).write_text(picture(source, record, truth, events), encoding="utf-8")
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    write_csv(options.output / "sod_against_imu.csv", lines)
    text = summary(lines) + "\n\n" + verdict(lines) + "\n"
    (options.output / "sod_against_imu.md").write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
