//! Offsets, gains and delays of sensors.

use nalgebra::DVector;

use super::{
    super::problem::{NoPrediction, SharedKind},
    inquiry::{Candidate, Fault, Inquiry, Sensor, Suspect, WIDE, middle, spacing},
    linear::Linear,
};

impl Inquiry<'_> {
    /// Offsets, gains and delays of sensors.
    pub(super) fn of_sensors(&self, linear: &Linear) -> Vec<Candidate<'_>> {
        let mut candidates = Vec::new();
        for sensor in self.sensors {
            let values = self.predicted(sensor);
            let mut patterns = vec![(Fault::Offset, vec![1.0; values.len()])];
            if values.len() > 2 {
                patterns.push((Fault::Gain, values.clone()));
            }
            if !sensor.times.is_empty() && values.len() > 4 {
                patterns.push((Fault::Delay, sensor.rates(&values)));
            }
            for (fault, pattern) in patterns {
                let column = self.column(sensor, pattern);
                let weighted = column.component_div(&linear.accuracies);
                if let Some((fall, size)) = linear.score(&weighted, None) {
                    let fit = Box::new(move || self.sensor(sensor, &fault, &column, size));
                    candidates.push(Candidate { fall, fit });
                }
            }
        }
        candidates
    }

    fn sensor(
        &self,
        sensor: &Sensor,
        fault: &Fault,
        pattern: &DVector<f64>,
        size: f64,
    ) -> Result<Suspect, NoPrediction> {
        let scale = WIDE * size.abs().max(f64::MIN_POSITIVE);
        let mut problem = self.problem.clone();
        self.free(&mut problem, sensor, pattern, scale);
        let minimum = self.minimised(&problem, self.model, self.optimum.minimum.places.clone())?;
        let amount = minimum.misfit.sources(&problem).last().copied().unwrap_or(0.0) * scale;
        let kind = match fault {
            Fault::Gain => SharedKind::Gain,
            _ => SharedKind::Offset,
        };
        let channels = self.problem.channels.iter();
        let is_its = |name: &str| sensor.criteria.iter().any(|criterion| criterion == name);
        let stated = channels
            .filter(|channel| is_its(&channel.name) && channel.kind == kind)
            .map(|channel| channel.limit)
            .reduce(f64::max)
            .filter(|_| *fault != Fault::Delay);
        let usual = match fault {
            Fault::Gain => 0.02,
            Fault::Delay => spacing(&sensor.times),
            _ => 2.0 * self.accuracy(sensor),
        };
        Ok(Suspect {
            value: amount,
            unit: match fault {
                Fault::Gain => None,
                Fault::Delay => Some("s".to_owned()),
                _ => sensor.unit.clone(),
            },
            allowed: stated.map(|stated| [-stated, stated]),
            departure: (amount / stated.unwrap_or(usual)).abs(),
            ..self.suspect(fault.clone(), &sensor.group.name, &problem, &minimum)
        })
    }

    /// The middle accuracy of a sensor's values.
    fn accuracy(&self, sensor: &Sensor) -> f64 {
        let values = sensor.group.values.iter();
        let all = values.map(|&[case, quantity]| self.problem.cases[case].measured[quantity].accuracy);
        middle(all.collect(), 0.0)
    }
}
