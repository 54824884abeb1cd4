//! Margins: by how much a metric may differ.

use super::compared_name;
use super::pair::SUCCESS;
use crate::settings::choice::NameError;

/// How far a metric may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Margin {
    /// In the unit of the metric; of success in percentage points.
    Amount(f64),
    /// As a share of the mean of the reference.
    Share(f64),
}

/// Margins of metrics, one at most for each that counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Margins(Vec<(&'static str, Margin)>);

/// Reason why a margin cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MarginError {
    /// A metric that is not compared.
    #[error(transparent)]
    Metric(#[from] NameError),
    /// A margin that is no number.
    #[error("the margin `{0}` is not of the form METRIC=VALUE or METRIC=VALUE%, with a value of at least 0")]
    Form(String),
    /// A margin that cannot make anything equivalent.
    #[error("`{0}`: a margin of equivalence is above 0, and of success below 100 percentage points")]
    Equivalence(String),
}

impl Margins {
    /// Reads margins as `METRIC=VALUE` or `METRIC=VALUE%`; the first of a metric counts.
    ///
    /// # Errors
    /// If a metric is not one that is compared, or a margin cannot be read.
    pub fn read(texts: &[String]) -> Result<Self, MarginError> {
        let margins = texts.iter().map(|text| {
            let refuse = || MarginError::Form(text.clone());
            let (name, value) = text.split_once('=').ok_or_else(refuse)?;
            let (number, is_share) = value.strip_suffix('%').map_or((value, false), |number| (number, true));
            let number: f64 = number.trim().parse().map_err(|_| refuse())?;
            if !(number.is_finite() && number >= 0.0) {
                return Err(refuse());
            }
            // Success is in percentage points already.
            let margin =
                if is_share && name != SUCCESS { Margin::Share(0.01 * number) } else { Margin::Amount(number) };
            Ok((compared_name(name)?, margin))
        });
        Ok(Self(margins.collect::<Result<_, MarginError>>()?))
    }

    /// Reads margins of equivalence, which are above 0.
    ///
    /// # Errors
    /// As [`read`](Self::read); also for a margin of 0 and one of success of 100 percentage points or more.
    pub fn of_equivalence(texts: &[String]) -> Result<Self, MarginError> {
        let margins = Self::read(texts)?;
        for ((metric, margin), text) in margins.0.iter().zip(texts) {
            let (Margin::Amount(number) | Margin::Share(number)) = *margin;
            if number == 0.0 || (*metric == SUCCESS && number >= 100.0) {
                return Err(MarginError::Equivalence(text.clone()));
            }
        }
        Ok(margins)
    }

    /// The margin of a metric whose mean in the reference is `mean`, in its unit; `None` if it has none.
    pub fn of(&self, metric: &str, mean: Option<f64>) -> Option<f64> {
        let (_, margin) = self.0.iter().find(|(name, _)| *name == metric)?;
        Some(match *margin {
            Margin::Amount(amount) => amount,
            Margin::Share(share) => share * mean.unwrap_or(0.0).abs(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(texts: &[&str]) -> Vec<String> {
        texts.iter().map(|text| (*text).to_owned()).collect()
    }

    #[test]
    fn margins_are_amounts_or_shares_of_the_mean_of_the_reference() {
        let margins = Margins::read(&texts(&["time_s=5%", "length_m=0.2", "success=2%"])).unwrap();
        assert_eq!((margins.of("time_s", Some(60.0)), margins.of("length_m", Some(9.0))), (Some(3.0), Some(0.2)));
        assert_eq!((margins.of("success", Some(98.0)), margins.of("clearance_min_m", Some(1.0))), (Some(2.0), None));
    }

    #[test]
    fn what_cannot_be_read_is_refused_with_what_was_meant() {
        let refused = |text: &str| Margins::read(&texts(&[text])).unwrap_err().to_string();
        assert!(refused("tme_s=3").contains("time_s"));
        for text in ["time_s", "time_s=fast", "time_s=-1", "time_s=inf"] {
            assert!(refused(text).contains("METRIC=VALUE"), "{text}");
        }
        for text in ["time_s=0", "time_s=0%", "success=100", "success=150%"] {
            let refused = Margins::of_equivalence(&texts(&[text])).unwrap_err();
            assert_eq!(refused, MarginError::Equivalence(text.to_owned()));
        }
        assert!(Margins::of_equivalence(&texts(&["success=5", "time_s=2%"])).is_ok());
    }
}
