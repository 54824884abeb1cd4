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
import pandas as pd
import statsmodels.formula.api as smf
from scipy import optimize, stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.power import TTestPower
from statsmodels.stats.weightstats import ttost_paired

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


def student():
    for freedom in (1, 2, 3, 4, 7, 10, 29, 30, 99, 1000, 99_999):
        for t in np.concatenate([RNG.uniform(-4, 4, 4), [0.0, 12.0, 40.0]]):
            row("student_upper_tail", [t, freedom], [], [stats.t.sf(t, freedom)])
        for p in (0.025, 0.3, 0.95, 1e-9):
            row("student_quantile", [p, freedom], [], [stats.t.ppf(p, freedom)])


def rejected(p_value, at):
    """Whether the test of the numbers shifted by `at` is significant at 5 %."""
    return p_value(at) <= 0.05


def assert_inverts(p_value, low, high):
    """The interval holds exactly the shifts that the test does not reject (looked at beside its ends)."""
    gap = 1e-7 * (high - low)
    assert rejected(p_value, low - gap) and not rejected(p_value, low + gap)
    assert rejected(p_value, high + gap) and not rejected(p_value, high - gap)


def hodges_lehmann():
    """Walsh averages written out; the ends of the interval are checked by inverting SciPy's test where nothing ties."""
    for differences, kind in samples([6, 7, 8, 12, 25, 50, 51, 90, 301], 3):
        n = len(differences)
        walsh = np.sort([(differences[i] + differences[j]) / 2 for i in range(n) for j in range(i, n)])
        # The largest sum of ranks that is rejected on the lower side, from the law of the sum without ties.
        if n <= 50:
            ways = np.array([1.0])
            for rank in range(1, n + 1):
                ways = np.convolve(ways, np.concatenate([[1.0], np.zeros(rank - 1), [1.0]]))
            worst = int(np.flatnonzero(2 * np.cumsum(ways) / 2.0**n <= 0.05).max())
            method = {"method": "exact"}
        else:
            sd = math.sqrt(n * (n + 1) * (2 * n + 1) / 24)
            worst = math.floor(n * (n + 1) / 4 - 0.5 - stats.norm.isf(0.025) * sd)
            method = {"method": "asymptotic", "correction": True}
        low, high = walsh[worst], walsh[len(walsh) - 1 - worst]
        if kind == 0:
            assert_inverts(lambda at: stats.wilcoxon(differences - at, **method).pvalue, low, high)
        row("hodges_lehmann", differences, [], [np.median(walsh), low, high])


def hodges_lehmann_shift():
    for first, kind in samples([5, 9, 20, 24, 40, 120], 3):
        size = RNG.integers(4, 27) if len(first) < 40 else RNG.integers(30, 200)
        second = RNG.normal(0.4, 1.3, size)
        second = second if kind == 0 else np.round(second * (2.0 if kind == 1 else 10.0))
        shifts = np.sort(np.subtract.outer(first, second).ravel())
        m, n = len(first), len(second)
        if m + n <= 50:
            # U of every split without ties, by the recurrence over the largest number: it is in one sample or the other.
            counts = {}

            def ways(a, b):
                if a == 0 or b == 0:
                    return np.ones(1)
                if (a, b) not in counts:
                    total = np.zeros(a * b + 1)
                    with_a, with_b = ways(a - 1, b), ways(a, b - 1)
                    total[b : b + len(with_a)] += with_a
                    total[: len(with_b)] += with_b
                    counts[a, b] = total
                return counts[a, b]

            law = ways(m, n)
            worst = int(np.flatnonzero(2 * np.cumsum(law) / law.sum() <= 0.05).max())
            method = {"method": "exact"}
        else:
            sd = math.sqrt(m * n * (m + n + 1) / 12)
            worst = math.floor(m * n / 2 - 0.5 - stats.norm.isf(0.025) * sd)
            method = {"method": "asymptotic", "use_continuity": True}
        low, high = shifts[worst], shifts[len(shifts) - 1 - worst]
        if kind == 0:
            assert_inverts(lambda at: stats.mannwhitneyu(first - at, second, **method).pvalue, low, high)
        row("hodges_lehmann_shift", first, second, [np.median(shifts), low, high])


def two_sided(every, observed):
    return min(1.0, 2 * min(np.mean(every <= observed + 1e-9), np.mean(every >= observed - 1e-9)))


def correlations():
    for first, kind in samples([3, 4, 5, 7, 9, 10, 15, 40, 100], 6):
        second = 0.4 * first + RNG.normal(0.0, 1.0, len(first))
        second = second if kind == 0 else np.round(second * (2.0 if kind == 1 else 10.0))
        if np.ptp(first) == 0 or np.ptp(second) == 0:
            continue
        rho, tau = stats.spearmanr(first, second), stats.kendalltau(first, second, method="asymptotic")
        p_rho, p_tau = rho.pvalue, tau.pvalue
        if len(first) <= 9:
            # Every pairing; SciPy enumerates them too, slowly.
            orders = np.array(list(itertools.permutations(range(len(first)))))
            ranks = stats.rankdata(second)
            sums = ranks[orders] @ stats.rankdata(first)
            p_rho = two_sided(sums, ranks @ stats.rankdata(first))
            signs = [np.sign(np.subtract.outer(values, values)).astype(int) for values in (first, second)]
            counts = np.zeros(len(orders), dtype=int)
            for i, j in itertools.combinations(range(len(first)), 2):
                counts += signs[0][i, j] * signs[1][orders[:, i], orders[:, j]]
            p_tau = two_sided(counts, np.triu(signs[0] * signs[1]).sum())
        if len(first) <= 5:
            for p, statistic in ((p_rho, stats.spearmanr), (p_tau, stats.kendalltau)):
                test = stats.permutation_test(
                    (first,),
                    lambda x: statistic(x, second).statistic,
                    permutation_type="pairings",
                    n_resamples=np.inf,
                    vectorized=False,
                )
                assert math.isclose(p, test.pvalue, rel_tol=1e-12)
        row("spearman", first, second, [rho.statistic, p_rho])
        row("kendall_tau_b", first, second, [tau.statistic, p_tau])


