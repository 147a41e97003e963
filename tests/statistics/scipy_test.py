"""The framework's statistics against SciPy, on samples of every kind: small, large, tied, with zeros.

usage: scipy_test.py PROGRAM    (the one made from samples.cpp)
"""
import subprocess
import sys
import unittest
import warnings

import numpy
import scipy.stats

PROGRAM = sys.argv.pop()
LEAST_PAIRS, MOST_EXACT = 6, 25


def samples():
    draw = numpy.random.default_rng(20260101)
    for size in (*range(1, 31), 60, 200):
        for spread in (0.2, 1.0):
            yield draw.normal(spread, 1.0, size)
            yield draw.integers(-4, 6, size).astype(float)
            yield numpy.round(draw.normal(0.3, 1.0, size), 1)
            yield numpy.exp(draw.normal(0, 2, size)) - 1


def wilcoxon(values, exact):
    counted = values[values != 0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return scipy.stats.wilcoxon(counted, method="exact" if exact else "approx", correction=not exact)


def enumerated(magnitudes, up):
    """Two-sided p of a rank sum by the share of all signs, one rank after the other."""
    shares = {0.0: 1.0}
    for rank in scipy.stats.rankdata(magnitudes):
        grown = dict.fromkeys([*shares, *(s + rank for s in shares)], 0.0)
        for s, share in shares.items():
            grown[s] += 0.5 * share
            grown[s + rank] += 0.5 * share
        shares = grown
    smaller = min(up, sum(scipy.stats.rankdata(magnitudes)) - up)
    return min(1.0, 2 * sum(share for s, share in shares.items() if s <= smaller + 1e-9))


def holm(p):
    """By the definition, with SciPy's ranks."""
    order = scipy.stats.rankdata(p, method="ordinal").astype(int) - 1
    scaled = numpy.empty(len(p))
    scaled[order] = p
    stepped = numpy.maximum.accumulate(numpy.minimum(1, scaled * (len(p) - numpy.arange(len(p)))))
    return stepped[order]


class Statistics(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.samples = list(samples())
        text = "\n".join(" ".join(repr(float(v)) for v in sample) for sample in cls.samples) + "\n"
        lines = subprocess.run([PROGRAM], input=text, capture_output=True, text=True, check=True).stdout.splitlines()
        cls.rows = [[float(word) for word in line.split()] for line in lines[:len(cls.samples)]]
        cls.corrected = [float(line) for line in lines[len(cls.samples):]]

    def test_signed_rank(self):
        compared = {"exact": 0, "tied": 0, "many": 0}
        for sample, (exact, p, up, down, *_) in zip(self.samples, self.rows):
            if len(sample) < LEAST_PAIRS:
                self.assertEqual(p, -1)
                continue
            counted = numpy.abs(sample[sample != 0])
            few = len(counted) <= MOST_EXACT
            self.assertEqual(bool(exact), few)
            if not len(counted):
                self.assertEqual(p, 1)
                continue
            tied = len(set(counted)) < len(counted)
            theirs = wilcoxon(sample, few and not tied)
            self.assertAlmostEqual(min(up, down), theirs.statistic, delta=1e-9)
            # SciPy's own test of few ties is the approximation: theirs is the ranks, the counting is done here.
            self.assertAlmostEqual(p, enumerated(counted, up) if few and tied else theirs.pvalue, delta=1e-12)
            compared["tied" if few and tied else "exact" if few else "many"] += 1
        self.assertGreater(compared["exact"], 50)
        self.assertGreater(compared["tied"], 50)
        self.assertGreater(compared["many"], 20)

    def test_quantiles(self):
        for sample, row in zip(self.samples, self.rows):
            numpy.testing.assert_allclose(row[4:6], numpy.quantile(sample, [0.25, 0.5]), rtol=1e-12, atol=1e-15)

    def test_bootstrap(self):
        # Two random choices of resamples: the bounds agree within a few of the sample's steps.
        for sample, row in zip(self.samples, self.rows):
            if len(sample) not in (20, 60, 200):
                continue
            theirs = scipy.stats.bootstrap((sample,), numpy.median, n_resamples=5000, method="percentile",
                                           random_state=3).confidence_interval
            tolerance = 0.1 * (theirs.high - theirs.low) + 1e-12
            self.assertAlmostEqual(row[6], theirs.low, delta=tolerance)
            self.assertAlmostEqual(row[7], theirs.high, delta=tolerance)

    def test_holm(self):
        p = numpy.array([row[1] for row in self.rows])
        known = p >= 0
        numpy.testing.assert_allclose(numpy.array(self.corrected)[known], holm(p[known]), rtol=1e-12)
        self.assertTrue((numpy.array(self.corrected)[~known] == -1).all())


if __name__ == "__main__":
    unittest.main(verbosity=2)
