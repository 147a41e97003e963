#!/usr/bin/env python3
"""How the update rate answers sharp turns: peaks of the reference's turn rate against the update rate and the overlap of runs.

For every peak of the turn rate (0.1 s mean) above 1.2 rad/s: the largest update rate within 0.5 s of it, and the least overlap. And
the median update rate where the turn rate has stayed below 0.3 rad/s for a second. Standard library only.

  tools/benchmarks/turn_response.py --reference avia_corridor.gt.tum RUN_DIR...        a line per run
  tools/benchmarks/turn_response.py --reference avia_corridor.gt.tum --plot FIGURE.svg RUN_DIR      and a figure (gnuplot)
"""
import argparse
import bisect
import csv
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile


def turn_rate(path):
    """(t, |omega|) of a TUM file, mean over 0.1 s."""
    rows = [[float(v) for v in line.split()] for line in open(path) if line.strip() and not line.startswith("#")]
    times, rates = [], []
    for a, b in zip(rows, rows[1:]):
        dot = min(1.0, abs(sum(x * y for x, y in zip(a[4:], b[4:]))))
        times.append(0.5 * (a[0] + b[0]))
        rates.append(2.0 * math.acos(dot) / (b[0] - a[0]))
    sums = [0.0]
    for rate in rates:
        sums.append(sums[-1] + rate)
    smooth = []
    for i, t in enumerate(times):
        low, high = bisect.bisect_left(times, t - 0.05), bisect.bisect_right(times, t + 0.05)
        smooth.append((sums[high] - sums[low]) / (high - low))
    return times, smooth


def peaks(times, rates, threshold=1.2, apart=1.0):
    found = []
    for i in sorted(range(len(times)), key=lambda i: -rates[i]):
        if rates[i] < threshold:
            break
        if all(abs(times[i] - times[j]) > apart for j in found):
            found.append(i)
    return sorted(found)


def updates(run):
    with open(pathlib.Path(run) / "updates.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    out = []
    for before, row in zip(rows, rows[1:-1]):  # the end of the recording cuts the last window short
        begin, end = int(before["t_ns"]), int(row["t_ns"])
        out.append((1e-9 * end, 1e9 / (end - begin), float(row["sod"]) if row["sod"] else None, float(row["gyro_rms_rad_s"])))
    return out


def respond(run, times, rates):
    steps = updates(run)
    turns = []
    for i in peaks(times, rates):
        near = [s for s in steps if abs(s[0] - times[i]) <= 0.5]
        if near:
            known = [s[2] for s in near if s[2] is not None]
            turns.append((times[i], rates[i], max(s[1] for s in near), min(known) if known else None))
    calm = []
    for t, rate, _, _ in steps:
        low, high = bisect.bisect_left(times, t - 1.0), bisect.bisect_right(times, t)
        if high > low and times[low] <= t - 0.9 and max(rates[low:high]) < 0.3:
            calm.append(rate)
    return turns, statistics.median(calm) if calm else float("nan")


PLOT = """
set terminal svg dynamic size 900,620 font 'sans,12' background rgb 'white'
set output '{output}'
set multiplot layout 3,1 margins 0.08,0.98,0.09,0.97 spacing 0.05
set grid; unset key; set format x ''
set ylabel 'gyro [rad/s]'; plot '{steps}' using 1:4 with lines lc rgb '#555555' notitle
set ylabel 'overlap'; set yrange [0:1.05]; plot '{steps}' using 1:3 with lines lc rgb '#0066aa' notitle
set ylabel 'update rate [Hz]'; set yrange [0:*]; set format x '%g'; set xlabel 'time [s]'
plot '{steps}' using 1:2 with fsteps lc rgb '#aa3300' notitle
"""


def plot(run, origin, output):
    with tempfile.TemporaryDirectory() as folder:
        steps = pathlib.Path(folder) / "steps"
        steps.write_text("".join(f"{t - origin:.3f} {rate:.2f} {'nan' if o is None else f'{o:.4f}'} {gyro:.4f}\n"
                                 for t, rate, o, gyro in updates(run)))
        subprocess.run(["gnuplot"], input=PLOT.format(output=output, steps=steps), text=True, check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reference", required=True)
    parser.add_argument("--plot", metavar="FIGURE.svg")
    parser.add_argument("run", nargs="+")
    options = parser.parse_args()
    times, rates = turn_rate(options.reference)
    print("| run | turn at [s]: peak [rad/s], largest rate within 0.5 s [Hz], least overlap | calm median [Hz] |\n|---|---|---|")
    for run in options.run:
        turns, calm = respond(run, times, rates)
        text = "; ".join(f"{t - times[0]:.1f}: {w:.1f}, {rate:.0f}, {'-' if o is None else f'{o:.2f}'}" for t, w, rate, o in turns)
        print(f"| {run} | {text} | {calm:.1f} |")
    if options.plot:
        plot(options.run[0], times[0], options.plot)
        print(f"wrote {options.plot}", file=sys.stderr)


if __name__ == "__main__":
    main()
