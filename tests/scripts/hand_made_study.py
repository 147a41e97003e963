"""Output folders of aslio experiment made by hand, for the tests of tools/analysis."""
import contextlib
import io
import json
import math
import pathlib
import re
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/analysis"))

import numpy as np


def yaw(a):
    return [0, 0, math.sin(a / 2), math.cos(a / 2)]


def write_tum(path, times, positions, quaternions):
    lines = [" ".join([f"{t:.9f}", *(f"{v:.12g}" for v in [*p, *q])]) for t, p, q in zip(times, positions, quaternions)]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def write_csv(path, columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [",".join(columns), *(",".join(map(str, line)) for line in zip(*columns.values()))]
    path.write_text("\n".join(lines) + "\n")


class StudyCase(unittest.TestCase):
    """A temporary folder, and studies in it."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def study(self, name, runs, planned=None, figures=("ate_m",), axes=(), expectation=(), baselines=()):
        """`runs`: (sequence, seed, method, figures, status, values of the axes); the last two may be left out. `expectation`: lines
        "RULE: **holds**" that the study has judged by itself. `baselines`: (method, baseline)."""
        text = ",".join(["data,sequence,seed,order_seed,method", *axes, "status,reason", *figures]) + "\n"
        for sequence, seed, method, values, *more in runs:
            status, at = more[0] if more else "ok", more[1] if len(more) > 1 else ()
            values = values if isinstance(values, (tuple, list)) else (values,)
            text += ",".join(map(str, [f"{sequence}_{seed}", sequence, seed, 0, method, *at, status, "",
                                       *("" if v is None else v for v in values)])) + "\n"
        (self.root / "results.csv").write_text(text)
        rules = [re.fullmatch(r"(.+): \*\*(.+)\*\*(?: \((.+)\))?", line).groups() for line in expectation]
        against = dict(baselines)
        (self.root / "study.json").write_text(json.dumps({
            "schema": "aslio/study_results/1", "name": name, "question": "Which?", "prediction": "This.", "rule": "The lower.",
            "planned": planned or len(runs), "done": len(runs), "metrics": list(figures[:1]),
            "methods": [{"name": method, "label": None, "baseline": against.get(method), "differs": []}
                        for method in dict.fromkeys(run[2] for run in runs)],
            "expectation": {"overall": "holds", "rules": [{"text": text, "verdict": verdict, "open": left or ""} for text, verdict, left in rules]}
            if rules else None, "identical": []}))
        return self.root

    def straight_truth(self, data, speed=1.0, seconds=10.0, text=""):
        t = np.arange(0, seconds + 1e-9, 0.005)
        folder = self.root / "data" / data
        write_tum(folder / "truth.tum", t, np.outer(speed * t, [1, 0, 0]), [yaw(0)] * len(t))
        (folder / "scene.yaml").write_text(text)
        return t


def printed(main, *words):
    """(exit code, stdout, stderr) of a script's main."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    return code, out.getvalue(), err.getvalue()
