#!/usr/bin/env python3
"""Recall, delay and false alarms of the monitor, from the files of tools/benchmarks/monitor_faults.

usage: monitor_curve.py FOLDER

Reads FOLDER/SCENE.PIPELINE.FAULT.AT.csv, prints tables in Markdown: one row per fault (runs, those with an error above 1 m and 1 % of the
path, how many of them raised an alarm within 1 s of the fault or of the error, delays), the clean runs (hours, false alarms), and the
operating curve: the same with the main thresholds of MON-2, MON-3 and MON-6 times a factor. What the files do not hold, or what depends on
several sweeps, is not replayed: the share of the change of the view, two signs in one sweep and three slots in a row (MON-6), G (MON-3).
Alarms of the program and of the replay count alike; the alarms of the program alone are in the column `alarm` of the files.
"""
import csv
import pathlib
import statistics
import sys

VIEW, VIEW_STIR, VIEW_LEAST, STIRRED = 3.3, 2.2, 0.1, 0.5
MISFIT, MISFIT_STIRRED, ROUT, TEAR, MISMATCH, HOLD = 1.65, 1.2, 2.4, 30.0, 0.15, 0.12
ROUT_HOLD = 0.25
UNEXPLAINED, UNEXPLAINED_USUAL, UNEXPLAINED_JUMP, UNEXPLAINED_STIR = 0.1, 0.025, 4.0, 2.5
FACTORS = (0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5)


def load(path):
    rows = []
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if None in row.values():
                continue  # a run that was stopped
            rows.append({k: v if k == "tracking" else float(v) for k, v in row.items()})
    return rows


def replayed(rows, factor):
    """Moments of alarms of MON-2, MON-3 and MON-6 with scaled thresholds; one per segment, as the run."""
    out, held, routed, torn, stirred, segment, shares = [], 0.0, 0.0, 0.0, 1e9, None, []
    for row in rows:
        stirred += row["dt"]
        view = row["view_change"] > VIEW_LEAST
        if view and row["view_jump"] > VIEW_STIR * factor:
            stirred = 0.0
        alarm = view and row["view_jump"] > VIEW * factor
        # The turn rate is not in the file: in sharp turns the run asks for more (MON-6). -1: no slot ended here.
        if row["unexplained"] >= 0:
            share, usual = row["unexplained"], max([UNEXPLAINED_USUAL, *shares[-4:]])
            if len(shares) >= 4 and share > UNEXPLAINED:
                stirred = 0.0 if share > UNEXPLAINED_STIR * factor * usual else stirred
                alarm = alarm or share > UNEXPLAINED_JUMP * factor * usual
            shares.append(share)
        if row["accepted"]:
            held = held + row["dt"] if row["misfit"] > factor * (MISFIT_STIRRED if stirred < STIRRED else MISFIT) else 0.0
            rout = row["misfit"] + 0.5 * max(row["overlap_loss"], 0.0) + max(row["match_loss"], 0.0)
            routed = routed + row["dt"] if rout > factor * ROUT else 0.0
            torn = torn + row["dt"] if row["velocity_pull"] > factor * TEAR else 0.0
            alarm = alarm or max(held, torn) > HOLD or routed > ROUT_HOLD or row["gyro_mismatch"] > factor * MISMATCH or row["mount"] > factor
        if alarm and segment != row["segment"]:
            out.append(row["t"])
            segment = row["segment"]
    return out


def harmful_from(rows):
    """The first moment with an error above 1 m and 1 % of the path since the fault, or None."""
    return next((r["t"] for r in rows if r["error_m"] > 1.0 and r["error_m"] > 0.01 * r["path_m"]), None)


def first(times, begin):
    return next((t for t in times if t >= begin), None)


class Case:
    def __init__(self, path):
        self.scene, self.pipeline, self.fault, at = path.name[:-4].split(".", 3)
        self.rows = load(path)
        self.in_file = self.fault.startswith(("rot_", "move_"))
        self.begin = 0.0 if self.in_file or self.fault == "clean" else float(at)
        self.harm = harmful_from(self.rows)
        # Those of thresholds that have been lowered since the run, too.
        again = replayed(self.rows, 1.0)
        self.alarms = sorted({r["t"] for r in self.rows if r["alarm"]} | set(again))
        lost = sorted({r["t"] for r in self.rows if r["tracking"] == "lost"} | set(again))
        self.lost = first(lost, self.begin)

    def deadline(self):
        """1 s after the fault is in the data, or after it does harm where it does none at first."""
        return max(self.begin, self.harm if self.harm is not None else self.begin) + 1.0


def fault_table(cases):
    print("| fault | runs | with harm | in time | at all | delay after the fault: median, max [s] |")
    print("|---|---|---|---|---|---|")
    total = [0, 0, 0, 0]
    for fault in sorted({c.fault for c in cases if c.fault != "clean"}):
        some = [c for c in cases if c.fault == fault]
        harm = [c for c in some if c.harm is not None]
        said = [c for c in harm if c.lost is not None]
        timely = [c for c in said if c.lost <= c.deadline()]
        delays = [c.lost - c.begin for c in said]
        text = f"{statistics.median(delays):.2f}, {max(delays):.2f}" if delays else ""
        print(f"| {fault} | {len(some)} | {len(harm)} | {len(timely)} | {len(said)} | {text} |")
        total = [a + b for a, b in zip(total, (len(some), len(harm), len(timely), len(said)))]
    print(f"| all | {total[0]} | {total[1]} | {total[2]} | {total[3]} | |")


def good(case):
    return case.fault == "clean" and case.harm is None


def clean_table(cases):
    clean = [c for c in cases if c.fault == "clean" and c.rows]
    hours = sum(c.rows[-1]["t"] for c in clean if good(c)) / 3600
    false = [(c, t) for c in clean if good(c) for t in c.alarms]
    lost = [c for c in clean if not good(c)]
    silent = [c for c in lost if c.lost is None]
    print(f"\n{sum(map(good, clean))} clean runs without harm, {hours:.2f} h of data: {len(false)} false alarms")
    for case, t in false:
        print(f"- {case.scene} {case.pipeline} at {t:.1f} s")
    print(f"{len(lost)} clean runs with an error above 1 m and 1 %, {len(lost) - len(silent)} of them lost by their own account")
    for case in silent:
        print(f"- silent: {case.scene} {case.pipeline}, {max(r['error_m'] for r in case.rows):.1f} m")


def curve(cases):
    harm = [c for c in cases if c.fault != "clean" and c.harm is not None]
    clean = [c for c in cases if good(c) and c.rows]
    hours = sum(c.rows[-1]["t"] for c in clean) / 3600
    print("\n| thresholds times | in time, of the runs with harm | false alarms | per 10 h |")
    print("|---|---|---|---|")
    for factor in FACTORS:
        hits = 0
        for case in harm:
            t = first(replayed(case.rows, factor), case.begin)
            hits += t is not None and t <= case.deadline()
        false = sum(len(replayed(c.rows, factor)) for c in clean)
        rate = f"{10 * false / hours:.1f}" if hours > 0 else ""
        print(f"| {factor:g} | {hits} of {len(harm)} | {false} | {rate} |")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    cases = [Case(p) for p in sorted(pathlib.Path(sys.argv[1]).glob("*.csv"))]
    cases = [c for c in cases if len(c.rows) > 20]
    fault_table(cases)
    clean_table(cases)
    curve(cases)


if __name__ == "__main__":
    main()
