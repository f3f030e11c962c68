//! Offsets, gains and delays of sensors.

use nalgebra::DVector;

use super::{
    super::problem::{NoPrediction, SharedKind},
    inquiry::{Candidate, Inquiry, Sensor, Suspect, Suspicion, WIDE, middle, spacing},
    linear::Linear,
};

/// An error that a sensor may have.
struct SensorError {
    fault: Suspicion,
    /// By how much it moves each value where it is 1.
    pattern: Vec<f64>,
    unit: Option<String>,
    /// The limit that is stated for it.
    stated: Option<f64>,
    /// What is usual where no limit is stated.
    usual: f64,
}

impl Inquiry<'_> {
    /// Offsets, gains and delays of sensors.
    pub(super) fn of_sensors(&self, linear: &Linear) -> Vec<Candidate<'_>> {
        let mut candidates = Vec::new();
        for sensor in self.sensors {
            for error in self.errors_of(sensor) {
                let column = self.column(sensor, &error.pattern);
                let weighted = column.component_div(&linear.accuracies);
                if let Some((fall, size)) = linear.score(&weighted, None) {
                    let fit = Box::new(move || self.with_error(sensor, &error, &column, size));
                    candidates.push(Candidate { fall, fit });
                }
            }
        }
        candidates
    }

    /// The errors that a sensor has values enough for.
    fn errors_of(&self, sensor: &Sensor) -> Vec<SensorError> {
        const USUAL_GAIN: f64 = 0.02;
        let values = self.predicted(sensor);
        let mut errors = vec![SensorError {
            fault: Suspicion::Offset,
            pattern: vec![1.0; values.len()],
            unit: sensor.unit.clone(),
            stated: self.stated(sensor, SharedKind::Offset),
            usual: 2.0 * self.accuracy(sensor),
        }];
        if values.len() > 2 {
            errors.push(SensorError {
                fault: Suspicion::Gain,
                pattern: values.clone(),
                unit: None,
                stated: self.stated(sensor, SharedKind::Gain),
                usual: USUAL_GAIN,
            });
        }
        if !sensor.times.is_empty() && values.len() > 4 {
            errors.push(SensorError {
                fault: Suspicion::Delay,
                pattern: sensor.rates(&values),
                unit: Some("s".to_owned()),
                stated: None,
                usual: spacing(&sensor.times),
            });
        }
        errors
    }

    /// The best fit in which the sensor has the error, begun with this size of it.
    fn with_error(
        &self,
        sensor: &Sensor,
        error: &SensorError,
        column: &DVector<f64>,
        size: f64,
    ) -> Result<Suspect, NoPrediction> {
        let scale = WIDE * size.abs().max(f64::MIN_POSITIVE);
        let mut problem = self.problem.clone();
        self.free(&mut problem, sensor, column, scale);
        let minimum = self.minimised(&problem, self.model, self.optimum.minimum.places.clone())?;
        let amount = minimum.misfit.sources(&problem).last().copied().unwrap_or(0.0) * scale;
        Ok(Suspect {
            value: amount,
            unit: error.unit.clone(),
            allowed: error.stated.map(|limit| [-limit, limit]),
            departure: (amount / error.stated.unwrap_or(error.usual)).abs(),
            ..self.suspect(error.fault.clone(), &sensor.group.name, &problem, &minimum)
        })
    }

    /// The largest limit that is stated for an error of the sensor.
    fn stated(&self, sensor: &Sensor, kind: SharedKind) -> Option<f64> {
        let channels = self.problem.channels.iter();
        let of_sensor = channels.filter(|channel| channel.kind == kind && sensor.criteria.contains(&channel.name));
        of_sensor.map(|channel| channel.limit).reduce(f64::max)
    }

    /// The middle accuracy of a sensor's values.
    fn accuracy(&self, sensor: &Sensor) -> f64 {
        let values = sensor.group.values.iter();
        let all = values.map(|&[case, quantity]| self.problem.cases[case].measured[quantity].accuracy);
        middle(all.collect(), 0.0)
    }
}
