//! Densities and probabilities of a distribution, and the same distribution narrower or wider.

use std::f64::consts::TAU;

use super::{Distribution, limits, normal_cdf};

fn ln_normal(value: f64, mean: f64, deviation: f64) -> f64 {
    let z = (value - mean) / deviation;
    -0.5 * z * z - deviation.ln() - 0.5 * TAU.ln()
}

/// Mean and standard deviation of the logarithm of a lognormal quantity.
pub fn of_logarithm(mean: f64, deviation: f64) -> (f64, f64) {
    let variance = (1.0 + (deviation / mean).powi(2)).ln();
    (mean.ln() - variance / 2.0, variance.sqrt())
}

impl Distribution {
    /// The probability that the quantity is less than `value`, or equal to it.
    pub fn below(&self, value: f64) -> f64 {
        match *self {
            Self::Normal { mean, deviation } => normal_cdf((value - mean) / deviation),
            Self::TruncatedNormal { mean, deviation, .. } => {
                let [low, high] = self.cut();
                let share = (normal_cdf((value - mean) / deviation) - low) / (high - low);
                share.clamp(0.0, 1.0)
            }
            Self::Uniform { min, max } => ((value - min) / (max - min)).clamp(0.0, 1.0),
            Self::Triangular { min, mode, max } => {
                let span = max - min;
                let value = value.clamp(min, max);
                if value < mode {
                    (value - min).powi(2) / (span * (mode - min))
                } else if max > mode {
                    1.0 - (max - value).powi(2) / (span * (max - mode))
                } else {
                    1.0
                }
            }
            Self::Lognormal { mean, deviation } => {
                let (centre, spread) = of_logarithm(mean, deviation);
                if value > 0.0 { normal_cdf((value.ln() - centre) / spread) } else { 0.0 }
            }
            Self::Sample { ref values } => values.partition_point(|one| *one <= value) as f64 / values.len() as f64,
            Self::Fixed { value: only } => f64::from(value >= only),
            Self::Whole(ref of) => match of.uniform_whole() {
                Some([first, count]) => ((value.floor() - first + 1.0) / count).clamp(0.0, 1.0),
                None => of.below(value.floor() + 0.5),
            },
        }
    }

    /// The logarithm of the density, or of the probability of a whole number; minus infinity where the quantity never is. A fixed quantity and one
    /// from a sample, whose values are all as probable, have none: 0, so
    /// that it changes no sum.
    pub fn ln_density(&self, value: f64) -> f64 {
        match *self {
            Self::Normal { mean, deviation } => ln_normal(value, mean, deviation),
            Self::TruncatedNormal { mean, deviation, min, max } => {
                let [least, most] = limits(min, max);
                if value < least || value > most {
                    return f64::NEG_INFINITY;
                }
                let [low, high] = self.cut();
                ln_normal(value, mean, deviation) - (high - low).ln()
            }
            Self::Uniform { min, max } if (min..=max).contains(&value) => -(max - min).ln(),
            Self::Triangular { min, mode, max } if (min..=max).contains(&value) => {
                let share = if value < mode {
                    (value - min) / (mode - min)
                } else if max > mode {
                    (max - value) / (max - mode)
                } else {
                    1.0
                };
                (2.0 * share / (max - min)).ln()
            }
            Self::Uniform { .. } | Self::Triangular { .. } => f64::NEG_INFINITY,
            Self::Lognormal { mean, deviation } => {
                if value > 0.0 {
                    let (centre, spread) = of_logarithm(mean, deviation);
                    ln_normal(value.ln(), centre, spread) - value.ln()
                } else {
                    f64::NEG_INFINITY
                }
            }
            Self::Sample { .. } | Self::Fixed { .. } => 0.0,
            Self::Whole(ref of) if matches!(**of, Self::Sample { .. }) => 0.0,
            Self::Whole(_) if value.fract() != 0.0 => f64::NEG_INFINITY,
            Self::Whole(_) => (self.below(value) - self.below(value - 1.0)).ln(),
        }
    }

    /// The value that stays where it is when the tolerance gets narrower.
    pub fn centre(&self) -> f64 {
        match *self {
            Self::Normal { mean, .. } | Self::Lognormal { mean, .. } => mean,
            Self::TruncatedNormal { mean, min, max, .. } => {
                let [least, most] = limits(min, max);
                mean.max(least).min(most)
            }
            Self::Uniform { min, max } => 0.5 * (min + max),
            Self::Triangular { mode, .. } => mode,
            Self::Sample { .. } => self.median(),
            Self::Fixed { value } => value,
            Self::Whole(ref of) => of.centre().round(),
        }
    }

