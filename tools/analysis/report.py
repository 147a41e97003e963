"""Markdown of verdicts, and the comparisons that most rules are made of."""
import math

import pairs
from pairs import LEAST_PAIRS, Tally

WORDS = {True: "holds", False: "does not hold", None: "not decided"}


def number(value, digits=4):
    if value is None:
        return "-"
    return "x" if math.isinf(value) else f"{value:.{digits}g}"


def probability(p):
    return f"{p:.2g}" if p >= 1e-4 else "< 0.0001"


def markdown_table(header, lines):
    out = ["| " + " | ".join(header) + " |", "|---" * len(header) + "|"]
    return "\n".join(out + ["| " + " | ".join(map(str, line)) + " |" for line in lines])


class Report:
    """What decide prints of one study."""

    def __init__(self, study):
        self.study = study
        self.parts = [f"# Verdict: {study.name}", f"**Rule.** {study.rule}", self._extent()]
        self.outcomes = []

    def _extent(self):
        study, failures = self.study, self.study.failures()
        text = f"{len(study.runs)} of {study.planned} runs, seeds {', '.join(filter(None, study.seeds())) or 'none'}."
        if not self.complete():
            text += " **Not complete: what follows is of the runs so far.**"
        mixed = study.mixed()
        if mixed:
            text += f" **Not one configuration: runs of {', '.join(mixed)} differ in resolved.yaml.**"
        if failures:
            text += f" {len(failures)} failed, and count as worse than any figure:\n\n"
            text += markdown_table(["data", "method", "status", "reason"], [
                [run.data, run.method, run.status, run.reason.replace("|", "/") or "-"] for run in failures])
        return text

    def text(self, *parts):
        self.parts += parts

    def table(self, header, lines):
        self.parts.append(markdown_table(header, lines))

    def claim(self, text, outcome):
        """True: holds, False: does not, None: the data cannot tell."""
        self.outcomes.append(outcome)
        line = f"- {text}: **{WORDS[outcome]}{'' if self.complete() or outcome is None else ' so far'}**"
        if self.parts[-1].startswith("- "):
            self.parts[-1] += "\n" + line
        else:
            self.parts.append(line)

    def complete(self):
        return len(self.study.runs) >= self.study.planned

    def decided(self):
        """All of the rule; a report without a claim has decided nothing."""
        return self.complete() and bool(self.outcomes) and None not in self.outcomes

    def markdown(self):
        return "\n\n".join(self.parts) + "\n"

    def median(self, method, sequence, metric="ate_m"):
        return pairs.median(self.study.values(method, sequence, metric))

    def ratio(self, method, other, sequence):
        """Of the medians: infinite where `method` fails, 0 where the other does; None where one is missing, or both fail."""
        a, b = self.median(method, sequence), self.median(other, sequence)
        if None in (a, b) or b == 0 or math.isinf(a) and math.isinf(b):
            return None
        return a / b

    def needs(self, *methods):
        """True when the study has runs of all of them; tells which are missing."""
        missing = [method for method in methods if method not in self.study.methods]
        if missing:
            self.claim(f"no run of {', '.join(missing)}", None)
        return not missing

    def medians_below(self, method, other, metric="ate_m", factor=1.0, sequences=None):
        """Won, lost and tied sequences: median of the method against `factor` times that of the other, over the recordings
        that both have (others alone could turn it)."""
        found = []
        for sequence in sequences or self.study.sequences:
            both = self.study.pairs(method, other, metric, sequence)
            if both:
                a, b = (pairs.median([pair[side] for pair in both]) for side in (0, 1))
                found.append((a, factor * b))
        return Tally.of(found)

    def comparison(self, matches, metric="ate_m"):
        """A line per (method, other): sequences, pairs, and what chance would have to explain."""
        lines = []
        for method, other in matches:
            if method not in self.study.methods or other not in self.study.methods:
                continue
            found = self.study.pairs(method, other, metric)
            tally, sign, p = Tally.of(found), "-", self.study.wilcoxon(method, other, metric)
            if not found:
                continue
            if tally.won + tally.lost >= LEAST_PAIRS:
                sign = probability(pairs.sign_test(tally))
            failed = f"{len(self.study.failures(method))} / {len(self.study.failures(other))}"
            wilcoxon = "-" if p is None else probability(p)
            lines.append([method, other, self.medians_below(method, other, metric), tally, ratio_text(found), sign, wilcoxon, failed])
        if lines:
            self.text(f"`{metric}`, smaller wins; won / lost / tied by median per sequence, and by pairs over the same data:")
            self.table(["method", "against", "sequences", "pairs", "median ratio", "sign p", "Wilcoxon p", "failed"], lines)

    def medians(self, methods, metric="ate_m", title=None):
        present = [method for method in methods if method in self.study.methods]
        self.text(f"Median {title or f'`{metric}`'} over seeds:")
        self.table(["sequence", *present], [
            [sequence, *(number(self.median(method, sequence, metric)) for method in present)]
            for sequence in self.study.sequences])


def ratio_text(found):
    """Median of the ratios of pairs."""
    ratios = [math.inf if math.isinf(a) else 0.0 if math.isinf(b) else a / b
              for a, b in found if b > 0 and not (math.isinf(a) and math.isinf(b))]
    return number(pairs.median(ratios), 3)


def at_least(won, needed, of, present):
    """Outcome of "on at least `needed` of `of`" when `present` of them are there, of which `won` are won."""
    if won >= needed:
        return True
    return None if won + max(0, of - present) >= needed else False
