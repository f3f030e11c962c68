//! The distributions of uncertain parameters, sampled by their quantile functions: one uniform
//! number in (0, 1) gives one value, whatever the design that chose the number.

mod density;

use std::sync::Arc;

use density::of_logarithm;
use serde::Serialize;
use statrs::function::erf::{erfc, erfc_inv};

/// The largest number below 1. Rounding must not lift a probability to 1, whose quantile may be infinite.
pub(crate) const BELOW_ONE: f64 = 1.0_f64.next_down();

/// A distribution with its numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "distribution", rename_all = "kebab-case")]
pub enum Distribution {
    /// The normal distribution.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        deviation: f64,
    },
    /// A normal distribution that is cut and scaled up to probability 1.
    TruncatedNormal {
        /// Mean before the cut.
        mean: f64,
        /// Standard deviation before the cut.
        deviation: f64,
        /// Smallest value.
        min: Option<f64>,
        /// Largest value.
        max: Option<f64>,
    },
    /// Every value equally probable.
    Uniform {
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// The density is a triangle.
    Triangular {
        /// Smallest value.
        min: f64,
        /// Most probable value.
        mode: f64,
        /// Largest value.
        max: f64,
    },
    /// The logarithm is normal.
    Lognormal {
        /// Mean of the quantity itself.
        mean: f64,
        /// Standard deviation of the quantity itself.
        deviation: f64,
    },
    /// The values of a sample, each as probable as any other.
    Sample {
        /// The values in rising order.
        #[serde(skip)]
        values: Arc<[f64]>,
    },
    /// Always the same value.
    Fixed {
        /// The value.
        value: f64,
    },
    /// A quantity that takes whole numbers only ([`Distribution::whole`]).
    #[serde(untagged)]
    Whole(Box<Distribution>),
}

/// The cumulative distribution of the standard normal distribution.
pub(crate) fn normal_cdf(z: f64) -> f64 {
    0.5 * erfc(-z / std::f64::consts::SQRT_2)
}

/// The quantile of the standard normal distribution.
pub(crate) fn normal_quantile(u: f64) -> f64 {
    -std::f64::consts::SQRT_2 * erfc_inv(2.0 * u)
}

/// The logarithm of the sum of numbers that are given by their logarithms.
pub fn ln_sum(terms: &[f64]) -> f64 {
    let most = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return most;
    }
    let parts = terms.iter().map(|term| (term - most).exp());
    most + parts.sum::<f64>().ln()
}

/// The ends of a truncated distribution, where it has any.
fn limits(min: Option<f64>, max: Option<f64>) -> [f64; 2] {
    [min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY)]
}

fn require(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise()) }
}

impl Distribution {
    /// The distribution of a sample's values.
    pub fn sample(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self::Sample { values: values.into() }
    }

    /// The distribution of a quantity that takes whole numbers only: a uniform one is uniform over those from its smallest
    /// to its largest value, of any other the values are rounded.
    #[must_use]
    pub fn whole(self) -> Self {
        match self {
            Self::Fixed { value } => Self::Fixed { value: value.round() },
            Self::Whole(_) => self,
            other => Self::Whole(Box::new(other)),
        }
    }

    /// The distribution before its values were made whole.
    pub fn continuous(&self) -> &Self {
        match self {
            Self::Whole(of) => of,
            other => other,
        }
    }

    /// The first whole number of a uniform distribution over whole numbers, and how many there are.
    fn uniform_whole(&self) -> Option<[f64; 2]> {
        let Self::Uniform { min, max } = *self else { return None };
        let (first, last) = (min.ceil(), max.floor());
        // A narrowed one may hold none; the nearest stands for it then.
        Some(if first <= last { [first, last - first + 1.0] } else { [(0.5 * (min + max)).round(), 1.0] })
    }

    /// Says what is wrong with the numbers, if anything is.
    ///
    /// # Errors
    /// A sentence that names the number.
    pub fn check(&self) -> Result<(), String> {
        let positive = |deviation: f64| {
            let fits = deviation > 0.0 && deviation.is_finite();
            require(fits, || format!("deviation {deviation} must be positive"))
        };
        let ordered = |[low, high]: [f64; 2]| require(low < high, || format!("min {low} must be less than max {high}"));
        match *self {
            Self::Normal { deviation, .. } => positive(deviation),
            Self::TruncatedNormal { deviation, min, max, .. } => {
                positive(deviation)?;
                ordered(limits(min, max))?;
                let [low, high] = self.cut();
                require(high - low > 1e-12, || "almost nothing is left between min and max".to_owned())
            }
            Self::Uniform { min, max } => ordered([min, max]),
            Self::Triangular { min, mode, max } => {
                ordered([min, max])?;
                require((min..=max).contains(&mode), || format!("mode {mode} must lie between min {min} and max {max}"))
            }
            Self::Lognormal { mean, deviation } => {
                positive(deviation)?;
                require(mean > 0.0, || format!("mean {mean} of a lognormal quantity must be positive"))
            }
            Self::Sample { ref values } => require(!values.is_empty(), || "the sample is empty".to_owned()),
            Self::Fixed { .. } => Ok(()),
            Self::Whole(ref of) => {
                of.check()?;
                match **of {
                    Self::Uniform { min, max } => require(min.ceil() <= max.floor(), || {
                        format!("there is no whole number from min {min} to max {max}")
                    }),
                    _ => Ok(()),
                }
            }
        }
    }

