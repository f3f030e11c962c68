//! The part of a run that a criterion looks at.

use serde::Deserialize;

use fmu_import::quantity::{Quantity, to_own};

/// A window as the study writes it: `window = 10`, or `window = { from = "140 s", to = "150 s" }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "`window` is a time at the end of the run, such as \"10 s\", or { from = \"140 s\", to = \"150 s\" }"
)]
pub enum Window {
    /// The last so many seconds.
    Last(Quantity),
    /// Between two times; either may be missing.
    Between(Limits),
}

/// The ends of a window.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Where it begins; the start of the run otherwise.
    pub from: Option<Quantity>,
    /// Where it ends; the end of the run otherwise.
    pub to: Option<Quantity>,
}

impl Window {
    /// Its two times, s, in a run between two others.
    ///
    /// # Errors
    /// When a unit is none of time, or the window is not inside the run.
    pub fn times(&self, [start, stop]: [f64; 2]) -> Result<[f64; 2], String> {
        let [from, to] = match self {
            Self::Last(length) => [stop - seconds(length)?, stop],
            Self::Between(Limits { from, to }) => {
                let time = |limit: &Option<Quantity>, otherwise: f64| limit.as_ref().map_or(Ok(otherwise), seconds);
                [time(from, start)?, time(to, stop)?]
            }
        };
        // Times that are no numbers compare as false.
        if from >= start && from <= to && to <= stop {
            return Ok([from, to]);
        }
        Err(format!("the window from {from} s to {to} s must lie between start and stop, {start} s and {stop} s"))
    }
}

/// A time in seconds.
pub fn seconds(quantity: &Quantity) -> Result<f64, String> {
    Ok(to_own(quantity.unit.as_deref().unwrap_or("s"), "s")?.value(quantity.number))
}

/// Reads a time: a number of seconds, or a text with a unit such as `2 ms`.
pub fn time<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    let time = Quantity::deserialize(from)?;
    seconds(&time).map(Some).map_err(serde::de::Error::custom)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(text: &str) -> Result<[f64; 2], String> {
        #[derive(Deserialize)]
        struct Text {
            window: Window,
        }
        let text: Result<Text, _> = toml::from_str(&format!("window = {text}"));
        text.map_err(|error| error.to_string())?.window.times([0.0, 150.0])
    }

    #[test]
    fn windows_are_absolute_or_at_the_end() {
        for (text, expected) in [
            ("10", [140.0, 150.0]),
            ("\"10 s\"", [140.0, 150.0]),
            ("\"2 min\"", [30.0, 150.0]),
            ("{ from = \"140 s\", to = \"145 s\" }", [140.0, 145.0]),
            ("{ from = 100 }", [100.0, 150.0]),
            ("{ to = 20.5 }", [0.0, 20.5]),
        ] {
            assert_eq!(times(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn windows_that_make_no_sense_are_refused() {
        for (text, words) in [
            ("200", "must lie between"),
            ("-1", "must lie between"),
            ("{ from = 20, to = 10 }", "must lie between"),
            ("{ from = \"2 m\" }", "no unit of time"),
            ("{ until = 3 }", "`window` is a time"),
            ("true", "`window` is a time"),
        ] {
            let error = times(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
