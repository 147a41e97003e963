"""Medians with failures, and pairs won.

Smaller wins; a failure is infinite, worse than any figure. Intervals and Wilcoxon's test are those of `aslio experiment`:
statistics.csv.
"""
import dataclasses
import math
import statistics

LEAST_PAIRS = 6  # with five pairs the smallest two-sided p is 0.0625


def median(values):
    """None of nothing; infinite when a middle value is."""
    return statistics.median(values) if values else None


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