    /// The probabilities below the cuts of a truncated distribution.
    fn cut(&self) -> [f64; 2] {
        let Self::TruncatedNormal { mean, deviation, min, max } = *self else { return [0.0, 1.0] };
        limits(min, max).map(|end| normal_cdf((end - mean) / deviation))
    }

    /// The value below which the quantity lies with probability `u`, 0 < u < 1.
    pub fn quantile(&self, u: f64) -> f64 {
        match *self {
            Self::Normal { mean, deviation } => mean + deviation * normal_quantile(u),
            Self::TruncatedNormal { mean, deviation, min, max } => {
                let [low, high] = self.cut();
                let u = (low + u * (high - low)).min(BELOW_ONE);
                let [least, most] = limits(min, max);
                (mean + deviation * normal_quantile(u)).max(least).min(most)
            }
            Self::Uniform { min, max } => min + u * (max - min),
            Self::Triangular { min, mode, max } => {
                let span = max - min;
                if u < (mode - min) / span {
                    min + (u * span * (mode - min)).sqrt()
                } else {
                    max - ((1.0 - u) * span * (max - mode)).sqrt()
                }
            }
            Self::Lognormal { mean, deviation } => {
                let (centre, spread) = of_logarithm(mean, deviation);
                (centre + spread * normal_quantile(u)).exp()
            }
            Self::Sample { ref values } => {
                let index = (u * values.len() as f64) as usize;
                values[index.min(values.len() - 1)]
            }
            Self::Fixed { value } => value,
            Self::Whole(ref of) => match of.uniform_whole() {
                Some([first, count]) => first + (u * count).floor().min(count - 1.0),
                None => of.quantile(u).round(),
            },
        }
    }

    /// The value as many standard deviations above the median as a standard normal number `score` is: the
    /// quantile of the probability below `score`.
    pub fn at_score(&self, score: f64) -> f64 {
        match *self {
            Self::Normal { mean, deviation } => mean + deviation * score,
            Self::Whole(ref of) if of.uniform_whole().is_none() => of.at_score(score).round(),
            _ => self.quantile(normal_cdf(score).clamp(f64::MIN_POSITIVE, BELOW_ONE)),
        }
    }

    /// The probabilities between which a search may look: to the very ends of a bounded quantity, and to quantiles of
    /// 0.001 and 0.999 where it has no end.
    pub fn reach(&self) -> [f64; 2] {
        const FAR: [f64; 2] = [0.001, 0.999];
        let [has_least, has_most] = self.is_bounded();
        [if has_least { 0.0 } else { FAR[0] }, if has_most { 1.0 } else { FAR[1] }]
    }

    /// Whether there is a smallest value and a largest one that searches may look at.
    pub fn is_bounded(&self) -> [bool; 2] {
        match *self {
            Self::Normal { .. } | Self::Lognormal { .. } => [false; 2],
            Self::TruncatedNormal { min, max, .. } => [min.is_some(), max.is_some()],
            Self::Whole(ref of) => of.is_bounded(),
            Self::Uniform { .. } | Self::Triangular { .. } | Self::Sample { .. } | Self::Fixed { .. } => [true; 2],
        }
    }

