//! Metrics: two curves as one number.
//!
//! A new metric is a file beside `rmse` with a function, its `mod` line, and its line in `metrics!` below. The name in a study and the JSON Schema follow from that line.

mod area;
mod corridor;
pub mod iso18571;
mod max_error;
mod nrmse;
mod rmse;

use serde::{Deserialize, Serialize};

/// A measured and a simulated curve at the same times.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// The measured values.
    pub reference: &'a [f64],
    /// The model's values at the same times, as many.
    pub model: &'a [f64],
    /// The half width of the corridor at these times; for [`Metric::Corridor`] only.
    pub band: &'a [f64],
    /// By what [`Metric::Nrmse`] divides, in the unit of the values.
    pub normaliser: f64,
}

impl<'a> Pair<'a> {
    /// A pair without a corridor, and with a normaliser of 1.
    pub fn new(reference: &'a [f64], model: &'a [f64]) -> Self {
        Self { reference, model, band: &[], normaliser: 1.0 }
    }

    /// The model's deviations from the reference.
    fn deviations(&self) -> impl Iterator<Item = f64> + '_ {
        self.model.iter().zip(self.reference).map(|(m, r)| m - r)
    }
}

/// How a metric's numbers are to be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// An error in the unit of the curves; 0 is the best.
    Error,
    /// An error without a unit; 0 is the best.
    Relative,
    /// A share or a rating from 0 to 1; 1 is the best.
    Rating,
}

/// Makes the choice of the metrics from lines of name, function, kind, name in a sentence and meaning. The function gets
/// finite values, as many of the model as of the reference, and at least one.
macro_rules! metrics {
    ($($metric:ident = $compare:path, $kind:ident, $label:literal, $meaning:literal;)*) => {
        /// A measure of how well a simulated curve agrees with a measured one.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Metric {
            $(#[doc = $meaning] $metric,)*
        }

        impl Metric {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$metric),*];

            /// Its name in a sentence, such as "rmse" in "rmse of the torque".
            pub fn label(self) -> &'static str {
                match self {
                    $(Self::$metric => $label,)*
                }
            }

            /// How its numbers are to be read.
            pub fn kind(self) -> Kind {
                match self {
                    $(Self::$metric => Kind::$kind,)*
                }
            }

            fn number(self, pair: &Pair) -> f64 {
                match self {
                    $(Self::$metric => $compare(pair),)*
                }
            }
        }
    };
}

metrics! {
    Rmse = rmse::rmse, Error, "rmse", "The root of the mean square of the deviations.";
    Nrmse = nrmse::nrmse, Relative, "normalised rmse", "The same, divided by a normaliser.";
    MaxError = max_error::max_error, Error, "largest deviation", "The largest deviation.";
    Corridor = corridor::corridor, Rating, "share inside the corridor",
        "The share of the reference's times at which the model lies inside the corridor.";
    Area = area::area, Error, "area between the distributions",
        "The area between the distribution functions of the values.";
    Iso18571 = iso18571::iso18571, Rating, "ISO/TS 18571 rating", "The overall rating of ISO/TS 18571.";
}

impl Metric {
    /// Its name in a study.
    pub fn name(self) -> String {
        serde_json::to_value(self)
            .expect("a metric is written as a word")
            .as_str()
            .expect("a metric is written as a word")
            .to_owned()
    }

    /// The number for a pair of curves; not a number where a value of the model is none, or there are no values.
    ///
    /// # Panics
    /// When the curves are not equally long, and when a corridor has another length than its curve.
    pub fn compare(self, pair: &Pair) -> f64 {
        assert_eq!(pair.reference.len(), pair.model.len(), "curves of one length");
        if self == Self::Corridor {
            assert_eq!(pair.reference.len(), pair.band.len(), "a corridor as long as its curve");
        }
        if pair.model.is_empty() || pair.model.iter().any(|value| !value.is_finite()) {
            return f64::NAN;
        }
        self.number(pair)
    }

    /// Whether it needs evenly spaced times.
    pub fn needs_even_times(self) -> bool {
        self == Self::Iso18571
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE: [f64; 4] = [1.0, 2.0, -1.0, 4.0];
    const MODEL: [f64; 4] = [1.5, 2.0, -3.0, 4.25];

    fn pair() -> Pair<'static> {
        Pair { band: &[0.5, 0.5, 0.5, 0.1], normaliser: 5.0, ..Pair::new(&REFERENCE, &MODEL) }
    }

    #[test]
    fn a_few_values_by_hand() {
        let rmse = ((0.25 + 4.0 + 0.0625) / 4.0_f64).sqrt();
        for (metric, expected) in [
            (Metric::Rmse, rmse),
            (Metric::Nrmse, rmse / 5.0),
            (Metric::MaxError, 2.0),
            (Metric::Corridor, 0.5),
            // Sorted: -1 1 2 4 and -3 1.5 2 4.25.
            (Metric::Area, 2.75 / 4.0),
        ] {
            let value = metric.compare(&pair());
            assert!((value - expected).abs() < 1e-15, "{metric:?}: {value}");
        }
    }

    #[test]
    fn a_curve_agrees_with_itself() {
        let wave: Vec<f64> = (0..50).map(|k| (0.3 * f64::from(k)).sin()).collect();
        let band = vec![0.0; wave.len()];
        for &metric in Metric::ALL {
            let value = metric.compare(&Pair { band: &band, ..Pair::new(&wave, &wave) });
            let expected = if metric.kind() == Kind::Rating { 1.0 } else { 0.0 };
            assert_eq!(value, expected, "{metric:?}");
        }
    }

    #[test]
    fn not_a_number_is_not_lost() {
        let mut model = MODEL;
        model[2] = f64::NAN;
        for &metric in Metric::ALL {
            let broken = Pair { model: &model, ..pair() };
            assert!(metric.compare(&broken).is_nan(), "{metric:?}");
        }
    }

    #[test]
    fn metrics_are_named_as_in_a_study() {
        let names: Vec<String> = Metric::ALL.iter().map(|metric| metric.name()).collect();
        for name in ["rmse", "nrmse", "max-error", "corridor", "area", "iso18571"] {
            assert!(names.iter().any(|known| known == name), "{name}");
        }
    }
}
