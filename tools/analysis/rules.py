"""The decision rules of the studies in experiments/ that results.csv alone can decide, one function per study.

Each takes the Report and the options of decide.py, and repeats in code the `rule` that its study states in words.
"""
import math
import pathlib
import statistics

import pairs
from rates import ALIKE, TITLES, Rates
from report import at_least, number

NINE = 9
FASTER = ("fixed_20", "fixed_50", "fixed_125", "fixed_20_history", "fixed_50_history", "fixed_125_history")
SINGLE = ("fixed_10", "fixed_10_history", *FASTER)


def beats(report, method, other, needed, of, claim):
    """The method has the lower median ATE on at least `needed` of `of` sequences."""
    if not report.needs(method, other):
        return
    tally = report.medians_below(method, other)
    report.claim(f"{claim}: {method} below {other} on {tally.won} of {tally.count()} (needs {needed} of {of})",
                 at_least(tally.won, needed, of, tally.count()))


def beats_pairs(report, method, other):
    """Most pairs."""
    if not report.needs(method, other):
        return
    tally = pairs.Tally.of(report.study.pairs(method, other, "ate_m"))
    report.claim(f"{method} wins {tally.won} of {tally.count()} pairs against {other} (needs most)",
                 2 * tally.won > tally.count() if tally.count() else None)


def no_divergence(report, method):
    if not report.needs(method):
        return
    failed = report.study.failures(method)
    report.claim(f"{method} diverges on no run: {len(failed)} of {len(report.study.of(method))} failed", not failed)


def against_all(report, method):
    report.comparison([(method, other) for other in report.study.methods if other != method])


def adaptivity(report, options):
    best = chosen_rate(report, options, SINGLE)
    report.medians(report.study.methods)
    against_all(report, "as_lio_plus")
    beats(report, "as_lio_plus", "fixed_10", 8, NINE, "better than the fixed window")
    beats(report, "as_lio_plus", best, 6, NINE, "better than the best single rate")
    beats_pairs(report, "as_lio_plus", "shifted")
    no_divergence(report, "as_lio_plus")


def ideal_imu(report, options):
    best = chosen_rate(report, options, SINGLE)
    report.medians(report.study.methods)
    if not report.needs("as_lio_plus", best):
        return
    lines, harmless = [], []
    for sequence in report.study.sequences:
        fixed, ours = report.median(best, sequence), report.median("as_lio_plus", sequence)
        if ours is None or fixed is None:
            continue
        # Where the fixed rate fails, nothing is lost.
        share = ours / fixed if not math.isinf(fixed) else math.inf if math.isinf(ours) else 0.0
        lines.append([sequence, number(share, 3)])
        harmless.append(share <= 1.1 or (math.isinf(fixed) and math.isinf(ours)))
    report.text(f"as_lio_plus over {best}:")
    report.table(["sequence", "ratio"], lines)
    outcome = False if not all(harmless) else True if len(harmless) >= NINE else None
    report.claim(f"at most 10 % above {best} on {sum(harmless)} of {len(harmless)} sequences (needs {NINE})", outcome)


def best_fixed(study, candidates):
    """The fixed rate with the smallest geometric mean of its median ATE over the sequences, all those means, and on how many recordings:
    those that every candidate in the study has run on."""
    found = {method: {sequence: {data: statistics.median(orders.values()) for data, orders in
                                 study.by_recording(method, sequence, "ate_m").items()} for sequence in study.sequences}
             for method in candidates if method in study.methods}
    common = {sequence: set.intersection(*(set(values[sequence]) for values in found.values())) for sequence in study.sequences} if found else {}
    common = {sequence: data for sequence, data in common.items() if data}
    means = {}
    for method, values in found.items() if common else ():
        medians = [pairs.median([values[sequence][data] for data in recordings]) for sequence, recordings in common.items()]
        means[method] = math.exp(sum(math.log(m) if m > 0 else -math.inf for m in medians) / len(medians))
    return (min(means, key=means.get) if means else None), means, sum(map(len, common.values()))


def chosen_rate(report, options, candidates):
    if options.best_fixed:
        report.text(f"Best fixed rate: `{options.best_fixed}`, as chosen by the caller.")
        return options.best_fixed
    source = options.tuning or report.study
    name, means, recordings = best_fixed(source, candidates)
    if name is None:
        report.text(f"No recording that all of {', '.join(candidates)} have run on.")
        return candidates[0]
    figures = ", ".join(f"{method} {number(mean)}" for method, mean in means.items())
    where = f"on the tuning data (seeds {', '.join(source.seeds())})" if options.tuning else \
        "**on these very data, which favours it: name --tuning or --best-fixed**"
    left = "" if len(source.runs) >= source.planned else f" **Of {len(source.runs)} of {source.planned} runs.**"
    report.text(f"Best fixed rate: `{name}`, chosen {where}; geometric mean of median ATE over the {recordings} recordings that all have run "
                f"on: {figures}.{left}")
    return name