    /// A value in the middle: the median.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// Whether the value varies at all.
    pub fn varies(&self) -> bool {
        !matches!(self, Self::Fixed { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all() -> [Distribution; 5] {
        [
            Distribution::Normal { mean: 2.0, deviation: 0.5 },
            Distribution::TruncatedNormal { mean: 2.0, deviation: 0.5, min: Some(1.5), max: None },
            Distribution::Uniform { min: -1.0, max: 3.0 },
            Distribution::Triangular { min: 0.0, mode: 1.0, max: 4.0 },
            Distribution::Lognormal { mean: 2.0, deviation: 0.5 },
        ]
    }

    /// Mean and deviation by the midpoint rule over the quantiles.
    fn moments(distribution: &Distribution) -> (f64, f64) {
        const N: i32 = 100_000;
        let values = (0..N).map(|i| distribution.quantile((f64::from(i) + 0.5) / f64::from(N)));
        let (sum, squares) = values.fold((0.0, 0.0), |(s, q), x| (s + x, q + x * x));
        let mean = sum / f64::from(N);
        (mean, (squares / f64::from(N) - mean * mean).sqrt())
    }

    #[test]
    fn moments_are_those_asked_for() {
        let [normal, _, uniform, triangular, lognormal] = all();
        let close = |distribution, mean: f64, deviation: f64| {
            let (m, d) = moments(&distribution);
            assert!((m - mean).abs() < 1e-3, "{distribution:?}: mean {m}");
            assert!((d - deviation).abs() < 1e-3, "{distribution:?}: deviation {d}");
        };
        close(normal, 2.0, 0.5);
        close(lognormal, 2.0, 0.5);
        close(uniform, 1.0, 4.0 / 12_f64.sqrt());
        // Triangle: mean (a+b+c)/3, variance (a^2+b^2+c^2-ab-ac-bc)/18.
        close(triangular, 5.0 / 3.0, (13.0_f64 / 18.0).sqrt());
    }

    #[test]
    fn whole_numbers_from_a_uniform_distribution_are_equally_probable() {
        let uniform = |min, max| Distribution::Uniform { min, max }.whole();
        let at = |distribution: &Distribution| -> Vec<f64> {
            let places = (0..12).map(|k| (f64::from(k) + 0.5) / 12.0);
            places.map(|u| distribution.quantile(u)).collect()
        };
        let thirds = [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0];
        for three in [uniform(1.0, 3.0), uniform(0.5, 3.5), uniform(0.1, 3.9)] {
            assert_eq!(at(&three), thirds);
            assert_eq!([0.5, 1.0, 2.5, 3.0].map(|x| three.below(x)), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
            assert!((three.ln_density(2.0) + 3.0_f64.ln()).abs() < 1e-12);
            assert_eq!(three.ln_density(1.5), f64::NEG_INFINITY);
        }
        assert!(uniform(1.2, 1.8).check().unwrap_err().contains("no whole number"));
        assert_eq!(uniform(1.2, 1.8).quantile(0.9), 2.0);
        let normal = Distribution::Normal { mean: 2.0, deviation: 0.5 };
        let rounded = normal.clone().whole();
        assert_eq!(rounded.quantile(0.9), 3.0);
        assert_eq!(rounded.at_score(0.9), 2.0);
        assert!((rounded.below(2.0) - normal.below(2.5)).abs() < 1e-15);
        assert_eq!(rounded.continuous(), &normal);
        assert_eq!(Distribution::Fixed { value: 2.4 }.whole(), Distribution::Fixed { value: 2.0 });
    }

    #[test]
    fn a_search_reaches_the_ends_of_what_is_bounded() {
        let [normal, cut, uniform, triangular, lognormal] = all();
        assert_eq!(normal.reach(), [0.001, 0.999]);
        assert_eq!(lognormal.reach(), [0.001, 0.999]);
        assert_eq!(cut.reach(), [0.0, 0.999]);
        assert!((cut.quantile(0.0) - 1.5).abs() < 1e-9);
        for (bounded, ends) in [(uniform, [-1.0, 3.0]), (triangular, [0.0, 4.0])] {
            assert_eq!(bounded.reach().map(|u| bounded.quantile(u)), ends);
        }
        let whole = Distribution::Uniform { min: 1.0, max: 3.0 }.whole();
        assert_eq!(whole.reach().map(|u| whole.quantile(u)), [1.0, 3.0]);
    }

    #[test]
    fn quantiles_of_the_normal_distribution_are_exact() {
        assert!((normal_quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-13);
        assert!((normal_quantile(1e-10) + 6.361_340_902_404_056).abs() < 1e-11);
    }

    #[test]
    fn wrong_numbers_are_named() {
        let (min, max) = (1.0, 3.0);
        let normal = |deviation| Distribution::Normal { mean: 0.0, deviation };
        let cut = |min, max| Distribution::TruncatedNormal { mean: 0.0, deviation: 1.0, min, max };
        let triangular = |mode| Distribution::Triangular { min, mode, max };
        let lognormal = |mean, deviation| Distribution::Lognormal { mean, deviation };
        for (wrong, named) in [
            (normal(0.0), "deviation 0 "),
            (normal(f64::INFINITY), "deviation inf "),
            (normal(f64::NAN), "deviation NaN "),
            (cut(Some(2.0), Some(2.0)), "min 2 must be less than max 2"),
            (cut(Some(8.0), None), "almost nothing is left"),
            (Distribution::Uniform { min: 2.0, max: 1.0 }, "min 2 "),
            (triangular(0.9), "mode 0.9 must lie between min 1 and max 3"),
            (triangular(3.1), "mode 3.1 "),
            (lognormal(0.0, 1.0), "mean 0 of a lognormal"),
            (lognormal(1.0, -1.0), "deviation -1 "),
        ] {
            let error = wrong.check().unwrap_err();
            assert!(error.contains(named), "{error}");
        }
        for right in [
            normal(1.0),
            cut(None, None),
            cut(Some(6.0), None),
            triangular(min),
            triangular(max),
            lognormal(1.0, 2.0),
            Distribution::Fixed { value: 0.0 },
        ] {
            assert_eq!(right.check(), Ok(()), "{right:?}");
        }
    }

    /// A sample's values go with the last distribution that has them.
    #[test]
    fn a_sample_is_freed() {
        let sample = Distribution::sample(vec![3.0, 1.0, 2.0]);
        let copy = sample.clone();
        let Distribution::Sample { values } = &sample else { panic!("{sample:?}") };
        let values = Arc::downgrade(values);
        drop(sample);
        assert_eq!(copy.median(), 2.0);
        drop(copy);
        assert_eq!(values.strong_count(), 0);
    }

    #[test]
    fn quantiles_are_those_of_closed_forms() {
        let [_, truncated, uniform, triangular, lognormal] = all();
        let shifted = Distribution::Triangular { min: 5.0, mode: 6.0, max: 9.0 };
        let fixed = Distribution::Fixed { value: 7.0 };
        let both = Distribution::TruncatedNormal { mean: 2.0, deviation: 0.5, min: Some(1.0), max: Some(2.5) };
        for (distribution, u, expected) in [
            (&uniform, 0.25, 0.0),
            (&triangular, 0.0625, 0.5),
            (&triangular, 0.75, 4.0 - 3_f64.sqrt()),
            (&shifted, 0.0625, 5.5),
            (&shifted, 0.75, 9.0 - 3_f64.sqrt()),
            (&lognormal, 0.5, 2.0 / 1.0625_f64.sqrt()),
            (&fixed, 0.1, 7.0),
            // A share of 0.1587 is cut away below; the normal score of 0.5793 is 0.2002.
            (&truncated, 0.5, 2.0 + 0.5 * 0.200_174),
            // 0.0228 is cut away below and 0.1587 above; the score of 0.4321 is -0.1711.
            (&both, 0.5, 2.0 - 0.5 * 0.171_164),
        ] {
            let quantile = distribution.quantile(u);
            assert!((quantile - expected).abs() < 1e-5, "{distribution:?}: {quantile}");
        }
        assert_eq!(triangular.median(), triangular.quantile(0.5));
        assert!(triangular.varies() && !fixed.varies());
    }

    #[test]
    fn a_score_gives_the_quantile_of_the_probability_below_it() {
        for distribution in all() {
            let quantile = distribution.at_score(1.0);
            let expected = distribution.quantile(0.841_344_746_068_543);
            assert!((quantile - expected).abs() < 1e-9, "{distribution:?}: {quantile}");
            // Scores at which the probability is 0 or 1 in floating point.
            let [low, high] = [-60.0, 60.0].map(|score| distribution.at_score(score));
            assert!(low < high && low.is_finite() && high.is_finite(), "{distribution:?}: {low} {high}");
        }
    }

    /// The score of 1 - 2^-53 is 8.2095; a normal quantity has values beyond.
    #[test]
    fn the_far_tail_is_neither_infinite_nor_cut_off_early() {
        let [normal, ..] = all();
        assert_eq!(normal.at_score(12.0), 8.0);
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        assert_eq!(unit.at_score(60.0), 1.0_f64.next_down());
        let cut = |min| Distribution::TruncatedNormal { mean: 0.0, deviation: 1.0, min, max: None };
        for min in [None, Some(0.1), Some(1.0), Some(3.0)] {
            let last = cut(min).quantile(1.0_f64.next_down());
            assert!((last - 8.2095).abs() < 1e-4, "{min:?}: {last}");
        }
    }

    proptest! {
        #[test]
        fn quantiles_grow_and_stay_within_the_cuts(u in 1e-9..1.0_f64, v in 1e-9..1.0_f64) {
            for distribution in all() {
                let (low, high) = (u.min(v), u.max(v));
                prop_assert!(distribution.quantile(low) <= distribution.quantile(high));
            }
            prop_assert!(all()[1].quantile(u) >= 1.5);
        }
    }
}
