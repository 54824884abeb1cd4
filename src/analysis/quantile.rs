//! Exact quantiles of a sample.

/// The quantile of a sorted sample by linear interpolation; `None` for an empty sample.
///
/// Type 7 of R. J. Hyndman and Y. Fan, *Sample quantiles in statistical packages*, The American
/// Statistician 50, 1996 (the default of R and NumPy): with h = (n − 1) p, the value between
/// the order statistics ⌊h⌋ and ⌊h⌋ + 1 (counted from 0) at the fraction h − ⌊h⌋.
///
/// # Panics
/// If `p` is outside [0, 1] or the sample is not in ascending order.
pub fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    assert!((0.0..=1.0).contains(&p), "quantile {p}");
    assert!(sorted.is_sorted(), "the sample is not sorted");
    let last = sorted.len().checked_sub(1)?;
    let h = last as f64 * p;
    let below = h.floor();
    let index = below as usize;
    let low = sorted[index];
    let high = sorted[last.min(index + 1)];
    Some(low + (h - below) * (high - low))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_numbers_worked_by_hand() {
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[7.0], 0.25), Some(7.0));
        let sample = [1.0, 2.0, 4.0, 8.0];
        // h = 3 · 0.25 = 0.75: 1 + 0.75 · (2 − 1); h = 1.5: 2 + 0.5 · 2; h = 2.25: 4 + 0.25 · 4.
        assert_eq!(quantile(&sample, 0.25), Some(1.75));
        assert_eq!(quantile(&sample, 0.5), Some(3.0));
        assert_eq!(quantile(&sample, 0.75), Some(5.0));
        assert_eq!((quantile(&sample, 0.0), quantile(&sample, 1.0)), (Some(1.0), Some(8.0)));
    }
}
