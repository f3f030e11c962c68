//! The uncertainty of a measured value with its parts, and the distribution of the error that follows from them.
//!
//! A reading y of a true value t is `y = t + o + g t + e`: an offset o and a gain error g that all readings of a channel
//! share, and noise e that is independent from reading to reading. Standard uncertainties and their
//! combination after JCGM 100:2008 (GUM), 4.2, 4.3 and 5.1.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::normal;

/// What an expanded uncertainty holds of an error that is not normal, and of every error where two are compared: as much as k = 2 does
/// of a normal one (GUM, table G.2).
pub const COVERED: f64 = 0.954_499_736_103_642;

/// The shape of the offset's distribution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// The offset is normal.
    #[default]
    Normal,
    /// All offsets within limits of error are equally probable.
    Rectangular,
}

/// The uncertainty of a measured value, part by part.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Uncertainty {
    /// Of the offset, in the value's unit: the expanded uncertainty, or the half-width of a rectangle.
    pub expanded: f64,
    /// The coverage factor k: `expanded` is k standard uncertainties of the offset (of a rectangle the root of 3).
    pub coverage: f64,
    /// How the offset is distributed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub distribution: Distribution,
    /// The standard uncertainty of the gain, as a part of the value.
    #[serde(default, skip_serializing_if = "is_default")]
    pub gain: f64,
    /// The standard deviation of one reading's noise, in the value's unit.
    #[serde(default, skip_serializing_if = "is_default")]
    pub noise: f64,
    /// Of how many readings the value is the mean and `noise` the standard deviation; none where `noise` is known and
    /// the value is one reading.
    #[serde(skip_serializing_if = "is_default")]
    pub repeats: Option<u32>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Uncertainty {
    /// The coverage factor where none is stated.
    pub const USUAL: f64 = 2.0;

    /// That of a normal offset alone: U and k.
    pub fn normal(expanded: f64, coverage: f64) -> Self {
        Self { expanded, coverage, distribution: Distribution::Normal, gain: 0.0, noise: 0.0, repeats: None }
    }

    /// That of an offset between limits of error: any value up to `half_width` to either side.
    pub fn rectangular(half_width: f64) -> Self {
        Self { distribution: Distribution::Rectangular, ..Self::normal(half_width, 3.0_f64.sqrt()) }
    }

    /// The standard uncertainty of the offset.
    pub fn offset(&self) -> f64 {
        self.expanded / self.coverage
    }

    /// The standard uncertainty of what all readings of this value share: offset and gain.
    pub fn shared(&self, value: f64) -> f64 {
        self.offset().hypot(self.gain * value)
    }

    /// The standard uncertainty of what is independent of other readings: of the mean where there are repeats.
    pub fn independent(&self) -> f64 {
        self.noise / f64::from(self.repeats.unwrap_or(1)).sqrt()
    }

    /// The combined standard uncertainty u of this value.
    pub fn standard(&self, value: f64) -> f64 {
        self.shared(value).hypot(self.independent())
    }

    /// The coverage factor of the parts that are normal.
    fn normal_coverage(&self) -> f64 {
        match self.distribution {
            Distribution::Normal => self.coverage,
            Distribution::Rectangular => Self::USUAL,
        }
    }

    /// The expanded uncertainties and the noise, by the keys with which a study states them; the gain in per cent.
    pub fn parts(&self) -> Vec<(&'static str, f64)> {
        let coverage = self.normal_coverage();
        [("uncertainty", self.expanded), ("gain-uncertainty", 100.0 * coverage * self.gain), ("noise", self.noise)]
            .into_iter()
            .filter(|(_, part)| *part > 0.0)
            .collect()
    }

    /// The distribution of the error of this value: the sum of a normal number, of Student's for the mean of repeats, and of
    /// one from the rectangle.
    pub fn law(&self, value: f64) -> Law {
        /// Of so many repeats or more the standard deviation is as good as known.
        const MANY: u32 = 1_000_000;
        let rectangular = self.distribution == Distribution::Rectangular;
        let shared = if rectangular { self.gain * value } else { self.shared(value) };
        let repeats = self.repeats.filter(|repeats| *repeats < MANY);
        let [known, estimated] = match repeats {
            Some(_) => [0.0, self.independent()],
            None => [self.independent(), 0.0],
        };
        let mut law = Law {
            normal: shared.hypot(known),
            student: estimated,
            freedom: repeats.map_or(0.0, |repeats| f64::from(repeats) - 1.0),
            half_width: if rectangular { self.expanded } else { 0.0 },
            expanded: 0.0,
        };
        law.expanded = if law.is_normal() {
            if law.normal == self.offset() { self.expanded } else { self.normal_coverage() * law.normal }
        } else {
            law.half_interval(COVERED)
        };
        law
    }
}

