#!/usr/bin/env python3
"""Run a pipeline many times on one recording with harmless perturbations, and report median and range.

Replicate i uses stride phase (--seed) i and starts i/(N-1) * 0.5 s into the recording: results that should agree, so that their
spread says how much of a difference between two pipelines is luck. Standard library only.

  tools/benchmarks/replicates.py --aslio build/release/tools/aslio/aslio --pipeline configs/pipelines/as_lio_plus.yaml \\
      --input avia_corridor.bag --sensor configs/sensors/livox_avia.yaml --reference avia_corridor.gt.tum --output out/replicates
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys

METRICS = [
    ("ATE [m]", lambda s: s["metrics"]["ate_m"], "{:.4f}"),
    ("rotation [deg]", lambda s: s["metrics"]["ate_deg"], "{:.3f}"),
    ("end-to-end [cm]", lambda s: 100 * s["metrics"]["end_to_end_m"], "{:.2f}"),
    ("RPE 1 m [m]", lambda s: s["metrics"]["rpe"], "{:.4f}"),
    ("updates/s", lambda s: s["updates"] / s["data_s"], "{:.1f}"),
    ("CPU s/s", lambda s: s["cpu_s"] / s["data_s"], "{:.4f}"),
    ("RSS [MB]", lambda s: s["peak_rss_mb"], "{:.0f}"),
]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common(parser)
    parser.add_argument("--input", required=True)
    parser.add_argument("--reference", required=True)
    parser.add_argument("--replicates", type=int, default=20)
    return parser.parse_args()


def add_common(parser):
    parser.add_argument("--aslio", required=True, help="the aslio executable")
    parser.add_argument("--pipeline", required=True, nargs="+", help="one or more pipeline files")
    parser.add_argument("--sensor", required=True)
    parser.add_argument("--output", required=True)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="passed on to aslio run")


def run(options, pipeline, folder, recording, reference, more=()):
    """One run; its summary. A run that could not start ends the script with its message."""
    command = [options.aslio, "run", pipeline, "--input", str(recording), "--sensor", options.sensor, "--output", str(folder),
               "--reference", str(reference), "--quiet", *more]
    for override in options.set:
        command += ["--set", override]
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode not in (0, 1, 4):
        sys.exit(f"{' '.join(command)} ended with {result.returncode}:\n{result.stderr}")
    return json.loads((pathlib.Path(folder) / "summary.json").read_text())


def table(options, count, run_one):
    """Median and range of run_one(pipeline, index) for index < count, a row per pipeline."""
    print(f"| pipeline | runs | failed | {' | '.join(name for name, _, _ in METRICS)} |")
    print("|---" * (3 + len(METRICS)) + "|")
    for pipeline in options.pipeline:
        summaries = []
        for index in range(count):
            print(f"\r{pathlib.Path(pipeline).stem}: {index + 1}/{count}", end="", file=sys.stderr, flush=True)
            summaries.append(run_one(pipeline, index))
        print("\r\033[K", end="", file=sys.stderr)
        usable = [s for s in summaries if s["status"] in ("ok", "degraded")]
        cells = []
        for _, get, form in METRICS:
            values = [get(s) for s in usable]
            cells.append("-" if not values else " ".join(
                [form.format(statistics.median(values)), f"({form.format(min(values))} to {form.format(max(values))})"]))
        print(f"| {pathlib.Path(pipeline).stem} | {len(summaries)} | {len(summaries) - len(usable)} | {' | '.join(cells)} |",
              flush=True)


def main():
    options = arguments()

    def replicate(pipeline, index):
        start = 0.5 * index / max(options.replicates - 1, 1)
        return run(options, pipeline, pathlib.Path(options.output) / pathlib.Path(pipeline).stem / f"{index:02d}",
                   options.input, options.reference, ["--seed", str(index), "--start", f"{start:.4f}"])

    table(options, options.replicates, replicate)


if __name__ == "__main__":
    main()
