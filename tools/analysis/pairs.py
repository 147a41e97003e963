"""Medians with failures, and pairs won.

Smaller wins; a failure is infinite, worse than any figure. Intervals and Wilcoxon's test are those of `aslio experiment`:
statistics.csv.
"""
import dataclasses
import math
import statistics

from numerics import np

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


LOST = math.log(2)


def log_ratio(error, base):
    """Of two errors above 0. A lost run counts as twice the error of the other; None where both are lost."""
    if math.isinf(error) and math.isinf(base):
        return None
    if math.isinf(error):
        return LOST
    return -LOST if math.isinf(base) else math.log(error / base)


def students_t(share, degrees):
    """Quantile of Student's t distribution, share above 0.5: by bisection of the integral of its density."""
    scale = math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(degrees * math.pi)

    def below(x):
        t = np.linspace(0, x, 4001)
        density = scale * (1 + t * t / degrees) ** (-(degrees + 1) / 2)
        return 0.5 + x / 12000 * (density[0] + 4 * density[1::2].sum() + 2 * density[2:-1:2].sum() + density[-1])

    low, high = 0.0, 100.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if below(middle) < share else (low, middle)
    return (low + high) / 2
