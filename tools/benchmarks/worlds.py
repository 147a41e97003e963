#!/usr/bin/env python3
"""Run pipelines on the analytic world with several seeds (noise, biases and phase of the walk differ), and report median and range.

  tools/benchmarks/worlds.py --aslio build/release/tools/aslio/aslio --simulator build/release/tools/simulator/aslio_simulate_world \\
      --pipeline configs/pipelines/as_lio_plus.yaml configs/pipelines/fixed_window.yaml --sensor configs/sensors/livox_avia.yaml \\
      --output out/worlds --seeds 1 2 3 4 5 6
"""
import argparse
import pathlib
import subprocess

import replicates


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    replicates.add_common(parser)
    parser.add_argument("--simulator", required=True, help="the aslio_simulate_world executable")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5, 6])
    options = parser.parse_args()
    output = pathlib.Path(options.output)
    for seed in options.seeds:
        if not (output / f"world_{seed}" / "world.bag").exists():
            subprocess.run([options.simulator, "--output", str(output / f"world_{seed}"), "--seed", str(seed), "--quiet"], check=True)

    def run_one(pipeline, index):
        world = output / f"world_{options.seeds[index]}"
        return replicates.run(options, pipeline, output / pathlib.Path(pipeline).stem / f"{options.seeds[index]}",
                              world / "world.bag", world / "truth.tum")

    replicates.table(options, len(options.seeds), run_one)


if __name__ == "__main__":
    main()
