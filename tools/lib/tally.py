#!/usr/bin/env python3
"""Counts of checks: what a run adds to a tally file, and the closing line of all.

usage: tally.py junit REPORT.xml CTEST_EXIT TALLY    adds the cases of a ctest report; exit 1 when one failed
       tally.py close TALLY                          prints 'N passed, N failed[, N skipped]';
                                                     exit 1 when something failed or nothing ran
"""
import sys
import xml.etree.ElementTree as ElementTree


def count_report(path, ctest_exit):
    """Passed, failed, skipped of a JUnit file; a crash, a time-out and a test that could not start have failed."""
    passed = failed = skipped = 0
    try:
        cases = list(ElementTree.parse(path).getroot().iter("testcase"))
    except (OSError, ElementTree.ParseError) as error:
        print(f"error: no test report: {error}", file=sys.stderr)
        return 0, 1, 0
    for case in cases:
        status = case.get("status")
        reason = case.find("skipped")
        message = "" if reason is None else reason.get("message", "")
        if status == "run":
            passed += 1
        elif status == "disabled" or message.startswith("SKIP_"):
            skipped += 1
        else:
            failed += 1
            print(f"failed: {case.get('name')}")
    if ctest_exit != 0 and failed == 0:
        print(f"error: ctest ended with {ctest_exit} though no case failed", file=sys.stderr)
        failed = 1
    return passed, failed, skipped


def append(path, name, counts):
    with open(path, "a", encoding="utf-8") as file:
        file.write("{}\t{}\t{}\t{}\n".format(name, *counts))


def close(path):
    totals = [0, 0, 0]
    try:
        with open(path, encoding="utf-8") as file:
            for line in file:
                for i, field in enumerate(line.rstrip("\n").split("\t")[1:]):
                    totals[i] += int(field)
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        totals[1] += 1
    passed, failed, skipped = totals
    print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    if passed + failed == 0:
        print("error: no test ran", file=sys.stderr)
    return 0 if failed == 0 and passed > 0 else 1


def main(arguments):
    if len(arguments) == 4 and arguments[0] == "junit":
        counts = count_report(arguments[1], int(arguments[2]))
        append(arguments[3], "tests", counts)
        return 1 if counts[1] else 0
    if len(arguments) == 2 and arguments[0] == "close":
        return close(arguments[1])
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