def window_ablation(report, options):
    best = chosen_rate(report, options, FASTER)
    report.medians(report.study.methods)
    report.comparison([(method, "fixed_10") for method in report.study.methods if method != "fixed_10"])
    report.comparison([("as_lio_plus", other) for other in dict.fromkeys(
        [best, "motion_rate", "imu_rate", "sod_hard", "lookahead", "weak_views", "least_20", "no_history", "overlapping"])])
    beats(report, best, "fixed_10", 6, NINE, "rate pays")
    beats(report, "as_lio_plus", best, 6, NINE, "adapting pays")
    beats(report, "as_lio_plus", "motion_rate", 6, NINE, "overlap pays")
    no_divergence(report, "as_lio_plus")


def yoked(report, _):
    found = Rates(report.study)
    report.medians(report.study.methods)
    report.medians(report.study.methods, "updates")
    found.tell(report, "updates")
    against_all(report, "as_lio_plus")
    if "replayed" in report.study.methods:
        same = report.study.pairs("as_lio_plus", "replayed", "ate_m")
        report.claim(f"check: the replayed schedule gives the same ATE in {sum(a == b for a, b in same)} of {len(same)} pairs",
                     all(a == b for a, b in same) if same else None)
    for control in ("shifted", "shuffled"):
        beats(report, "as_lio_plus", control, 6, NINE, "adaptivity helps")
        beats_pairs(report, "as_lio_plus", control)
    for control in ("fixed_mean", "gyro"):
        beats_alike(report, found, "updates", "as_lio_plus", control, 6, NINE, "as many updates")


def beats_alike(report, found, name, method, other, needed, of, claim):
    """As beats(), and undecided when the two differ in what they must have in common."""
    if not report.needs(method, other):
        return
    apart = found.apart(method, other, name)
    if apart is None or apart > ALIKE:
        told = "is not known" if apart is None else f"differs by {100 * apart:.0f} % on a sequence (limit {100 * ALIKE:.0f} %)"
        report.claim(f"{claim}: {TITLES[name]} of {method} and {other} {told}", None)
    else:
        beats(report, method, other, needed, of, claim)


def equal_points(report, _):
    found = Rates(report.study)
    report.medians(report.study.methods)
    for name in ("matches", "information", "updates"):
        found.tell(report, name)
    report.comparison([("fixed_20_equal", "fixed_10_equal"), ("fixed_50_equal", "fixed_10_equal"), ("as_lio_plus_share", "fixed_10_share"),
                       ("fixed_50_share", "fixed_10_share"), ("fixed_50_history", "fixed_50_equal"), ("as_lio_plus", "fixed_10"),
                       ("fixed_50_information", "fixed_10"), ("as_lio_plus_information", "fixed_10"),
                       ("fixed_50_spaced", "fixed_10_spaced"), ("as_lio_plus_spaced", "fixed_10_spaced")])
    beats_alike(report, found, "matches", "fixed_50_equal", "fixed_10_equal", 6, NINE, "the rate pays at equal points")
    beats_alike(report, found, "matches", "as_lio_plus_share", "fixed_10_share", 6, NINE, "adapting pays at equal points")
    beats_alike(report, found, "information", "fixed_50_information", "fixed_10", 6, NINE, "the rate pays at equal information")
    beats_alike(report, found, "information", "as_lio_plus_information", "fixed_10", 6, NINE, "adapting pays at equal information")
    beats(report, "as_lio_plus_spaced", "fixed_10_spaced", 6, NINE, "adapting pays at equal insertion")
    if report.needs("fixed_50_history", "fixed_50_equal"):
        lower = report.medians_below("fixed_50_history", "fixed_50_equal", factor=0.9)
        kept = lower.count() - lower.won
        report.claim(f"more points lower it by no more than 10 % on {kept} of {lower.count()} (needs 6 of {NINE})",
                     at_least(kept, 6, NINE, lower.count()))


def below(figure, other):
    return None not in (figure, other) and figure < other


def compute_saving(report, _):
    for metric in ("ate_m", "cpu_s_per_s", "updates"):
        report.medians(report.study.methods, metric)
    lines, saved, alone = [], 0, 0
    for sequence in report.study.sequences:
        ours, cost = (report.median("as_lio_plus", sequence, metric) for metric in ("ate_m", "cpu_s_per_s"))
        found = ours is not None and not math.isinf(ours)
        equal = {method: report.median(method, sequence, "cpu_s_per_s") for method in report.study.methods
                 if found and method != "as_lio_plus" and (report.median(method, sequence) or math.inf) <= 1.1 * ours}
        cheaper = [method for method, price in equal.items() if below(price, cost)]
        wins = found and not cheaper
        saved += wins
        alone += wins and not equal
        lines.append([sequence, ", ".join(equal) or ("none" if found else "as_lio_plus is lost"), ", ".join(cheaper) or "none", "yes" if wins else "no"])
    report.text("Methods with at most 1.1 times the median ATE of as_lio_plus:")
    report.table(["sequence", "as accurate", "and cheaper", "as_lio_plus saves"], lines)
    report.claim(f"as_lio_plus saves on {saved} of {len(lines)} sequences (needs 6 of {NINE})", at_least(saved, 6, NINE, len(lines)))
    if alone:
        report.text(f"- on {alone} of these no rival is as accurate")


