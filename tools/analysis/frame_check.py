#!/usr/bin/env python3
"""How well `aslio inspect --check` finds errors that are put into sensor files of simulated recordings.

usage: frame_check.py ASLIO OUT [--scenes NAME[:SCALE] ..] [--seeds N ..] [--no-reference] [--set KEY=VALUE ..]

Simulates each scene and seed once, below OUT, and checks it with a sensor file that is right and with seven that are
wrong. Prints a table and writes OUT/results.csv: whether the right key was named, whether another was, and the error
of the value in standard deviations. All data are simulated.
"""
import argparse
import csv
import json
import math
import pathlib
import random
import re
import statistics
import subprocess
import sys


SCENES = pathlib.Path(__file__).resolve().parents[2] / "configs" / "scenes"
DELAY = 0.002  # of the filter of the simulated IMU with the preset `datasheet` [s]


def product(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(A):
    return [list(row) for row in zip(*A)]


def unit(v):
    length = math.hypot(*v)
    return [x / length for x in v]


def turn(axis, degrees):
    """Rotation about an axis (Rodrigues)."""
    x, y, z = unit(axis)
    K = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    KK = product(K, K)
    s, c = math.sin(math.radians(degrees)), 1 - math.cos(math.radians(degrees))
    return [[(i == j) + s * K[i][j] + c * KK[i][j] for j in range(3)] for i in range(3)]


def angle_vector(R):
    v = [(R[2][1] - R[1][2]) / 2, (R[0][2] - R[2][0]) / 2, (R[1][0] - R[0][1]) / 2]
    s = math.hypot(*v)
    angle = math.atan2(s, (R[0][0] + R[1][1] + R[2][2] - 1) / 2)
    return v if s < 1e-12 else [x / s * angle for x in v]


def rows_of(numbers):
    return [numbers[0:3], numbers[3:6], numbers[6:9]]


class SensorFile:
    """Text of a sensor file, its extrinsic apart."""

    def __init__(self, text):
        block = re.search(r"^T_imu_lidar:\n((?:[ ]+.*\n)+)", text, re.M)
        numbers = {key: [float(x) for x in values.split(",")] for key, values in re.findall(r"(\w+): \[([^\]]*)\]", block.group(1))}
        self.p, self.R = numbers["translation"], rows_of(numbers["rotation"])
        self.rest = text.replace(block.group(0), "")

    def text(self, R=None, p=None, **keys):
        R, p = R or self.R, p or self.p
        kept = [line for line in self.rest.splitlines() if line.split(":")[0] not in keys]
        flat = [x for row in R for x in row]
        return "\n".join(kept + [f"T_imu_lidar: {{translation: {p}, rotation: {flat}}}"] + [f"{k}: {v}" for k, v in keys.items()]) + "\n"


def errors(sensor, seed):
    """name, key that must be named, text of the sensor file."""
    random_ = random.Random(seed)
    direction, way = ([random_.gauss(0, 1) for _ in range(3)] for _ in range(2))
    axis = random_.randrange(3)
    signs = [-1 if i == axis else 1 for i in range(3)]
    return [
        ("clean", None, sensor.text()),
        ("rotation 0.5 deg", "T_imu_lidar", sensor.text(R=product(turn(direction, 0.5), sensor.R))),
        ("lever arm 3 cm", "T_imu_lidar", sensor.text(p=[a + 0.03 * b for a, b in zip(sensor.p, unit(way))])),
        ("delay 5 ms", "imu_time_offset", sensor.text(imu_time_offset=0.005)),
        ("gyro sign", "gyro_signs", sensor.text(gyro_signs=signs)),
        ("accelerometer sign", "acc_signs", sensor.text(acc_signs=signs)),
        ("stamp at the end", "lidar_stamp", sensor.text(lidar_time_offset=0.1)),
        ("stamp in the middle", "lidar_stamp", sensor.text(lidar_time_offset=0.05)),
    ]


def chi(delta, sigma):
    return math.sqrt(sum((d / s) ** 2 for d, s in zip(delta, sigma)) / 3)


def judge(result, name, key, truth):
    """A row of the table."""
    keys = {f["key"] for f in result["findings"] if f["kind"] == "WRONG" and f.get("key")}
    row = {"found": int(key is None or key in keys), "false": len(keys - {key})}
    row["keys"] = " ".join(sorted(keys))
    fit = result["lidar_against_gyro"]
    if "delay_s" in fit:
        injected = {"delay 5 ms": 0.005, "stamp at the end": -0.1, "stamp in the middle": -0.05}.get(name, 0.0)
        row["delay_error_ms"] = 1e3 * (fit["delay_s"] - injected - DELAY)
        row["delay_sigmas"] = row["delay_error_ms"] / 1e3 / math.hypot(fit["sigma_delay_s"], 0.0003)
    if "T_imu_lidar" in result:
        T = result["T_imu_lidar"]
        off = angle_vector(product(rows_of(T["rotation"]), transposed(truth.R)))
        row["rotation_error_deg"] = math.degrees(math.hypot(*off))
        row["rotation_sigmas"] = chi(off, T["sigma_rotation_rad"])
        shift = [a - b for a, b in zip(T["translation"], truth.p)]
        row["shift_error_mm"] = 1e3 * math.hypot(*shift)
        row["shift_sigmas"] = chi(shift, T["sigma_translation_m"])
    return row


def recording(aslio, out, scene, scale, seed, sets):
    folder = out / f"{scene}_{scale}_{seed}"
    if not (folder / "dataset.yaml").exists():
        command = [aslio, "simulate", str(SCENES / f"{scene}.yaml"), "--output", str(folder), "--seed", str(seed),
                   "--scale", str(scale), "--quiet"]
        subprocess.run(command + [word for s in sets for word in ("--set", s)], check=True)
    return folder


def check(aslio, folder, name, sensor, reference):
    label = name.replace(" ", "_").replace(".", "") + ("" if reference else "_alone")
    path, output = folder / f"{label}.yaml", folder / f"{label}.json"
    path.write_text(sensor)
    output.unlink(missing_ok=True)
    command = [aslio, "inspect", str(next(folder.glob("*.bag"))), "--sensor", str(path), "--check", "--quiet", "--json", str(output)]
    if reference:
        command += ["--reference", str(folder / "truth.tum")]
    ended = subprocess.run(command, capture_output=True, text=True)
    (folder / f"{label}.txt").write_text(ended.stdout + ended.stderr)
    if not output.exists():
        sys.exit(f"{' '.join(command)}: {ended.stderr}")
    return json.loads(output.read_text())


def table(rows):
    names = list(dict.fromkeys(row["error"] for row in rows))
    print("| error | found | another key named | rotation off [deg] | shift off [mm] | delay off [ms] | largest off [sigma] |")
    print("|---|---|---|---|---|---|---|")
    for name in names:
        of = [row for row in rows if row["error"] == name]

        def median(key):
            values = [abs(row[key]) for row in of if key in row]
            return f"{statistics.median(values):.2f}" if values else "-"

        sigmas = [abs(row[k]) for row in of for k in ("rotation_sigmas", "shift_sigmas", "delay_sigmas") if k in row]
        print(f"| {name} | {sum(row['found'] for row in of)} of {len(of)} | {sum(row['false'] > 0 for row in of)} | "
              f"{median('rotation_error_deg')} | {median('shift_error_mm')} | {median('delay_error_ms')} | "
              f"{max(sigmas, default=float('nan')):.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("aslio")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--scenes", nargs="+", default=["quickstart:1", "indoor_1:0.4", "outdoor_2:0.25", "drive_city:1"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--errors", nargs="+", help="only these, by the begin of their names")
    parser.add_argument("--no-reference", action="store_true")
    parser.add_argument("--set", action="append", default=[], dest="sets")
    a = parser.parse_args()
    rows = []
    for scene in a.scenes:
        name, _, scale = scene.partition(":")
        for seed in a.seeds:
            folder = recording(a.aslio, a.out, name, scale or "1", seed, a.sets)
            sensor = SensorFile((folder / "sensor.yaml").read_text())
            for error, key, wrong in errors(sensor, seed):
                if a.errors and not any(error.startswith(e) for e in a.errors):
                    continue
                result = check(a.aslio, folder, error, wrong, not a.no_reference)
                rows.append({"scene": name, "seed": seed, "error": error, **judge(result, error, key, sensor)})
                print(rows[-1], file=sys.stderr, flush=True)
    fields = list(dict.fromkeys(key for row in rows for key in row))
    with open(a.out / ("alone.csv" if a.no_reference else "results.csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, fields)
        writer.writeheader()
        writer.writerows(rows)
    table(rows)


if __name__ == "__main__":
    main()
