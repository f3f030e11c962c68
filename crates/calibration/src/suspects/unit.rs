//! Other units, signs and rows of recordings.

use super::{
    super::{
        objective::Objective,
        problem::{NoPrediction, Problem},
        search::unknowns,
    },
    inquiry::{Candidate, Confusion, Inquiry, Sensor, Suspect, Suspicion, WIDE, spacing},
};

impl Inquiry<'_> {
    /// Other units, signs and rows, of which a run of the search says that they may explain much: with the places of that run.
    pub(super) fn units(&self) -> Result<Vec<Candidate<'_>>, NoPrediction> {
        /// A unit is wrong by far or not at all.
        const PART: f64 = 0.25;
        let now = self.optimum.minimum.cost();
        let starts = self.starts.iter().map(|start| unknowns(self.problem, start));
        let places: Vec<Vec<f64>> = starts.chain([self.optimum.minimum.places.clone()]).collect();
        let mut candidates = Vec::new();
        for sensor in self.sensors {
            for confusion in &sensor.confusions {
                let problem = self.read_as(sensor, confusion);
                // All of these runs were made.
                let best = Objective::new(&problem, self.model, self.difference)
                    .misfits(&places)?
                    .iter()
                    .zip(&places)
                    .filter_map(|(misfit, at)| Some((misfit.as_ref().ok()?.cost(), at)))
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    .filter(|(cost, _)| *cost < PART * now);
                candidates.extend(best.map(|(cost, at)| {
                    let at = at.clone();
                    Candidate { fall: now - cost, fit: Box::new(move || self.unit(sensor, confusion, &at)) }
                }));
            }
        }
        candidates.sort_by(|a, b| b.fall.total_cmp(&a.fall));
        candidates.truncate(2);
        Ok(candidates)
    }

    /// The problem with a sensor's values in another unit, or of other rows.
    fn read_as(&self, sensor: &Sensor, confusion: &Confusion) -> Problem {
        const UNKNOWN: f64 = 1e6;
        let mut problem = self.problem.clone();
        let mut rest = &sensor.group.values[..];
        for times in sensor.times.iter().filter(|_| confusion.rows != 0) {
            let (curve, behind) = rest.split_at(times.len());
            rest = behind;
            for (k, &[case, quantity]) in curve.iter().enumerate() {
                let measured = &mut problem.cases[case].measured[quantity];
                match k.checked_add_signed(confusion.rows).and_then(|row| curve.get(row)) {
                    Some(&[there, at]) => measured.value = self.problem.cases[there].measured[at].value,
                    // What was recorded then is not known.
                    None => measured.accuracy *= UNKNOWN,
                }
            }
        }
        for &[case, quantity] in &sensor.group.values {
            let measured = &mut problem.cases[case].measured[quantity];
            measured.value = confusion.factor * measured.value + confusion.offset;
            // Accuracies may be stated in the unit that was meant.
            let factor = confusion.factor.abs().max(1.0);
            measured.accuracy *= factor;
            problem
                .sources
                .iter_mut()
                .flat_map(|source| &mut source.effects)
                .filter(|effect| (effect.case, effect.quantity) == (case, quantity))
                .for_each(|effect| effect.change *= factor);
        }
        problem
    }

    fn unit(&self, sensor: &Sensor, confusion: &Confusion, from: &[f64]) -> Result<Suspect, NoPrediction> {
        /// Units are confused as often as instruments are twice as wrong as stated.
        const ODD: f64 = 2.0;
        let mut problem = self.read_as(sensor, confusion);
        let spacing = spacing(&sensor.times);
        // What is left of a delay by whole rows.
        if confusion.rows != 0 {
            let column = self.column(sensor, &sensor.rates(&self.predicted(sensor)));
            self.free(&mut problem, sensor, &column, WIDE * spacing);
        }
        let minimum = self.minimised(&problem, self.model, from.to_vec())?;
        let fault = match confusion.rows {
            0 => Suspicion::Unit(confusion.words.clone()),
            _ => Suspicion::Delay,
        };
        let known = self.suspect(fault, &sensor.group.name, &problem, &minimum);
        Ok(match confusion.rows as f64 {
            0.0 => Suspect { departure: ODD, ..known },
            rows => {
                let left = minimum.misfit.sources(&problem).last().copied().unwrap_or(0.0) * WIDE;
                let departure = rows + left;
                let unit = Some("s".to_owned());
                Suspect { value: departure * spacing, unit, departure: departure.abs(), ..known }
            }
        })
    }
}
