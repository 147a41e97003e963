"""The rules of the studies that take a design apart: corrections, the literal design, the filter, and the map that comes of it."""
import map_consistency as maps
import pairs
from report import at_least, number
from rules import no_other_below

THREE, NEEDED = 3, 2
MORE, LESS = 1.1, 0.9  # a median that rises, or falls, by more than 10 %


def deskew_ablation(report, _):
    study = report.study
    report.medians(study.methods)
    kinds = ("rigid", "asymptotic", "state")
    for window in ("fixed_10", "as_lio_plus"):
        default, others = f"{window}_linear", [f"{window}_{kind}" for kind in kinds]
        report.comparison([(other, default) for other in others])
        no_other_below(report, default, others, 0.9, NEEDED, THREE, "linear is the default")
    if not report.needs("fixed_10_rigid", "as_lio_plus_rigid", "fixed_10_linear", "as_lio_plus_linear"):
        return
    gains = [[report.ratio(f"fixed_10_{kind}", f"as_lio_plus_{kind}", s) for kind in ("rigid", "linear")] for s in study.sequences]
    won = [rigid > linear for rigid, linear in gains if None not in (rigid, linear)]
    report.claim(f"linear makes up for long windows: the gain of the adaptive one is larger with rigid on {sum(won)} of {len(won)} "
                 f"(needs {NEEDED} of {THREE})", at_least(sum(won), NEEDED, THREE, len(won)))


def literal_ladder(report, _):
    study = report.study
    report.medians(study.methods)
    parts = [method[len("with_"):] for method in study.methods if method.startswith("with_")]
    if not report.needs("as_lio", "as_lio_plus"):
        return
    report.comparison([(f"with_{part}", "as_lio") for part in parts])
    report.comparison([(f"without_{part}", "as_lio_plus") for part in parts])
    for part in parts:
        if not report.needs(f"with_{part}", f"without_{part}"):
            continue
        gains = report.medians_below(f"with_{part}", "as_lio", factor=LESS)
        losses = report.medians_below(f"without_{part}", "as_lio_plus", factor=MORE)
        ends = [at_least(gains.won, NEEDED, THREE, gains.count()), at_least(losses.lost, NEEDED, THREE, losses.count())]
        report.claim(f"{part} holds the literal design back: the literal design with as_lio_plus's gains on {gains.won} of {gains.count()}, as_lio_plus without it "
                     f"loses on {losses.lost} of {losses.count()} (needs {NEEDED} of {THREE} at one end)",
                     True if True in ends else None if None in ends else False)


def map_consistency(report, _):
    study, found = report.study, {}
    for run in study.runs:
        if run.good() and (run.folder / "map.ply").exists():
            found[run.data, run.method] = maps.measured(
                run.folder / "map.ply", study.data_file(run.data, "world.ply"), run.folder / "trajectory.tum",
                study.data_file(run.data, "truth.tum"))

    def median(method, sequence, name):
        # A run that failed has no map, and counts as worse than any.
        values = [float("inf") if not run.good() else found.get((run.data, method), {}).get(name) for run in study.of(method, sequence)]
        return pairs.median([value for value in values if value is not None])

    for sequence in study.sequences:
        report.text(f"{sequence}, median over seeds of the maps that are there:")
        report.table(["method", "mean map entropy", "distance to the surface, RMS [mm]", "median [mm]"], [
            [method, *(number(median(method, sequence, name)) for name in ("entropy", "rms_mm", "median_mm"))]
            for method in study.methods])
    if not report.needs("as_lio_plus", "fixed_10"):
        return
    for name, title in (("entropy", "entropy"), ("rms_mm", "RMS distance to the surface")):
        pairs_of = [(median("as_lio_plus", s, name), median("fixed_10", s, name)) for s in study.sequences]
        known = [pair for pair in pairs_of if None not in pair]
        won = sum(a < b for a, b in known)
        report.claim(f"the map is better: {title} of as_lio_plus below that of fixed_10 on {won} of {len(known)} (needs 2 of 2)",
                     at_least(won, 2, 2, len(known)))