def bootstrap_ratio():
    def ratio(first, second, axis):
        return np.mean(first, axis=axis) / np.mean(second, axis=axis)

    for size in (12, 25, 60, 150):
        second = RNG.gamma(6.0, 4.0, size)
        first = second * RNG.normal(0.95, 0.2, size)
        result = stats.bootstrap(
            (first, second), ratio, paired=True, n_resamples=100_000, batch=2000, method="percentile", rng=RNG
        )
        row("bootstrap_ratio", first, second, result.confidence_interval)


def equivalence_of_means():
    for size in (2, 3, 8, 30, 200):
        for margin in (0.2, 1.0):
            first = RNG.normal(10.0, 2.0, size)
            second = first + RNG.normal(0.1, 0.5, size)
            p = ttost_paired(first, second, -margin, margin)[0]
            interval = stats.ttest_1samp(first - second, 0.0).confidence_interval(0.9)
            row("equivalence_of_means", first - second, [margin], [p, *interval])


def equivalence_of_rates():
    """Score tests of a difference of paired rates: the rates under a margin maximise the likelihood numerically."""

    def score(n, b, c, delta):
        # Free: what both rates of pairs that one side alone solved have beyond the least that the difference asks for.
        least_first, least_second = max(0.0, delta), max(0.0, -delta)

        def slope(u):
            up = b / (least_first + u) if b else 0.0
            down = c / (least_second + u) if c else 0.0
            return up + down - 2 * (n - b - c) / (1 - abs(delta) - 2 * u)

        high = (1 - abs(delta)) / 2
        low, high = 1e-15 * high, (1 - 1e-12) * high
        u = optimize.brentq(slope, low, high, xtol=1e-18, rtol=1e-14) if slope(low) > 0 else 0.0
        q = least_second + u
        variance = n * (2 * q + delta - delta * delta)
        return (b - c - n * delta) / math.sqrt(variance)

    for n, b, c in [(20, 0, 0), (50, 3, 1), (50, 0, 4), (100, 10, 10), (100, 7, 2), (1000, 30, 41), (1000, 0, 1)]:
        low = optimize.brentq(lambda d: score(n, b, c, d) - stats.norm.isf(0.05), -0.999, (b - c) / n - 1e-12)
        high = optimize.brentq(lambda d: score(n, b, c, d) + stats.norm.isf(0.05), (b - c) / n + 1e-12, 0.999)
        for margin in (0.02, 0.05, 0.1):
            p = max(stats.norm.sf(score(n, b, c, -margin)), stats.norm.cdf(score(n, b, c, margin)))
            row("equivalence_of_rates", [n, b, c], [margin], [p, low, high])


def pairs_needed_mean():
    for effect in (0.05, 0.1, 0.3, 0.5, 0.8, 1.2):
        pairs = TTestPower().solve_power(effect_size=effect, alpha=0.05, power=0.8)
        row("pairs_needed_mean", [effect], [], [pairs])


def one_way_random():
    """Balanced groups, one after the other; `second` holds their size."""
    for groups, size, spread in [(4, 5, 2.0), (6, 10, 0.8), (12, 8, 1.5), (30, 4, 1.0)]:
        values = 5.0 + RNG.normal(0.0, spread, (groups, 1)) + RNG.normal(0.0, 1.0, (groups, size))
        table = pd.DataFrame({"value": values.ravel(), "group": np.repeat(np.arange(groups), size)})
        fit = smf.mixedlm("value ~ 1", table, groups=table["group"]).fit(reml=True, method="powell", ftol=1e-14)
        within, between = fit.scale, float(fit.cov_re.iloc[0, 0])
        assert between > 0.0
        interval = stats.ttest_1samp(values.mean(axis=1), 0.0).confidence_interval(0.95)
        expected = [fit.fe_params.iloc[0], within, between, between / (between + within), *interval]
        row("one_way_random", values, [size], expected)


def main():
    OUT.writerow(["function", "first", "second", "expected"])
    for part in (mcnemar, fisher, signed_rank, rank_sum, holm, cohen_d_z, normal, minimal_detectable_mean, bootstrap):
        part()
    # Later ones at the end: what stands above draws the same numbers as ever.
    for part in (
        student,
        hodges_lehmann,
        hodges_lehmann_shift,
        correlations,
        bootstrap_ratio,
        equivalence_of_means,
        equivalence_of_rates,
        pairs_needed_mean,
        one_way_random,
    ):
        part()


if __name__ == "__main__":
    main()
