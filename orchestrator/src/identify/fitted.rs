//! A measured curve whose rows are data.

use super::late::{Read, Reading, late};
use calibration::problem::{Estimate, UncertainValue};
use fmu_points::{
    names::behind,
    task::{MeasuredCurve, Probe, Schedule},
};
use result_document::format::significant;
use rig_signals::scatter;
use study::{CriterionText, EstimateText, Name};

/// The least independent part of an uncertainty that is otherwise shared: what no statement and no scatter tells, such as
/// rounding.
pub const LEAST: f64 = 0.05;

/// The name of a measured number, and the number.
pub type Value = (String, UncertainValue);

/// A measured curve of a criterion, whose rows are values of the problem from the number `first` on.
pub struct FittedCurve<'a> {
    pub name: &'a Name,
    pub unit: &'a Option<String>,
    pub curve: &'a MeasuredCurve,
    pub first: usize,
}

impl FittedCurve<'_> {
    /// Whether the study states what its rows do not share.
    fn states_noise(&self) -> bool {
        let errors = self.curve.errors.as_ref();
        errors.is_some_and(|errors| errors.own.iter().any(|own| *own > 0.0))
    }

    /// The standard deviation of each row's own error. Where none is stated it is the recording's scatter, with a note.
    pub fn own(&self, notes: &mut Vec<String>) -> Result<Vec<f64>, String> {
        let Some(errors) = &self.curve.errors else {
            return Err("identify weighs each value of a curve by its uncertainty: add `uncertainty` and `noise` to the reference \
                           (one that is resampled to even times has none)".to_owned());
        };
        let combined = |(row, shared): (usize, &f64)| shared.hypot(errors.gain * self.curve.values[row]);
        let combined: Vec<f64> = errors.shared.iter().enumerate().map(combined).collect();
        let is_stated = self.states_noise();
        let scatter = scatter::scatter(&self.curve.values);
        let own: Vec<f64> = errors
            .own
            .iter()
            .zip(&combined)
            .map(
                |(own, combined)| {
                    if is_stated { *own } else { scatter.map_or(*combined, |scatter| scatter.max(LEAST * combined)) }
                },
            )
            .collect();
        if let Some(row) = own.iter().position(|own| *own <= 0.0) {
            return Err(format!("the uncertainty at {} s is {}; it must be positive", self.curve.times[row], own[row]));
        }
        if !is_stated {
            notes.push(self.assumed(scatter, &own));
        }
        Ok(own)
    }

    /// How well the noise is known that is not simply stated.
    pub fn estimate(&self, text: &CriterionText) -> Option<Estimate> {
        let reference = text.reference.as_ref()?;
        let rows = self.curve.values.len();
        let known = match &reference.noise_estimate {
            Some(stated) => *stated.as_ref(),
            None if self.states_noise() => return None,
            None => EstimateText { freedom: scatter::freedom(rows)?, correlation: 0.0, rows: 1.0 },
        };
        Some(Estimate {
            quantities: self.first..self.first + rows,
            freedom: known.freedom,
            correlation: known.correlation,
            rows: known.rows,
        })
    }

    /// The independent error that is assumed.
    fn assumed(&self, scatter: Option<f64>, own: &[f64]) -> String {
        let mean = (own.iter().map(|own| own * own).sum::<f64>() / own.len() as f64).sqrt();
        let number = format!("{}{}", significant(mean, 3), behind(self.unit.as_deref()));
        let from = match scatter {
            Some(_) => "as the scatter of its rows",
            None => "as large as the uncertainty, since its rows are too few to show their scatter",
        };
        let name = self.name.as_ref();
        format!("{name} states no noise: taken {from}, noise = \"{number}\"")
    }

    /// A value for each time, with the probes that read the model, of which the first has the number `first`, and how their
    /// readings become predictions.
    pub fn samples(
        &self,
        (probe, schedule): (&Probe, &Schedule),
        own: &[f64],
        lags: (Vec<usize>, [f64; 2]),
        first: usize,
    ) -> Result<(Vec<Value>, Read), String> {
        let data = self.curve.times.iter().zip(&self.curve.values).zip(own).map(|((time, &value), &accuracy)| {
            // Without the rounding of times that were shifted by a delay.
            let time = (time * 1e9).round() / 1e9;
            (format!("{} at {time} s", self.name.as_ref()), UncertainValue { value, accuracy })
        });
        let read = if lags.0.is_empty() {
            let probes = self.curve.shown_times().map(|time| probe.at_row(self.curve, time));
            let numbers = first..first + own.len();
            (probes.collect(), numbers.map(Reading::Value).collect())
        } else {
            late(probe, self.curve, schedule, lags, first)?
        };
        Ok((data.collect(), read))
    }
}
