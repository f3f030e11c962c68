//! The uncertainty of a measured value with its parts, and the distribution of the error that follows from them.
//!
//! A reading y of a true value t is `y = t + o + g t + e`: an offset o and a gain error g that all readings of a channel
//! share, and noise e that is independent from reading to reading. Standard uncertainties, their combination and
//! effective degrees of freedom after JCGM 100:2008 (GUM), 4.2, 4.3, 5.1 and G.4.

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};
use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

use crate::normal;

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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
    #[serde(default, skip_serializing_if = "is_default")]
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
        Self {
            expanded,
            coverage,
            distribution: Distribution::Normal,
            gain: 0.0,
            noise: 0.0,
            repeats: None,
        }
    }

    /// That of an offset between limits of error: any value up to `half_width` to either side.
    pub fn rectangular(half_width: f64) -> Self {
        Self {
            distribution: Distribution::Rectangular,
            ..Self::normal(half_width, 3.0_f64.sqrt())
        }
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

    /// The effective degrees of freedom of the combined standard uncertainty (Welch and Satterthwaite): infinite where
    /// the noise is known rather than estimated from repeats.
    pub fn degrees_of_freedom(&self, value: f64) -> f64 {
        self.freedom(self.standard(value))
    }

    fn freedom(&self, combined: f64) -> f64 {
        match self.repeats {
            Some(repeats) if self.noise > 0.0 => {
                (f64::from(repeats) - 1.0) * (combined / self.independent()).powi(4)
            }
            _ => f64::INFINITY,
        }
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
        let all = [
            ("uncertainty", self.expanded),
            ("gain-uncertainty", 100.0 * coverage * self.gain),
            ("noise", self.noise),
        ];
        all.into_iter().filter(|(_, part)| *part > 0.0).collect()
    }

    /// What is stated, in words; `unit` is that of the value, with a blank before it.
    pub fn words(&self, unit: &str) -> String {
        let offset = match self.distribution {
            Distribution::Normal => format!("(k = {})", self.coverage),
            Distribution::Rectangular => "(half-width of a rectangle)".to_owned(),
        };
        let mut words = format!("uncertainty {}{unit} {offset}", self.expanded);
        if self.gain > 0.0 {
            words += &format!(", of the gain {} % (k = 1)", 100.0 * self.gain);
        }
        if self.noise > 0.0 {
            words += &format!(", noise {}{unit}", self.noise);
        }
        if let Some(repeats) = self.repeats {
            words += &format!(", mean of {repeats}");
        }
        words
    }

    /// The distribution of the error of this value. The normal parts and the mean of the repeats have Student's
    /// distribution with the effective degrees of freedom of these parts; the rectangle is convolved with it.
    pub fn law(&self, value: f64) -> Law {
        let rectangular = self.distribution == Distribution::Rectangular;
        let scale = match rectangular {
            true => (self.gain * value).hypot(self.independent()),
            false => self.standard(value),
        };
        let mut law = Law {
            scale,
            freedom: self.freedom(scale),
            half_width: if rectangular { self.expanded } else { 0.0 },
            expanded: 0.0,
        };
        law.expanded = match law.is_normal() {
            true => match scale == self.offset() {
                true => self.expanded,
                false => self.normal_coverage() * scale,
            },
            false => law.half_interval(0.95),
        };
        law
    }
}

/// The distribution of the error of a measured value, which is symmetric about 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Law {
    /// The scale of the normal or Student's part.
    pub scale: f64,
    /// Its degrees of freedom: infinite for a normal part.
    #[serde(serialize_with = "finite")]
    pub freedom: f64,
    /// The half-width of the rectangular part.
    pub half_width: f64,
    /// The expanded uncertainty: of a normal error as many standard uncertainties as its coverage factor says, otherwise
    /// half the interval that holds 95 % of the distribution.
    pub expanded: f64,
}

fn finite<S: serde::Serializer>(number: &f64, out: S) -> Result<S::Ok, S::Error> {
    Some(*number).filter(|n| n.is_finite()).serialize(out)
}

impl Law {
    /// Whether the error is normal.
    pub fn is_normal(&self) -> bool {
        self.half_width == 0.0 && self.freedom.is_infinite()
    }

    /// The standard uncertainty. For Student's part its scale, as is usual (GUM, G.3), not its larger standard deviation.
    pub fn standard(&self) -> f64 {
        match self.half_width {
            0.0 => self.scale,
            half => self.scale.hypot(half / 3.0_f64.sqrt()),
        }
    }