    /// The same distribution with its spread about the [centre](Self::centre) multiplied by a factor. The cuts of a
    /// truncated distribution stay: they are limits of the part, not of its tolerance.
    pub fn scaled(&self, factor: f64) -> Self {
        let about = |centre: f64, value: f64| centre + factor * (value - centre);
        match *self {
            Self::Normal { mean, deviation } => Self::Normal { mean, deviation: factor * deviation },
            Self::TruncatedNormal { deviation, min, max, .. } => Self::TruncatedNormal {
                // A mean outside of the cuts would leave almost nothing of a narrow distribution.
                mean: self.centre(),
                deviation: factor * deviation,
                min,
                max,
            },
            Self::Uniform { min, max } => {
                Self::Uniform { min: about(self.centre(), min), max: about(self.centre(), max) }
            }
            Self::Triangular { min, mode, max } => {
                Self::Triangular { min: about(mode, min), mode, max: about(mode, max) }
            }
            Self::Lognormal { mean, deviation } => Self::Lognormal { mean, deviation: factor * deviation },
            // The rows of a sample are given: their spread has no factor.
            Self::Sample { .. } | Self::Fixed { .. } => self.clone(),
            Self::Whole(ref of) => of.scaled(factor).whole(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> [Distribution; 5] {
        [
            Distribution::Normal { mean: 2.0, deviation: 0.5 },
            Distribution::TruncatedNormal { mean: 2.0, deviation: 0.5, min: Some(1.5), max: Some(3.5) },
            Distribution::Uniform { min: -1.0, max: 3.0 },
            Distribution::Triangular { min: 0.0, mode: 1.0, max: 4.0 },
            Distribution::Lognormal { mean: 2.0, deviation: 0.5 },
        ]
    }

    #[test]
    fn probabilities_are_the_inverse_of_quantiles() {
        for distribution in all() {
            for u in [0.01, 0.2, 0.5, 0.9, 0.999] {
                let below = distribution.below(distribution.quantile(u));
                assert!((below - u).abs() < 1e-9, "{distribution:?}: {below}");
            }
            assert_eq!(distribution.below(-100.0), 0.0);
            assert!((distribution.below(100.0) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn densities_are_the_slopes_of_probabilities() {
        for distribution in all() {
            for scaled in [distribution.clone(), distribution.scaled(0.5), distribution.scaled(1.5)] {
                for u in [0.05, 0.3, 0.6, 0.95] {
                    let (value, h) = (scaled.quantile(u), 1e-5);
                    let slope = (scaled.below(value + h) - scaled.below(value - h)) / (2.0 * h);
                    let density = scaled.ln_density(value).exp();
                    assert!((density / slope - 1.0).abs() < 1e-5, "{scaled:?}: {density} {slope}");
                }
            }
            assert!(distribution.ln_density(-1e3) < -1e3);
        }
    }

    /// Triangles whose mode is an end have the closed forms 1 - (1 - x)^2 and x^2 on the unit interval.
    #[test]
    fn triangles_without_one_of_their_sides() {
        let triangle = |mode| Distribution::Triangular { min: 0.0, mode, max: 1.0 };
        let [falling, rising] = [0.0, 1.0].map(triangle);
        for (x, below) in [(-1.0, 0.0), (0.0, 0.0), (0.5, 0.75), (1.0, 1.0), (2.0, 1.0)] {
            assert_eq!(falling.below(x), below, "{x}");
            assert_eq!(rising.below(1.0 - x), 1.0 - below, "{x}");
        }
        for (x, density) in [(-0.1, 0.0), (0.0, 2.0), (0.75, 0.5), (1.0, 0.0), (1.1, 0.0)] {
            let logs = [falling.ln_density(x), rising.ln_density(1.0 - x)];
            for value in logs.map(f64::exp) {
                assert!((value - density).abs() < 1e-12, "{x}: {value}");
            }
        }
    }

    #[test]
    fn limits_belong_to_the_quantity_and_nothing_beyond_them() {
        let [_, truncated, uniform, _, lognormal] = all();
        for (distribution, [min, max]) in [(truncated, [1.5, 3.5]), (uniform, [-1.0, 3.0])] {
            assert_eq!([min, max].map(|end| distribution.below(end)), [0.0, 1.0], "{distribution:?}");
            for end in [min, max] {
                assert!(distribution.ln_density(end).is_finite(), "{distribution:?}");
            }
            for beyond in [min - 1e-9, max + 1e-9] {
                let ln_density = distribution.ln_density(beyond);
                assert_eq!(ln_density, f64::NEG_INFINITY, "{distribution:?}");
            }
        }
        for value in [0.0, -1.0] {
            assert_eq!(lognormal.below(value), 0.0);
            assert_eq!(lognormal.ln_density(value), f64::NEG_INFINITY);
        }
    }

    #[test]
    fn a_fixed_quantity_is_all_in_one_place() {
        let fixed = Distribution::Fixed { value: 7.0 };
        assert_eq!([6.9, 7.0, 7.1].map(|x| fixed.below(x)), [0.0, 1.0, 1.0]);
        assert_eq!([6.9, 7.0].map(|x| fixed.ln_density(x)), [0.0; 2]);
        assert_eq!((fixed.centre(), fixed.scaled(0.5)), (7.0, fixed));
    }

    #[test]
    fn half_the_spread_by_hand() {
        let [_, _, uniform, triangular, _] = all();
        let half = Distribution::Uniform { min: 0.0, max: 2.0 };
        assert_eq!(uniform.scaled(0.5), half);
        let half = Distribution::Triangular { min: 0.5, mode: 1.0, max: 2.5 };
        assert_eq!(triangular.scaled(0.5), half);
        // A mean beyond the cuts moves to the nearest value that they leave.
        let cut = |mean, deviation| Distribution::TruncatedNormal { mean, deviation, min: Some(1.5), max: Some(3.5) };
        assert_eq!(cut(1.0, 0.5).scaled(2.0), cut(1.5, 1.0));
        assert_eq!(cut(9.0, 0.5).scaled(2.0), cut(3.5, 1.0));
    }

    #[test]
    fn a_factor_narrows_about_the_centre() {
        for distribution in all() {
            let narrow = distribution.scaled(1e-3);
            let spread = narrow.quantile(0.9) - narrow.quantile(0.1);
            let before = distribution.quantile(0.9) - distribution.quantile(0.1);
            assert!(spread < 2e-3 * before, "{distribution:?}");
            assert!((narrow.median() - distribution.centre()).abs() < spread);
            assert_eq!(distribution.scaled(1.0), distribution);
        }
    }
}
