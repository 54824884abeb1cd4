# /// script
# requires-python = ">=3.11"
# dependencies = ["scipy==1.17.1", "statsmodels==0.15.0"]
# ///
"""Writes tests/data/statistics_oracle.csv: what SciPy says to inputs that tests/it/statistics_oracle.rs repeats.

    uv run scripts/statistics_oracle.py > tests/data/statistics_oracle.csv

Columns: the function; two inputs and the expected output, each a list of numbers separated by blanks. Numbers are
written so that reading them gives the same float. Where SciPy answers another question than simrun (exact tests with
ties beyond its limits), the numbers come from enumerating every outcome, in this file. The seed is fixed.
"""

import csv
import itertools
import math
import sys

import numpy as np
from scipy import stats
from statsmodels.stats.multitest import multipletests

RNG = np.random.default_rng(20240607)
OUT = csv.writer(sys.stdout, lineterminator="\n")


def numbers(values):
    return " ".join(repr(int(v)) if float(v).is_integer() and abs(v) < 1e15 else repr(float(v)) for v in np.ravel(values))


def row(function, first, second, expected):
    OUT.writerow([function, numbers(first), numbers(second), numbers(expected)])


def mcnemar():
    cases = [(b, c) for b in range(6) for c in range(6)]
    cases += [tuple(RNG.integers(0, top, 2)) for top in (20, 60, 300, 3000) for _ in range(12)]
    for b, c in cases:
        n, m = int(b + c), int(min(b, c))
        p = stats.binomtest(m, n, 0.5).pvalue if n else 1.0
        point = stats.binom.pmf(m, n, 0.5) if n else 0.0
        row("mcnemar", [b, c], [], [p, 1 - point / 2 if b == c else p - point])


def fisher():
    cases = [RNG.integers(0, top, 4) for top in (4, 8, 20, 60, 400) for _ in range(16)]
    for a, b, c, d in cases:
        row("fisher", [a, b], [c, d], [stats.fisher_exact([[a, b], [c, d]]).pvalue])


def samples(sizes, repeats):
    """Lists of numbers in turn without ties, with many ties, and with few; shifted at random."""
    for size in sizes:
        for repeat in range(repeats):
            shift = RNG.choice([0.0, 0.3, 1.0])
            values = RNG.normal(shift, 1.0, size)
            yield (values if repeat % 3 == 0 else np.round(values * (2.0 if repeat % 3 == 1 else 10.0))), repeat % 3


def sign_patterns(ranks):
    """The sum of positive ranks for every pattern of signs: 2 to the power of the number of ranks."""
    sums = np.zeros(1)
    for rank in ranks:
        sums = np.concatenate([sums, sums + rank])
    return sums


def signed_rank():
    for differences, kind in samples([1, 2, 3, 5, 8, 12, 16, 19], 9):
        kept = differences[differences != 0.0]
        ranks = stats.rankdata(np.abs(kept))
        plus, minus = ranks[kept > 0].sum(), ranks[kept < 0].sum()
        sums = sign_patterns(ranks)
        p = min(1.0, 2.0 * np.mean(sums <= min(plus, minus)))
        if kind == 0:
            assert math.isclose(p, stats.wilcoxon(differences, method="exact").pvalue, rel_tol=1e-12)
        if 2 <= len(kept) <= 8:
            every = stats.PermutationMethod(n_resamples=np.inf)
            assert math.isclose(p, stats.wilcoxon(kept, method=every).pvalue, rel_tol=1e-12)
        row("signed_rank", differences, [], [len(differences) - len(kept), plus, minus, p])
    for differences, _ in samples([26, 35, 50], 1):
        plus = stats.wilcoxon(differences, alternative="greater", method="exact")
        total = len(differences) * (len(differences) + 1) / 2
        p = stats.wilcoxon(differences, method="exact").pvalue
        row("signed_rank", differences, [], [0, plus.statistic, total - plus.statistic, p])
    for differences, _ in samples([70, 120], 6):
        kept = differences[differences != 0.0]
        assert len(kept) > 50
        ranks = stats.rankdata(np.abs(kept))
        plus, minus = ranks[kept > 0].sum(), ranks[kept < 0].sum()
        # SciPy corrects beyond the mean where the sum is within one half of it: never here.
        assert abs(plus - minus) / 2 > 0.5
        p = stats.wilcoxon(differences, method="asymptotic", correction=True).pvalue
        row("signed_rank", differences, [], [len(differences) - len(kept), plus, minus, p])


