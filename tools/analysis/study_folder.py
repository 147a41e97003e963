"""What `aslio experiment` leaves in its output folder: the texts of the study, its runs, and the truth of its data.

A run that neither ended ok nor degraded has no figures: where figures are compared it counts as infinite, worse than any
other, and is never left out.
"""
import csv
import json
import math
import pathlib
import re
import statistics

GOOD = ("ok", "degraded")
OUTCOMES = {"holds": True, "does not hold": False, "not decided": None}
SCHEMA = "aslio/study_results/1"
FIXED_COLUMNS = ("data", "sequence", "seed", "order_seed", "method")


class FolderError(Exception):
    """A folder or a file that is not what it has to be; the text names it."""


def figure_of(text):
    return float(text) if text else None


class Run:
    """A line of results.csv."""

    def __init__(self, line, axes, figures, folder):
        self.data, self.sequence, self.method = line["data"], line["sequence"], line["method"]
        self.seed, self.order_seed = line["seed"], line["order_seed"]
        self.status, self.reason = line["status"], line["reason"]
        self.axes = {axis: line[axis] for axis in axes}
        self.figures = {name: figure_of(line[name]) for name in figures}
        name = self.method if self.order_seed in ("", "0") else f"{self.method}_order_{self.order_seed}"
        self.folder = folder / "runs" / self.data / name
        self.mark = None  # of divergence.py: "x" or "-"

    def good(self):
        return self.status in GOOD

    def value(self, metric):
        """The figure; infinite for a failure; None where a good run has none."""
        if metric == "end_to_end_m" and self.mark:
            return math.inf
        return self.figures.get(metric) if self.good() else math.inf



def in_order(values):
    return list(dict.fromkeys(values))


class Study:
    """Raises FolderError when the folder holds no study."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.runs = self._read_runs()
        self._read_study()
        self.p_values = self._read_statistics()
        self.sequences = in_order(run.sequence for run in self.runs)
        self.methods = in_order(run.method for run in self.runs)

    def _read(self, name):
        try:
            return (self.folder / name).read_text(encoding="utf-8")
        except OSError as error:
            raise FolderError(f"{self.folder / name}: {error.strerror}: name an output folder of aslio experiment") from error

    def _read_study(self):
        path = self.folder / "study.json"
        again = "run aslio experiment with this output folder again, which keeps the runs and writes it"
        if not path.exists() and (self.folder / "results.csv").exists():
            raise FolderError(f"{path}: is not there: the folder is of an older version; {again}")
        try:
            study = json.loads(self._read("study.json"))
            if study["schema"] != SCHEMA:
                raise ValueError
            self.name, self.question = study["name"], study["question"]
            self.prediction, self.rule, self.planned = study["prediction"], study["rule"], study["planned"]
            rules = (study["expectation"] or {"rules": []})["rules"]
            self.expectation = [(rule["text"], OUTCOMES[rule["verdict"]]) for rule in rules]
            self.baselines = [(method["name"], method["baseline"]) for method in study["methods"] if method["baseline"]]
        except (ValueError, TypeError, KeyError) as error:
            raise FolderError(f"{path}: is no JSON of schema {SCHEMA}; {again}") from error

    def _read_runs(self):
        lines = list(csv.reader(self._read("results.csv").splitlines()))
        header = lines[0] if lines else []
        if header[:5] != list(FIXED_COLUMNS) or "status" not in header:
            raise FolderError(f"{self.folder / 'results.csv'}: does not begin with the columns {', '.join(FIXED_COLUMNS)}")
        status = header.index("status")
        axes, figures = header[5:status], header[status + 2:]
        runs = [Run(dict(zip(header, line)), axes, figures, self.folder) for line in lines[1:]]
        if not runs:
            raise FolderError(f"{self.folder / 'results.csv'}: has no run")
        return runs

    def _read_statistics(self):
        """p of Wilcoxon's signed-rank test by (method, baseline, metric), over all sequences; the study has worked it out."""
        try:
            text = (self.folder / "statistics.csv").read_text(encoding="utf-8")
        except OSError:
            return {}  # a study that has no pairs yet
        try:
            return {(line["method"], line["baseline"], line["metric"]): float(line["p"])
                    for line in csv.DictReader(text.splitlines()) if line["baseline"] and line["p"]}
        except (ValueError, TypeError, KeyError) as error:
            raise FolderError(f"{self.folder / 'statistics.csv'}: is not that of aslio experiment") from error

    def wilcoxon(self, method, other, metric):
        """None where neither is the baseline of the other, or there are too few pairs. Two-sided: the order is the same."""
        return self.p_values.get((method, other, metric), self.p_values.get((other, method, metric)))

    def of(self, method, sequence=None):
        return [run for run in self.runs if run.method == method and sequence in (None, run.sequence)]

    def failures(self, method=None):
        return [run for run in self.runs if not run.good() and method in (None, run.method)]

    def mixed(self):
        """Methods whose runs were made with different pipelines: the file was changed while the study ran, or between calls."""
        out = []
        for method in self.methods:
            texts = set()
            for run in self.of(method):
                try:
                    # A schedule that is replayed is another for each recording.
                    texts.add((run.folder / "resolved.yaml").read_text(encoding="utf-8").replace(run.data, "DATA"))
                except OSError:
                    continue
            if len(texts) > 1:
                out.append(method)
        return out

    def seeds(self):
        return in_order(run.seed for run in self.runs)

    def by_recording(self, method, sequence, metric, value=Run.value):
        """{recording: {order seed: value(run, metric)}}, failures infinite; runs that have no such figure are left out."""
        found = {}
        for run in self.of(method, sequence):
            if value(run, metric) is not None:
                found.setdefault(run.data, {})[run.order_seed] = value(run, metric)
        return found

    def values(self, method, sequence, metric, value=Run.value):
        """Of all recordings, each by its median over the order seeds, which are no independent replicates."""
        return [statistics.median(orders.values()) for orders in self.by_recording(method, sequence, metric, value).values()]

    def pairs(self, method, other, metric, sequence=None):
        """(value of method, value of other) over the same recording, each by its median over the order seeds that both have."""
        ours, others = self.by_recording(method, sequence, metric), self.by_recording(other, sequence, metric)
        found = []
        for data, orders in ours.items():
            both = [seed for seed in orders if seed in others.get(data, {})]
            if both:
                found.append(tuple(statistics.median(side[data][seed] for seed in both) for side in (ours, others)))
        return found

    def data_file(self, data, name):
        return self.folder / "data" / data / name

    def scene_value(self, data, key):
        """The number at `section.key` of the scene as it was simulated, or None."""
        section, name = key.split(".")
        try:
            lines = self.data_file(data, "scene.yaml").read_text(encoding="utf-8").splitlines()
        except OSError as error:
            raise FolderError(f"{self.data_file(data, 'scene.yaml')}: {error.strerror}") from error
        inside = False
        for line in lines:
            if not line.startswith(" "):
                inside = line.startswith(section + ":")
            elif inside and line.strip().startswith(name + ":"):
                return float(line.split(":", 1)[1])
        return None

    def scale(self, data):
        """The --scale of the simulation, from the first line of its scene."""
        path = self.data_file(data, "scene.yaml")
        with open(path, encoding="utf-8") as lines:
            match = re.search(r"--scale ([0-9.e+-]+)", lines.readline())
        if not match:
            raise FolderError(f"{path}: its first line does not give the scale")
        return float(match.group(1))


def summary_of(run):
    """summary.json of a run; empty where there is none."""
    try:
        return json.loads((run.folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