def dynamic_people(report, _):
    report.medians(report.study.methods)
    report.medians(["as_lio_plus"], "updates")
    report.comparison([("as_lio_plus", "no_history"), ("as_lio_plus", "fixed_10")])
    base = "indoor_1_people_"
    if report.needs("as_lio_plus", "no_history"):
        crowded = [base + count for count in ("10", "20") if base + count in report.study.sequences]
        tally = report.medians_below("as_lio_plus", "no_history", sequences=crowded) if crowded else pairs.Tally()
        report.claim(f"history helps with 10 and with 20 people: on {tally.won} of {tally.count()} (needs 2 of 2)",
                     at_least(tally.won, 2, 2, tally.count()))
    few, many = report.median("as_lio_plus", base + "0", "updates"), report.median("as_lio_plus", base + "20", "updates")
    if few and many and not math.isinf(few + many):
        report.claim(f"people disturb the overlap: {few:g} updates with none, {many:g} with 20 (needs a change above 10 %)",
                     abs(many / few - 1) > 0.1)
    else:
        report.claim("people disturb the overlap: no updates to compare", None)


def no_other_below(report, default, others, factor, needed, of, claim):
    """No other method has a median below `factor` times that of the default on `needed` of `of` sequences."""
    for other in others:
        if not report.needs(default, other):
            continue
        tally = report.medians_below(other, default, factor=factor)
        below = at_least(tally.won, needed, of, tally.count())
        report.claim(f"{claim}: {other} is lower{'' if factor == 1 else f' by over {100 * (1 - factor):.0f} %'} than {default} "
                     f"on {tally.won} of {tally.count()} (must not on {needed} of {of})", None if below is None else not below)


def imu_rate_sweep(report, _):
    report.medians(report.study.methods)
    if not report.needs("fixed_10", "as_lio_plus"):
        return
    for place in ("indoor_1", "outdoor_4"):
        ratios = []
        for rate in (50, 100, 200, 400, 1000):
            ratios.append(report.ratio("fixed_10", "as_lio_plus", f"{place}_imu_{rate}"))
        report.text(f"{place}, fixed_10 over as_lio_plus at 50, 100, 200, 400, 1000 Hz: " + ", ".join(number(r, 3) for r in ratios) + ".")
        both = ratios[0] is not None and ratios[-1] is not None
        report.claim(f"{place}: the ratio is larger at 50 Hz than at 1000 Hz", ratios[0] > ratios[-1] if both else None)


def by_axes(report, *axes):
    """Method of each combination of values."""
    return {tuple(float(v) if v.replace(".", "", 1).isdigit() else v for v in (run.axes.get(axis, "") for axis in axes)): run.method
            for run in report.study.runs}


def history_by_noise(report, _):
    report.medians(report.study.methods)
    grid = by_axes(report, "history.rho", "estimator.noise")
    best = {}
    for sequence in report.study.sequences:
        for noise in dict.fromkeys(noise for _, noise in grid):
            medians = {rho: report.median(method, sequence) for (rho, n), method in grid.items() if n == noise}
            known = {rho: m for rho, m in medians.items() if m is not None and not math.isinf(m)}
            if known:
                rho = min(known, key=known.get)
                best[sequence, noise] = rho, known.get(0.0, math.inf), known[rho]
    report.text("Best weight of the history:")
    report.table(["sequence", "noise", "rho", "ATE there", "ATE without history"],
                 [[sequence, noise, rho, number(m), number(none)] for (sequence, noise), (rho, none, m) in best.items()])
    inflated, true = best.get(("indoor_1_empty", "fastlio")), best.get(("indoor_1_empty", "physical"))
    known = inflated and true
    report.claim("history repairs the noise model (empty: best rho above 0 under fastlio, no gain of 5 % under physical)",
                 (inflated[0] > 0 and (true[0] == 0 or true[2] > 0.95 * true[1])) if known else None)
    for noise in dict.fromkeys(noise for _, noise in grid):
        empty, people = best.get(("indoor_1_empty", noise)), best.get(("indoor_1_people", noise))
        report.claim(f"it is robustness, under {noise}: the best rho is higher with people",
                     people[0] > empty[0] if empty and people else None)


def by_expectation(report, _):
    """What the study has judged by itself, and its methods against their baselines."""
    study = report.study
    report.medians(study.methods)
    report.comparison(study.baselines or [(method, study.methods[0]) for method in study.methods[1:]])
    for text, outcome in study.expectation:
        report.claim(text, outcome)
    if study.expectation:
        return
    script = pathlib.Path(__file__).with_name(study.name + ".py")
    report.text(f"Its rule is decided by `tools/analysis/{script.name}`." if script.exists() else
                "It has no `expectation`; the above are the figures.")