/// The distribution of the error of a measured value, which is symmetric about 0: that of a sum of up to three independent
/// parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Law {
    /// The standard deviation of the normal part.
    pub normal: f64,
    /// The scale of Student's part.
    pub student: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
    /// The half-width of the rectangular part.
    pub half_width: f64,
    /// The expanded uncertainty: of a normal error as many standard uncertainties as its coverage factor says, otherwise
    /// half the interval that holds [`COVERED`] of the distribution.
    pub expanded: f64,
}

impl Law {
    /// Whether the error is normal.
    pub fn is_normal(&self) -> bool {
        self.half_width == 0.0 && self.student == 0.0
    }

    /// The standard uncertainty. For Student's part its scale, as is usual (GUM, G.3), not its larger standard deviation.
    pub fn standard(&self) -> f64 {
        let smooth = self.normal.hypot(self.student);
        match self.half_width {
            0.0 => smooth,
            half => smooth.hypot(half / 3.0_f64.sqrt()),
        }
    }

    /// The effective degrees of freedom of a combined standard uncertainty that contains this one, where only those of
    /// Student's part are few (Welch and Satterthwaite: GUM, G.4.1); none where there is no such part.
    pub fn freedom_within(&self, combined: f64) -> Option<f64> {
        (self.student > 0.0).then(|| self.freedom * (combined / self.student).powi(4))
    }

    /// The sum of this error and an independent normal one.
    pub fn with_normal(self, deviation: f64) -> Self {
        Self { normal: self.normal.hypot(deviation), ..self }
    }