    /// The same error, so many times as large.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            scale: factor * self.scale,
            half_width: factor * self.half_width,
            expanded: factor * self.expanded,
            ..*self
        }
    }

    /// The probability of an error up to this one.
    pub fn cdf(&self, error: f64) -> f64 {
        /// A rectangle below this part of the scale changes nothing; both rules would lose digits there.
        const NARROW: f64 = 1e-6;
        let Self {
            scale, half_width, ..
        } = *self;
        if error.is_infinite() || error.is_nan() {
            return f64::from(u8::from(error > 0.0));
        }
        if half_width <= NARROW * scale {
            return self.smooth(error / scale);
        }
        if scale <= NARROW * half_width {
            return (0.5 + 0.5 * error / half_width).clamp(0.0, 1.0);
        }
        // The mean of the smooth part's distribution function over the rectangle, from the tail that loses no digits.
        let away = -error.abs();
        let [above, below] = [away + half_width, away - half_width];
        let integral = self.integral(above / scale) - self.integral(below / scale);
        let tail = (integral * scale / (2.0 * half_width)).clamp(0.0, 1.0);
        if error > 0.0 { 1.0 - tail } else { tail }
    }

    /// The error as a standard normal number of the same probability: for a normal error in standard uncertainties. Joint
    /// probabilities take correlations between these numbers (a Gaussian copula).
    pub fn score(&self, error: f64) -> f64 {
        if self.is_normal() {
            return error / self.scale;
        }
        // Of the tail, which keeps its digits.
        let tail = self.cdf(-error.abs());
        let score = match tail > 0.0 {
            true => Normal::standard().inverse_cdf(tail),
            false => f64::NEG_INFINITY,
        };
        if error > 0.0 { -score } else { score }
    }

    /// The logarithm of the error's density over that of its [score](Self::score) as a normal number, but for a constant: 0
    /// for normal errors.
    pub(super) fn ln_against_normal(&self, error: f64) -> f64 {
        if self.is_normal() {
            return 0.0;
        }
        let density = match (self.half_width, self.student()) {
            (0.0, student) => student.map_or(0.0, |student| student.pdf(error / self.scale)),
            (half, _) if self.scale == 0.0 => f64::from(u8::from(error.abs() <= half)),
            (half, _) => {
                let away = -error.abs();
                self.smooth((away + half) / self.scale) - self.smooth((away - half) / self.scale)
            }
        };
        density.ln() + 0.5 * self.score(error).powi(2)
    }

    /// Half the interval about 0 that holds this probability.
    pub fn half_interval(&self, probability: f64) -> f64 {
        let upper = 0.5 + 0.5 * probability;
        let smooth = match self.scale > 0.0 {
            true => self.scale * self.smooth_quantile(upper),
            false => 0.0,
        };
        if self.half_width == 0.0 {
            return smooth;
        }
        let (mut low, mut high) = (0.0, self.half_width + smooth);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            match self.cdf(middle) < upper {
                true => low = middle,
                false => high = middle,
            }
        }
        high
    }

    fn student(&self) -> Option<StudentsT> {
        /// With so many degrees of freedom the distribution is normal to 1e-6.
        const MANY: f64 = 1e6;
        let freedom = Some(self.freedom).filter(|freedom| *freedom < MANY);
        StudentsT::new(0.0, 1.0, freedom?).ok()
    }

    fn smooth(&self, z: f64) -> f64 {
        self.student()
            .map_or_else(|| normal::cdf(z), |student| student.cdf(z))
    }

    fn smooth_quantile(&self, probability: f64) -> f64 {
        self.student().map_or_else(
            || Normal::standard().inverse_cdf(probability),
            |student| student.inverse_cdf(probability),
        )
    }

    /// An integral of the smooth part's distribution function.
    fn integral(&self, z: f64) -> f64 {
        let rest = match self.student() {
            None => (-0.5 * z * z).exp() / TAU.sqrt(),
            // The limit of the general form, but for a constant.
            Some(_) if (self.freedom - 1.0).abs() < 1e-7 => -(z * z).ln_1p() / (2.0 * PI),
            Some(student) => (self.freedom + z * z) / (self.freedom - 1.0) * student.pdf(z),
        };
        z * self.smooth(z) + rest
    }
}

#[cfg(test)]
mod tests;
