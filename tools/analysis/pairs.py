"""Medians with failures, and tests of paired figures, exact and from first principles.

Sign test and Wilcoxon's signed-rank test (F. Wilcoxon, 1945), two-sided. The latter over logarithms of ratios, so that
sequences of different difficulty count alike; ties of rank get their mean, and the distribution is enumerated over the
ranks as they are. A failure against a figure is the largest difference there is; two failures, or two equal figures, say
nothing and are left out.
"""
import dataclasses
import math

LEAST_PAIRS = 6  # with five pairs the smallest two-sided p is 0.0625


def median(values):
    """None of nothing; infinite when a middle value is."""
    if not values:
        return None
    ordered, half = sorted(values), len(values) // 2
    return ordered[half] if len(ordered) % 2 else 0.5 * (ordered[half - 1] + ordered[half])


@dataclasses.dataclass
class Tally:
    """Smaller wins."""
    won: int = 0
    lost: int = 0
    tied: int = 0

    @staticmethod
    def of(pairs):
        won, lost = sum(a < b for a, b in pairs), sum(a > b for a, b in pairs)
        return Tally(won, lost, len(pairs) - won - lost)

    def count(self):
        return self.won + self.lost + self.tied

    def __str__(self):
        return f"{self.won} / {self.lost} / {self.tied}"


def sign_test(tally):
    """p of as uneven a division of wins and losses, or a more uneven one."""
    n, k = tally.won + tally.lost, min(tally.won, tally.lost)
    if n == 0:
        return 1.0
    return min(1.0, 2 * sum(math.comb(n, i) for i in range(k + 1)) / 2**n)


def signed_differences(pairs):
    """log(a / b), infinite where one of the two failed, without those that say nothing."""
    out = []
    for a, b in pairs:
        if a == b:
            continue
        if math.isinf(a) or b == 0:
            out.append(math.inf)
        elif math.isinf(b) or a == 0:
            out.append(-math.inf)
        else:
            out.append(math.log(a / b))
    return out


def doubled_ranks(magnitudes):
    """Twice the rank of each, ties at their mean: whole numbers."""
    order = sorted(range(len(magnitudes)), key=lambda i: magnitudes[i])
    ranks, begin = [0] * len(order), 0
    while begin < len(order):
        end = begin
        while end < len(order) and magnitudes[order[end]] == magnitudes[order[begin]]:
            end += 1
        for i in order[begin:end]:
            ranks[i] = begin + 1 + end
        begin = end
    return ranks


def wilcoxon(pairs):
    differences = signed_differences(pairs)
    ranks = doubled_ranks([abs(d) for d in differences])
    total = sum(ranks)
    if not ranks:
        return 1.0
    ways = [1] + [0] * total  # sign patterns by their sum of positive ranks
    for rank in ranks:
        for s in range(total, rank - 1, -1):
            ways[s] += ways[s - rank]
    positive = sum(rank for rank, d in zip(ranks, differences) if d > 0)
    tail = sum(ways[: min(positive, total - positive) + 1])
    return min(1.0, 2 * tail / 2 ** len(ranks))
