#!/usr/bin/env python3
"""What the rule of a study says to its runs, as Markdown.

  tools/analysis/decide.py out/window_ablation --tuning out/tuning

Takes the output folder of `aslio experiment`. A study with an `expectation` has judged itself: its verdicts are those of its
table.md. The rules of the others in experiments/, which need trajectories, telemetry, maps or another study, are here, found by
the name of the study. Exit 0 when all of the rule is decided, 1 when part of it cannot be (runs or sequences are missing, arms that must be
alike are not) or nothing of it is decided here, 2 when the folder is no study. Needs numpy.
"""
import argparse
import sys

import ablations
import garage
import mechanism
import rules
from report import Report
from study_folder import FolderError, Study

RULES = {name: getattr(rules, name) for name in (
    "adaptivity", "ideal_imu", "window_ablation", "yoked", "equal_points", "compute_saving", "dynamic_people", "imu_rate_sweep",
    "history_by_noise")}
RULES.update(degenerate_garage=garage.degenerate_garage, why=mechanism.why, map_consistency=ablations.map_consistency,
             deskew_ablation=ablations.deskew_ablation, literal_ladder=ablations.literal_ladder)


def rule_of(study, name=None):
    """The rule of this name, or of the study: one that needs more than medians, or what the study itself has judged."""
    return RULES.get(name or study.name, rules.by_expectation)


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", help="output folder of aslio experiment")
    parser.add_argument("--rule", choices=sorted(RULES), help="of this study, for one of another name")
    parser.add_argument("--best-fixed", metavar="METHOD", help="the best single fixed rate, where a rule asks for it")
    parser.add_argument("--tuning", metavar="STUDY", help="folder of a study with the same fixed rates over tuning data, which "
                        "choose the best of them")
    return parser.parse_args(words)


def main(words):
    options = arguments(words)
    try:
        options.tuning = Study(options.tuning) if options.tuning else None
        report = Report(Study(options.study))
        rule_of(report.study, options.rule)(report, options)
    except FolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    sys.stdout.write(report.markdown())
    return 0 if report.decided() else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
