//! A number with its interval.

use serde::{Deserialize, Serialize};

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimate.
    #[serde(deserialize_with = "or_not_a_number")]
    pub value: f64,
    /// Lower end of the interval.
    #[serde(deserialize_with = "or_not_a_number")]
    pub low: f64,
    /// Upper end of the interval.
    #[serde(deserialize_with = "or_not_a_number")]
    pub high: f64,
}

/// JSON has no word for a number that is none but `null`.
pub fn or_not_a_number<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

impl Estimate {
    /// An estimate with a symmetric interval.
    pub fn around(value: f64, half: f64) -> Self {
        Self { value, low: value - half, high: value + half }
    }

    /// Whether the interval holds a value.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_holds_its_ends_and_what_lies_between() {
        let one = Estimate::around(1.0, 0.5);
        assert!([0.5, 1.0, 1.5].iter().all(|&value| one.contains(value)));
        assert!(![0.4, 1.6, f64::NAN].iter().any(|&value| one.contains(value)));
    }

    /// A number that is none becomes `null` in a file, and is none again when the file is read.
    #[test]
    fn estimates_are_the_same_when_they_are_read_again() {
        let written = serde_json::json!(Estimate::around(2.5, f64::NAN));
        assert_eq!(written, serde_json::json!({ "value": 2.5, "low": null, "high": null }));
        let read: Estimate = serde_json::from_value(written).unwrap();
        assert_eq!(read.value, 2.5);
        assert!(read.low.is_nan() && read.high.is_nan());
        let wrong = serde_json::json!({ "value": "much", "low": 0.0, "high": 1.0 });
        assert!(serde_json::from_value::<Estimate>(wrong).is_err());
    }
}