    /// The same error, so many times as large.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            normal: factor * self.normal,
            student: factor * self.student,
            half_width: factor * self.half_width,
            expanded: factor * self.expanded,
            ..*self
        }
    }

    /// The probability of an error up to this one.
    pub fn cdf(&self, error: f64) -> f64 {
        if error.is_infinite() || error.is_nan() {
            return f64::from(error > 0.0);
        }
        // From the tail that loses no digits.
        let tail = self.mean(|scale| below(-error.abs(), scale, self.half_width));
        if error > 0.0 { 1.0 - tail } else { tail }
    }

    /// The error as a standard normal number of the same probability: for a normal error in standard uncertainties. Joint
    /// probabilities take correlations between these numbers (a Gaussian copula).
    pub fn score(&self, error: f64) -> f64 {
        if self.is_normal() {
            return error / self.normal;
        }
        // Of the tail, which keeps its digits.
        let tail = self.cdf(-error.abs());
        let score = if tail > 0.0 { Normal::standard().inverse_cdf(tail) } else { f64::NEG_INFINITY };
        if error > 0.0 { -score } else { score }
    }

    /// The logarithm of the density of an error, also where the density itself is too small for a number.
    pub fn ln_density(&self, error: f64) -> f64 {
        let (mut most, mut sum, mut weights) = (f64::NEG_INFINITY, 0.0, 0.0);
        self.mixture(|weight, scale| {
            let ln = ln_density(error.abs(), scale, self.half_width);
            if ln > most {
                sum *= (most - ln).exp();
                most = ln;
            }
            if ln.is_finite() {
                sum += weight * (ln - most).exp();
            }
            weights += weight;
        });
        most + (sum / weights).ln()
    }

    /// The standard deviation of the normal error that stands for this one where only normal errors can: with Student's part
    /// the one whose 95 % interval is as wide, as its standard uncertainty would be too narrow.
    pub fn as_normal(&self) -> f64 {
        /// Half of a normal 95 % interval, in standard deviations.
        const REACH: f64 = 1.959_964;
        if self.student > 0.0 { self.standard().max(self.half_interval(0.95) / REACH) } else { self.standard() }
    }

    /// The same as one of so many means of repeats that are weighed by their own scatter: the smallest scatter by chance
    /// weighs most, so an interval from all of them holds only where those of all hold together. Student's part is widened
    /// to that (Bonferroni).
    pub fn among(self, means: usize) -> Self {
        if self.student == 0.0 || means < 2 {
            return self;
        }
        let student =
            StudentsT::new(0.0, 1.0, self.freedom).expect("a mean of repeats has a degree of freedom or more");
        let [one, all] = [1, means].map(|means| student.inverse_cdf(1.0 - 0.025 / means as f64));
        Self { student: self.student * all / one, ..self }
    }

    /// Half the interval about 0 that holds this probability.
    pub fn half_interval(&self, probability: f64) -> f64 {
        Self::default().half_interval_with(*self, probability)
    }

    /// The same of the sum of this error, which has no rectangular part, and an independent one: Behrens and Fisher's
    /// interval where both have Student's part.
    pub fn half_interval_with(&self, other: Self, probability: f64) -> f64 {
        let upper = 0.5 + 0.5 * probability;
        let cdf = |error| self.mean(|scale| other.with_normal(scale).cdf(error));
        let (mut low, mut high) = (0.0, self.standard().hypot(other.standard()));
        while cdf(high) < upper {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if cdf(middle) < upper { low = middle } else { high = middle }
        }
        high
    }

    /// The mean of a function of the standard deviation over the normal distributions of the [mixture](Self::mixture).
    fn mean(&self, of: impl Fn(f64) -> f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        self.mixture(|weight, scale| {
            sum += weight * of(scale);
            weights += weight;
        });
        sum / weights
    }

    /// The sum of the normal and Student's part as a mixture of normal distributions: gives `take` their weights and standard
    /// deviations. Student's variable is normal given the chi-square variable in its denominator; the trapezoidal rule over
    /// the logarithm of that variable errs by 1e-12.
    fn mixture(&self, mut take: impl FnMut(f64, f64)) {
        /// Weights below this part of the largest one are left out.
        const LEAST: f64 = 1e-14;
        if self.student == 0.0 {
            return take(1.0, self.normal);
        }
        let step = 1.1 / (self.freedom + 10.0).sqrt();
        for (first, step) in [(0.0, step), (-step, -step)] {
            let mut place: f64 = first;
            loop {
                let weight = (0.5 * self.freedom * (place - place.exp_m1())).exp();
                if weight < LEAST {
                    break;
                }
                take(weight, self.normal.hypot(self.student * (-0.5 * place).exp()));
                place += step;
            }
        }
    }
}

/// The logarithm of the density of the sum of a normal error and one from a rectangle, at a distance from 0.
fn ln_density(away: f64, scale: f64, half_width: f64) -> f64 {
    /// A rectangle narrower than this part of the normal error changes nothing.
    const NARROW: f64 = 1e-6;
    if half_width <= NARROW * scale {
        return -0.5 * (away / scale).powi(2) - (scale * TAU.sqrt()).ln();
    }
    let inside = if scale == 0.0 {
        f64::from(away <= half_width).ln()
    } else {
        normal::ln_between((away - half_width) / scale, (away + half_width) / scale)
    };
    inside - (2.0 * half_width).ln()
}

/// The probability that a normal error of this standard deviation and one from a rectangle, together, are below `error`, which is
/// at most 0: the mean of the normal distribution function over the rectangle.
fn below(error: f64, scale: f64, half_width: f64) -> f64 {
    /// One part below this part of the other changes nothing; the general rule would lose digits there.
    const NARROW: f64 = 1e-6;
    if half_width <= NARROW * scale {
        return normal::cdf(error / scale);
    }
    if scale <= NARROW * half_width {
        return (0.5 + 0.5 * error / half_width).clamp(0.0, 1.0);
    }
    let integral = |z: f64| z * normal::cdf(z) + (-0.5 * z * z).exp() / TAU.sqrt();
    let [above, below] = [error + half_width, error - half_width].map(|end| integral(end / scale));
    ((above - below) * scale / (2.0 * half_width)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests;
