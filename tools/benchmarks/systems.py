#!/usr/bin/env python3
"""Run every pipeline on the simulated Avia corridor, from several starts, and on drive 0005 of KITTI; print the table of docs/systems.md.

A start is a --seed: another phase of the stride and another start of the first window. On the drive, whose OXTS position drifts by
metres, a pipeline is compared with the published trajectory of its own name, or else with FAST-LIO2's. Standard library only.

  tools/benchmarks/systems.py --aslio build/release/tools/aslio/aslio --corridor avia_corridor.bag --truth avia_corridor.gt.tum \\
      --drive DRIVE --published reference/kitti_0005 --output out/systems --into docs/systems.md
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BEGIN, END = "<!-- systems, generated -->", "<!-- end of systems -->"
HEAD = ["pipeline", "corridor: ATE [m], `--seed 0`", "all starts: median (range)", "rotation [deg]", "ended", "CPU [s/s]",
        "drive: ATE [m]", "to", "CPU [s/s]"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--aslio", required=True, help="the aslio executable")
    parser.add_argument("--corridor", required=True, help="the corridor's bag")
    parser.add_argument("--truth", required=True, help="its truth (TUM)")
    parser.add_argument("--drive", required=True, help="folder of the KITTI drive")
    parser.add_argument("--published", required=True, type=pathlib.Path, help="folder of published trajectories of the drive (TUM)")
    parser.add_argument("--pipeline", nargs="*", type=pathlib.Path, default=sorted((ROOT / "configs/pipelines").glob("*.yaml")))
    parser.add_argument("--beginnings", type=int, default=6)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--into", type=pathlib.Path, help=f"Markdown file; replaces what stands between '{BEGIN}' and '{END}'")
    options = parser.parse_args()
    if options.beginnings < 1:
        parser.error("--beginnings: at least 1")
    if options.into:
        text = options.into.read_text()
        if text.count(BEGIN) != 1 or text.count(END) != 1:
            parser.error(f"{options.into}: needs one line '{BEGIN}' and one '{END}'")
    return options


def run(aslio, pipeline, recording, sensor, reference, folder, seed=0):
    """One run on one thread; its summary. A run that could not start ends the script with its message."""
    command = [aslio, "run", str(pipeline), "--input", str(recording), "--sensor", str(ROOT / "configs/sensors" / sensor), "--reference",
               str(reference), "--output", str(folder), "--seed", str(seed), "--threads", "1", "--quiet"]
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode not in (0, 1, 4):
        sys.exit(f"{' '.join(command)} ended with {result.returncode}:\n{result.stderr}")
    return json.loads((folder / "summary.json").read_text())


def lidar_ate(aslio, folder, reference):
    """ATE of the LiDAR's own trajectory: what KISS-ICP publishes is of the LiDAR, not of the IMU."""
    command = [aslio, "evaluate", str(folder / "trajectory_lidar.tum"), "--reference", str(reference), "--json"]
    found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return found["ate_m"]


def held(summary):
    return summary["status"] in ("ok", "degraded")


def cost(summaries):
    """The least of the runs that held: whatever else runs on the machine only adds to it."""
    return f"{min(s['cpu_s'] / s['data_s'] for s in summaries):.3f}" if summaries else "-"


def corridor(options, pipeline):
    folder = options.output / "corridor" / pipeline.stem
    return [run(options.aslio, pipeline, options.corridor, "livox_avia.yaml", options.truth, folder / str(seed), seed)
            for seed in range(options.beginnings)]


def drive(options, pipeline):
    """Summary of the run, ATE [m] to the published trajectory (None when it was lost), and whose that is."""
    own = options.published / f"{pipeline.stem}.tum"
    reference = own if own.exists() else options.published / "fast_lio2.tum"
    folder = options.output / "drive" / pipeline.stem
    summary = run(options.aslio, pipeline, options.drive, "kitti_hdl64.yaml", reference, folder)
    if not held(summary):
        return summary, None, reference.stem
    ate = lidar_ate(options.aslio, folder, reference) if reference.stem == "kiss_icp" else summary["metrics"]["ate_m"]
    return summary, ate, reference.stem


def row(pipeline, beginnings, driven):
    ended = [s for s in beginnings if held(s)]
    lost = len(beginnings) - len(ended)
    ates = [s["metrics"]["ate_m"] for s in ended]
    first = beginnings[0]
    whole = held(first)
    spread = f"{statistics.median(ates):.3f} ({min(ates):.3f} to {max(ates):.3f})" if ates else "-"
    summary, ate, whose = driven
    return [f"`{pipeline.stem}`", f"{first['metrics']['ate_m']:.3f}" if whole else "x", spread,
            f"{first['metrics']['ate_deg']:.2f}" if whole else "x",
            f"{first['status']}{f', {lost} of {len(beginnings)} lost' if lost else ''}", cost(ended),
            summary["status"] if ate is None else f"{ate:.3f}", f"`{whose}`", cost([] if ate is None else [summary])]


def main():
    options = arguments()
    lines = [HEAD, ["---"] * len(HEAD)]
    for number, pipeline in enumerate(options.pipeline):
        print(f"[{number + 1}/{len(options.pipeline)}] {pipeline.stem}", file=sys.stderr, flush=True)
        lines.append(row(pipeline, corridor(options, pipeline), drive(options, pipeline)))
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    print(table)
    if options.into:
        text = options.into.read_text()
        head, tail = text.split(BEGIN)[0], text.split(END)[1]
        options.into.write_text(f"{head}{BEGIN}\n{table}\n{END}{tail}")


if __name__ == "__main__":
    main()