def rank_sum():
    for first, kind in samples([1, 2, 3, 5, 7, 9], 12):
        second = RNG.normal(0.0, 1.0, RNG.integers(1, 9))
        second = second if kind == 0 else np.round(second * (2.0 if kind == 1 else 10.0))
        u = stats.mannwhitneyu(first, second).statistic
        # Every choice of the ranks that the first sample could have had.
        ranks = stats.rankdata(np.concatenate([first, second]))
        sums = np.array([sum(chosen) for chosen in itertools.combinations(ranks, len(first))])
        observed = ranks[: len(first)].sum()
        p = min(1.0, 2.0 * min(np.mean(sums <= observed), np.mean(sums >= observed)))
        if kind == 0:
            assert math.isclose(p, stats.mannwhitneyu(first, second, method="exact").pvalue, rel_tol=1e-12)
        elif min(len(first), len(second)) >= 2 and len(ranks) <= 10:
            every = stats.PermutationMethod(n_resamples=np.inf)
            assert math.isclose(p, stats.mannwhitneyu(first, second, method=every).pvalue, rel_tol=1e-12)
        row("rank_sum", first, second, [u, len(first) * len(second) - u, p])
    for first, _ in samples([20, 25], 1):
        second = RNG.normal(0.5, 1.0, 25)
        u = stats.mannwhitneyu(first, second).statistic
        row("rank_sum", first, second, [u, len(first) * 25 - u, stats.mannwhitneyu(first, second, method="exact").pvalue])
    for first, kind in samples([30, 60], 6):
        second = RNG.normal(0.0, 1.0, RNG.integers(25, 40))
        second = second if kind == 0 else np.round(second * (2.0 if kind == 1 else 10.0))
        u = stats.mannwhitneyu(first, second).statistic
        p = stats.mannwhitneyu(first, second, method="asymptotic", use_continuity=True).pvalue
        row("rank_sum", first, second, [u, len(first) * len(second) - u, p])


def holm():
    for count in (1, 2, 3, 6, 10, 45):
        for _ in range(5):
            p = np.round(RNG.uniform(0, 1, count) ** 3, 4)
            row("holm", p, [], multipletests(p, method="holm")[1])


def cohen_d_z():
    for differences, _ in samples([2, 3, 10, 50], 3):
        if np.ptp(differences) > 0:
            row("cohen_d_z", differences, [], [differences.mean() / differences.std(ddof=1)])


def normal():
    for z in np.concatenate([RNG.uniform(-8, 8, 30), [0.0, 15.0, 37.0]]):
        row("normal_upper_tail", [z], [], [stats.norm.sf(z)])
    for p in np.concatenate([RNG.uniform(0, 1, 20), 10.0 ** RNG.uniform(-250, -1, 10)]):
        row("normal_quantile", [p], [], [stats.norm.ppf(p)])


def minimal_detectable_mean():
    """The difference that the paired t test finds with 80 % power at 5 %, by the noncentral t distribution."""
    for pairs in (8, 10, 15, 20, 30, 50, 100, 1000):
        def power(delta):
            t = stats.t.isf(0.025, pairs - 1)
            centre = delta * math.sqrt(pairs)
            return stats.nct.sf(t, pairs - 1, centre) + stats.nct.cdf(-t, pairs - 1, centre)

        low, high = 0.0, 5.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if power(middle) < 0.8 else (low, middle)
        row("minimal_detectable_mean", [pairs], [], [low])


def bootstrap():
    """Percentile intervals from ten times as many resamples as simrun draws."""
    for function, statistic in (("bootstrap_mean", np.mean), ("bootstrap_median", np.median)):
        for size in (12, 25, 40, 100):
            values = RNG.gamma(2.0, 1.5, size)
            result = stats.bootstrap((values,), statistic, n_resamples=100_000, batch=2000, method="percentile", rng=RNG)
            row(function, values, [], result.confidence_interval)


def main():
    OUT.writerow(["function", "first", "second", "expected"])
    for part in (mcnemar, fisher, signed_rank, rank_sum, holm, cohen_d_z, normal, minimal_detectable_mean, bootstrap):
        part()


if __name__ == "__main__":
    main()
