#!/usr/bin/env python3
"""How much the overlap degree changes with an error of the pose, with and without a soft margin: Markdown and CSV.

  tools/analysis/sod_pose_error.py out/indoor_1/data --aslio build/release/tools/aslio/aslio --output out/figures

Scores each dataset with `aslio overlap` at its true poses and at poses off by 2 cm and 0.3 degrees, for hard_voxel and
soft_voxel at 3 layers and at a margin in metres, and voxels of several sizes. Exit 0, 2 when a command fails. Needs numpy.
"""
import argparse
import csv
import pathlib
import subprocess
import sys
import tempfile

from numerics import np

from motion import table
from pairs import median
from report import markdown_table
from study_folder import FolderError

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIZES = ("0.1", "0.2", "0.3", "0.4")
METRICS = {"hard": "type: hard_voxel", "soft, 3 layers": "type: soft_voxel, layers: 3",
           "soft, margin {margin} m": "type: soft_voxel, margin_m: {margin}"}
COLUMNS = ("data", "metric", "voxel", "mean", "mean_change", "rms_change", "p95_change", "bias")


def score(options, dataset, metric, size, folder):
    """Columns sod and sod_moved of all frames that have both, after the first `skip` seconds."""
    out = pathlib.Path(folder) / "overlap.csv"
    block = METRICS[metric].format(margin=options.margin)
    command = [str(options.aslio), "overlap", str(options.pipeline), "--dataset", str(dataset), "--output", str(out),
               "--set", f"overlap={{{block}, voxel: {size}}}", "--position-error", str(options.position_error),
               "--rotation-error", str(options.rotation_error), "--quiet"]
    if options.duration:
        command += ["--duration", str(options.duration)]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise FolderError(f"{options.aslio}: {error.strerror}: name the program with --aslio") from error
    if ended.returncode != 0:
        raise FolderError(f"{' '.join(command)}: {ended.stderr.strip()}")
    columns = table(out, ["t_ns", "sod", "sod_moved"])
    use = (columns["t_ns"] - columns["t_ns"][0]) * 1e-9 >= options.skip
    use &= np.isfinite(columns["sod"]) & np.isfinite(columns["sod_moved"])
    if not np.any(use):
        raise FolderError(f"{dataset}: has no frame with a score after {options.skip:g} s")
    return columns["sod"][use], columns["sod_moved"][use]


def figures(options):
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        for dataset in options.dataset:
            for metric in METRICS:
                for size in SIZES:
                    sod, moved = score(options, dataset, metric, size, folder)
                    change = np.abs(moved - sod)
                    name = dataset.name if dataset.is_dir() else dataset.stem
                    lines.append({"data": name, "metric": metric.format(margin=options.margin),
                                  "voxel": size, "mean": float(np.mean(sod)), "mean_change": float(np.mean(change)),
                                  "rms_change": float(np.sqrt(np.mean(change**2))),
                                  "p95_change": float(np.percentile(change, 95)), "bias": float(np.mean(moved - sod))})
    return lines


def summary(lines):
    """Medians over the datasets; the mean change also as a multiple of that of the soft metric at 3 layers."""
    metrics = list(dict.fromkeys(line["metric"] for line in lines))

    def middle(metric, size, name):
        return median([line[name] for line in lines if (line["metric"], line["voxel"]) == (metric, size)])

    out = []
    for metric in metrics:
        for size in SIZES:
            soft = middle("soft, 3 layers", size, "mean_change")
            own = middle(metric, size, "mean_change")
            out.append([metric, size, f"{middle(metric, size, 'mean'):.3f}", f"{own:.4f}",
                        f"{middle(metric, size, 'p95_change'):.4f}", f"{middle(metric, size, 'bias'):+.4f}",
                        f"{own / soft:.1f}" if soft > 0 else "-"])
    return markdown_table(["metric", "voxel [m]", "mean O", "mean change", "95th percentile", "mean signed change",
                           "times that of soft, 3 layers"], out)


def verdict(lines):
    """The rule of experiments/sod_voxel_size.yaml about the pose."""
    change = {(metric, size): median([line["mean_change"] for line in lines if (line["metric"], line["voxel"]) == (metric, size)])
              for metric in ("hard", "soft, 3 layers") for size in SIZES}
    less = sum(change["soft, 3 layers", size] < change["hard", size] for size in SIZES)
    return (f"Robust to the pose: the soft degree at 3 layers changes less than the hard one at {less} of {len(SIZES)} sizes (needs all): "
            + ("**holds**" if less == len(SIZES) else "**does not hold**"))


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", nargs="+", type=pathlib.Path, help="folder of aslio simulate, or dataset file")
    parser.add_argument("--aslio", required=True, type=pathlib.Path, help="the program")
    parser.add_argument("--output", required=True, type=pathlib.Path, help="folder for the tables")
    parser.add_argument("--pipeline", type=pathlib.Path, default=ROOT / "configs/pipelines/as_lio_plus.yaml")
    parser.add_argument("--position-error", type=float, default=0.02, help="[m]")
    parser.add_argument("--rotation-error", type=float, default=0.3, help="[deg]")
    parser.add_argument("--margin", type=float, default=0.4, help="[m], of the soft metric with a margin in metres")
    parser.add_argument("--skip", type=float, default=3.0, help="seconds at the begin that do not count (default 3)")
    parser.add_argument("--duration", type=float, help="seconds of data to use")
    return parser.parse_args(words)


def main(words):
    options = arguments(words)
    try:
        lines = figures(options)
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    options.output.mkdir(parents=True, exist_ok=True)
    with open(options.output / "sod_pose_error.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)
    text = summary(lines) + "\n\n" + verdict(lines) + "\n"
    (options.output / "sod_pose_error.md").write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
