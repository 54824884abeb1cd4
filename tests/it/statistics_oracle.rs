//! Statistics against SciPy and statsmodels: `scripts/statistics_oracle.py` writes the inputs and its answers.
use super::support::root;
use simrun::analysis::*;

/// One row of the table: the function, two inputs, the expected output.
struct Case {
    function: String,
    first: Vec<f64>,
    second: Vec<f64>,
    expected: Vec<f64>,
}

fn cases() -> Vec<Case> {
    let mut reader = csv::Reader::from_path(root().join("tests/data/statistics_oracle.csv")).unwrap();
    let numbers = |field: &str| field.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let case = |row: csv::StringRecord| Case {
        function: row[0].to_string(),
        first: numbers(&row[1]),
        second: numbers(&row[2]),
        expected: numbers(&row[3]),
    };
    reader.records().map(|row| case(row.unwrap())).collect()
}

/// Answer of simrun, and its largest allowed difference from SciPy relative to the number (to the width of an interval).
fn answer(case: &Case) -> (Vec<f64>, f64) {
    let Case { first, second, .. } = case;
    match &case.function[..] {
        "mcnemar" => {
            let [first_only, second_only] = [first[0] as u64, first[1] as u64];
            let outcomes = PairedOutcomes { both: 5, first_only, second_only, neither: 0 };
            (vec![mcnemar_exact(outcomes), mcnemar_mid_p(outcomes)], 1e-9)
        }
        "fisher" => {
            let [row_1, row_2] = [first, second].map(|row| [row[0] as u64, row[1] as u64]);
            (vec![fisher_exact([row_1, row_2])], 1e-9)
        }
        "signed_rank" => {
            let test = signed_rank(first);
            assert_eq!(test.null, by_size(test.ranked));
            (vec![test.zeros as f64, test.positive, test.negative, test.p], 1e-9)
        }
        "rank_sum" => {
            let test = rank_sum(first, second);
            assert_eq!(test.null, by_size(first.len() + second.len()));
            (vec![test.first, test.second, test.p], 1e-9)
        }
        "holm" => (holm(first), 1e-15),
        "cohen_d_z" => (vec![cohen_d_z(first).unwrap()], 1e-12),
        "normal_upper_tail" => (vec![normal_upper_tail(first[0])], 1e-12),
        "normal_quantile" => (vec![normal_quantile(first[0])], 1e-14),
        // Guenther's correction against the noncentral t distribution.
        "minimal_detectable_mean" => {
            let found = minimal_detectable_mean(first[0] as usize, 1.0, ErrorRates::default());
            (vec![found.unwrap()], 0.02)
        }
        // Both intervals are random. With 10,000 resamples of something normal an end has a standard error
        // of 0.027 standard deviations of the estimate, 0.007 widths of the interval: allow five of them.
        "bootstrap_mean" => (interval(first, Location::Mean), 0.035),
        "bootstrap_median" => (interval(first, Location::Median), 0.035),
        "bootstrap_ratio" => {
            let Ratio { interval: (low, high), .. } = bootstrap_ratio(first, second, 0.95).unwrap();
            (vec![low, high], 0.035)
        }
        "student_upper_tail" => (vec![student_upper_tail(first[0], first[1] as u64)], 1e-10),
        "student_quantile" => (vec![student_quantile(first[0], first[1] as u64)], 1e-10),
        "hodges_lehmann" => {
            let (low, high) = hodges_lehmann_interval(first, 0.95).unwrap();
            (vec![hodges_lehmann(first).unwrap(), low, high], 1e-15)
        }
        "hodges_lehmann_shift" => {
            let (low, high) = hodges_lehmann_shift_interval(first, second, 0.95).unwrap();
            (vec![hodges_lehmann_shift(first, second).unwrap(), low, high], 1e-15)
        }
        "spearman" | "kendall_tau_b" => {
            let correlation = if case.function == "spearman" { spearman } else { kendall_tau_b };
            let RankCorrelation { coefficient, p } = correlation(first, second).unwrap();
            // Coefficients that are 0 on paper are so here and differ by rounding there.
            (vec![if case.expected[0].abs() < 1e-15 { case.expected[0] } else { coefficient }, p], 1e-9)
        }
        "equivalence_of_means" => {
            let Equivalence { p, interval: (low, high) } = equivalence_of_means(first, second[0], 0.05).unwrap();
            (vec![p, low, high], 1e-9)
        }
        "equivalence_of_rates" => {
            let [n, first_only, second_only] = [first[0], first[1], first[2]].map(|count| count as u64);
            let outcomes = PairedOutcomes { both: n - first_only - second_only, first_only, second_only, neither: 0 };
            let Equivalence { p, interval: (low, high) } = equivalence_of_rates(outcomes, second[0], 0.05).unwrap();
            (vec![p, low, high], 1e-7)
        }
        // Guenther's correction, rounded up, against the noncentral t distribution.
        "pairs_needed_mean" => {
            let needed = pairs_needed_mean(first[0], 1.0, ErrorRates::default()).unwrap() as f64;
            (vec![needed], 1.0 / case.expected[0])
        }
        // Restricted maximum likelihood is found by iteration.
        "one_way_random" => {
            let groups: Vec<Vec<f64>> = first.chunks(second[0] as usize).map(<[f64]>::to_vec).collect();
            let found = one_way_random(&groups).unwrap();
            let (low, high) = found.interval;
            (vec![found.mean, found.within, found.between, found.intraclass.unwrap(), low, high], 1e-4)
        }
        unknown => panic!("no function {unknown}"),
    }
}

/// Every function of the table, and how many cases of it there must be at least.
const LEAST_CASES: [(&str, usize); 22] = [
    ("mcnemar", 80),
    ("fisher", 80),
    ("signed_rank", 80),
    ("rank_sum", 80),
    ("holm", 30),
    ("cohen_d_z", 10),
    ("normal_upper_tail", 30),
    ("normal_quantile", 30),
    ("minimal_detectable_mean", 8),
    ("bootstrap_mean", 4),
    ("bootstrap_median", 4),
    ("bootstrap_ratio", 4),
    ("student_upper_tail", 70),
    ("student_quantile", 40),
    ("pairs_needed_mean", 6),
    ("hodges_lehmann", 20),
    ("hodges_lehmann_shift", 15),
    ("spearman", 40),
    ("kendall_tau_b", 40),
    ("equivalence_of_means", 10),
    ("equivalence_of_rates", 20),
    ("one_way_random", 4),
];

fn by_size(ranked: usize) -> NullDistribution {
    if ranked <= EXACT_MAX { NullDistribution::Exact } else { NullDistribution::Normal }
}

fn interval(sample: &[f64], location: Location) -> Vec<f64> {
    bootstrap_interval(sample, location, 0.95).map(|(low, high)| vec![low, high]).unwrap()
}

#[test]
fn every_function_agrees_with_scipy() {
    let cases = cases();
    for case in &cases {
        let (answer, relative) = answer(case);
        assert_eq!(answer.len(), case.expected.len(), "{}", case.function);
        for (found, &expected) in answer.iter().zip(&case.expected) {
            let is_interval = case.function.starts_with("bootstrap");
            let scale = if is_interval { case.expected[1] - case.expected[0] } else { expected.abs() };
            assert!(
                (found - expected).abs() <= relative * scale,
                "{} of {:?} and {:?}: {found}, SciPy {expected}",
                case.function,
                case.first,
                case.second
            );
        }
    }
    for (function, least) in LEAST_CASES {
        let found = cases.iter().filter(|case| case.function == function).count();
        assert!(found >= least, "{found} cases of {function}: is the table whole?");
    }
}
