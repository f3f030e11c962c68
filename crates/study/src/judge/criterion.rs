//! A criterion that a value is judged by.

use serde::{Deserialize, Serialize};

use crate::{Detail, NominalFrom};
use conformity::{
    measured::{Limits, Measured},
    uncertainty::Uncertainty,
};
use curves::{Kind, Metric};
use fmu_points::names::behind;
use sampling::statistics::Statistic;

/// Measured value of one quantity with its tolerance, in the study's unit.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Criterion {
    /// Its name.
    pub name: String,
    /// The FMU's variable.
    pub variable: String,
    /// Statistic that turns the signal into one number.
    pub statistic: Statistic,
    /// The number that the statistic needs, where it needs one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<Detail>,
    /// The level of an event with its unit, as the study gives it, and the way in which the signal comes to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<String>,
    /// How a whole curve is compared, in place of a statistic. The value is 0 or 1 then for equal curves, and so is the
    /// measured value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metric: Option<Metric>,
    /// The unit of the numbers.
    pub unit: Option<String>,
    /// The limits, in the unit: a measured value with its accuracy, or a limit that stands alone.
    #[serde(flatten)]
    pub limits: Limits,
    /// Where the nominal value comes from, where that is no measurement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal_from: Option<NominalFrom>,
    /// The accuracy or the limit as the study states it.
    pub stated_tolerance: String,
    /// The measured value beside a limit that stands alone.
    #[serde(rename = "measured", skip_serializing_if = "Option::is_none")]
    pub reading: Option<f64>,
    /// Of a limit that stands alone: in units of this it counts how far a value is beyond it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_unit: Option<f64>,
    /// The uncertainty of the measured value, where the study states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
    /// The criterion from whose measured value this one's is derived.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub derived_from: Option<String>,
    /// The correlation of the errors of any two rows of the measured curve, where it has an uncertainty. The risk is that over
    /// draws of the curve then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row_correlation: Option<f64>,
    /// The group in which it is counted.
    pub group: Option<String>,
}

impl Criterion {
    /// The limits with the measured value and its error.
    pub fn measured(&self) -> Measured {
        let limits = self.limits;
        let is_nominal = !limits.is_one_sided() && self.nominal_from.is_none();
        let value = Some(limits.about).filter(|_| is_nominal).or(self.reading);
        // Without a reading it is a gauge's error at the limit that counts.
        let at = value.unwrap_or(limits.about);
        let error = self.uncertainty.map(|u| u.law(at));
        Measured { limits, value, error }
    }

    /// How far a value is from the measured one, in tolerances of its side: 1 at a limit. At a limit that stands alone it
    /// is 1, too, and 0 one [unit](Self::room) inside and beyond.
    pub fn deviation(&self, value: f64) -> f64 {
        let deviation = self.level(value);
        if deviation < 0.0 { 0.0 } else { deviation }
    }

    /// The same without an end inside of a limit that stands alone: below 0 it still tells how far inside a value is.
    pub fn level(&self, value: f64) -> f64 {
        let away = value - self.limits.about;
        match self.distance_unit {
            Some(unit) => 1.0 - self.limits.rest(value) / unit,
            None if away < 0.0 => -away / self.limits.minus,
            None => away / self.limits.plus,
        }
    }

    /// Half the width of the limits; of one that stands alone the unit of its distance.
    pub fn room(&self) -> f64 {
        self.distance_unit.unwrap_or(0.5 * self.limits.width())
    }

    /// The value with the [deviation](Self::deviation) 0: the measured one.
    pub fn target(&self) -> f64 {
        let inwards = if self.limits.minus.is_infinite() { -1.0 } else { 1.0 };
        self.limits.about + inwards * self.distance_unit.unwrap_or(0.0)
    }

    /// The limits in words: `82 degC +-0.75 %`, `at most 85 degC`.
    pub fn wanted(&self) -> String {
        let Limits { about, minus, plus } = self.limits;
        let (stated, unit) = (&self.stated_tolerance, self.unit_behind());
        // Written out, 1e300 takes 300 digits.
        let is_short = about == 0.0 || (1e-5..1e16).contains(&about.abs());
        let about = if is_short { about.to_string() } else { format!("{about:e}") };
        match self.metric {
            None if minus == plus => format!("{about}{unit} +-{stated}"),
            None if !self.limits.is_one_sided() => format!("{about}{unit} {stated}"),
            _ => stated.clone(),
        }
    }

    /// What the study allows, in its words: `tolerance 0.75 %`, `at most 85 degC`.
    pub fn allowed(&self) -> String {
        let word = if self.limits.is_one_sided() { "" } else { "tolerance " };
        format!("{word}{}", self.stated_tolerance)
    }

    /// The unit as it stands behind a number, with a blank.
    pub fn unit_behind(&self) -> String {
        behind(self.unit.as_deref())
    }

    /// Where its value comes from, such as "mean of sensor.loadForce".
    pub fn source(&self) -> String {
        let label = match (self.metric, self.detail) {
            (Some(metric), _) => metric.label().to_owned(),
            (None, Some(detail)) => detail.label(),
            (None, None) => self.statistic.label().to_owned(),
        };
        let level = self.level.as_deref();
        let level = level.map(|level| format!(", {level}")).unwrap_or_default();
        format!("{label} of {}{level}", self.variable)
    }

    /// The accepted interval as people read and see it: no error is negative, and no rating more than 1, but for rounding.
    pub fn accepted(&self) -> [f64; 2] {
        const ROUNDING: f64 = 1e-9;
        let [low, high] = self.limits.ends();
        match self.metric.map(Metric::kind) {
            Some(Kind::Rating) => [low, high.min(1.0 + ROUNDING)],
            Some(_) => [low.max(0.0), high],
            None => [low, high],
        }
    }

    /// Whether a value agrees with the measurement; the limits themselves do.
    pub fn accepts(&self, value: f64) -> bool {
        self.limits.accepts(value)
    }
}
