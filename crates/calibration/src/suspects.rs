//! What would explain a misfit: one thing at a time that the search took as given.
//!
//! A fit that misses names no culprit: all unknowns bend as far as they may. So each suspect gets free play alone: a parameter
//! beyond its range, the offset, gain or delay of a sensor, a constant of the model, another unit. Around the optimum the
//! problem is linear, and the score test (Rao 1948, Proc. Camb. Phil. Soc. 44, 50-57; "modification index" in Sorbom 1989,
//! Psychometrika 54, 371-384) says by how much the sum of squares would fall. The most promising ones are then fitted by runs:
//! what is told has been simulated.

use std::{collections::HashSet, mem::discriminant};

use nalgebra::{Cholesky, DMatrix, DVector};
use sampling::statistics::moments::sorted;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{
    errors::Errors,
    expected::Expected,
    influence::Group,
    local::{Limits, Minimum, minimise},
    objective::{Differences, Objective},
    optima::Optimum,
    problem::{Effect, Free, NoPrediction, Problem, SharedKind, Simulate, Source, Spacing},
    remembered::Remembered,
    search::unknowns,
};

/// What may be wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// A parameter is beyond its range, or farther from where it was expected than its distribution allows.
    Range,
    /// A constant of the model is another one.
    Constant,
    /// A sensor has a zero error.
    Offset,
    /// A sensor has a gain error.
    Gain,
    /// A recording is late.
    Delay,
    /// A recording is in another unit, or has the other sign: in words.
    Unit(String),
}

/// A suspect: what is wrong, how far, and what is explained then.
#[derive(Clone, Debug, Serialize)]
pub struct Suspect {
    /// What may be wrong.
    pub fault: Fault,
    /// With which parameter or sensor.
    pub name: String,
    /// The parameter's value; of a sensor what it adds to the values, by which part it enlarges them, or by how many seconds it is
    /// late; 0 of a unit.
    pub value: f64,
    /// The unit of the value.
    pub unit: Option<String>,
    /// What was allowed: the parameter's range, or the constant's value twice; of a sensor what is stated, if it is.
    pub allowed: Option<[f64; 2]>,
    /// How far it is from that, as a multiple of it.
    pub departure: f64,
    /// The sum of squares before and after.
    pub cost: [f64; 2],
    /// The probability that a right model misses by more than what is left.
    pub probability: Option<f64>,
}

impl Suspect {
    /// Whether nothing is left to be explained.
    pub fn explains(&self) -> bool {
        const LEFT: f64 = 0.01;
        self.probability.is_none_or(|probability| probability >= LEFT)
    }

    /// Half the sum of squares that is left, and how odd such a fault is: the less, the likelier.
    fn rank(&self) -> f64 {
        0.5 * self.cost[1] + self.departure.powi(2).ln_1p()
    }
}

/// A measured channel whose sensor may be at fault.
#[derive(Clone, Debug)]
pub struct Sensor {
    /// Its values.
    pub group: Group,
    /// The criteria that it measures.
    pub criteria: Vec<String>,
    /// Their unit.
    pub unit: Option<String>,
    /// Their times, s, curve by curve in the order of the values; empty where they are none.
    pub times: Vec<Vec<f64>>,
    /// What its unit may be mistaken for.
    pub confusions: Vec<Confusion>,
}

impl Sensor {
    /// By how much its values fall, a second, curve by curve.
    fn rates(&self, values: &[f64]) -> Vec<f64> {
        let mut rest = values;
        self.times
            .iter()
            .flat_map(|times| {
                let (own, behind) = rest.split_at(times.len());
                rest = behind;
                (0..own.len()).map(|k| {
                    let [from, to] = [k.saturating_sub(1), (k + 1).min(own.len() - 1)];
                    (own[from] - own[to]) / (times[to] - times[from]).max(f64::MIN_POSITIVE)
                })
            })
            .collect()
    }
}

/// Another reading of a channel's values.
#[derive(Clone, Debug)]
pub struct Confusion {
    /// The other value is this times the given one, and `offset`.
    pub factor: f64,
    /// What is added then.
    pub offset: f64,
    /// By so many rows its curves are recorded late.
    pub rows: isize,
    /// The reading in words; a delay needs none.
    pub words: String,
}

/// A constant of the model that could be another one, or an error of a recorded input's sensor, which is thought to be 0.
pub struct Constant<'a> {
    /// What would be wrong.
    pub fault: Fault,
    /// So far off is as odd as the whole of what was stated of another; 0: no such distance is known.
    pub usual: f64,
    /// Its name, unit and a range around the value that it has, within what the model allows.
    pub free: Free,
    /// The value that it has.
    pub value: f64,
    /// Another value, and what the model predicts at the optimum with that, case by case.
    pub moved: (f64, Vec<Vec<f64>>),
    /// The model that takes it as a last free parameter.
    pub model: Box<dyn Simulate + 'a>,
}

/// What is looked at.
pub struct Inquiry<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// The distance of simulations for a derivative, as a part of that of the bounds.
    pub difference: f64,
    /// Where the search began.
    pub starts: &'a [Vec<f64>],
    /// The optimum that misses.
    pub optimum: &'a Optimum,
    /// The model of that search.
    pub model: &'a dyn Simulate,
    /// The measured channels.
    pub sensors: &'a [Sensor],
    /// How far each free parameter may go in the model.
    pub reach: &'a [[f64; 2]],
    /// Constants of the model.
    pub constants: &'a [Constant<'a>],
}

/// So many suspects are fitted.
const FITTED: usize = 6;

/// The prior of a freed error is so much wider than the error.
const WIDE: f64 = 30.0;

/// A suspect before it is fitted.
struct Candidate {
    what: What,
    /// By how much the sum of squares would fall.
    fall: f64,
    /// Where the change would lead to: a place, or an amount.
    size: f64,
}

enum What {
    Range(usize),
    Constant(usize),
    Sensor(usize, Fault, DVector<f64>),
    Unit(usize, usize, Vec<f64>),
}

impl Inquiry<'_> {
    /// What would explain the misfit, the likeliest first; none where nothing does much.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn suspects(&self) -> Result<Vec<Suspect>, NoPrediction> {
        let Some(linear) = Linear::new(self) else { return Ok(Vec::new()) };
        let mut candidates = self.ranges(&linear);
        candidates.extend(self.of_sensors(&linear));
        candidates.extend(self.of_constants(&linear));
        let units = self.units()?;
        let tried = (candidates.len() + units.len()).max(1);
        candidates.sort_by(|a, b| b.fall.total_cmp(&a.fall));
        candidates.truncate(FITTED);
        candidates.extend(units);
        let mut suspects = Vec::new();
        for candidate in &candidates {
            suspects.extend(self.fitted(candidate)?);
        }
        let excess = |cost: f64| cost - linear.freedom;
        let chance = |fall: f64| ChiSquared::new(1.0).map_or(1.0, |law| law.sf(fall.max(0.0)));
        suspects.retain(|suspect: &Suspect| {
            let [before, after] = suspect.cost;
            chance(before - after) * (tried as f64) < 0.01 && excess(after) < 0.5 * excess(before)
        });
        suspects.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
        // A delay is looked for by rows and by slopes.
        let mut seen = HashSet::new();
        suspects.retain(|suspect| seen.insert((discriminant(&suspect.fault), suspect.name.clone())));
        Ok(suspects)
    }

    /// Parameters that are at a bound, or far from where they were expected, and would go on.
    fn ranges(&self, linear: &Linear) -> Vec<Candidate> {
        const FAR: f64 = 2.0;
        let free = self.problem.free.iter().enumerate().zip(&self.optimum.minimum.places);
        free.filter_map(|((k, free), &place)| {
            let known = free.prior_place().map(|(centre, deviation)| (place - centre) / deviation);
            let (fall, size) = linear.score(&linear.slopes.column(k).into_owned(), Some(k))?;
            let outward = (place <= 0.0 && size < 0.0) || (place >= 1.0 && size > 0.0);
            let far = known.is_some_and(|known| known.abs() > FAR && known * size > 0.0);
            let fall = fall + known.map_or(0.0, |known| known.powi(2));
            (outward || far).then_some(Candidate { what: What::Range(k), fall, size: place + size })
        })
        .collect()
    }

    /// Offsets, gains and delays of sensors.
    fn of_sensors(&self, linear: &Linear) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        for (number, sensor) in self.sensors.iter().enumerate() {
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
                    candidates.push(Candidate { what: What::Sensor(number, fault, column), fall, size });
                }
            }
        }
        candidates
    }

    /// What a pattern of a sensor's values is among all values.
    fn column(&self, sensor: &Sensor, pattern: Vec<f64>) -> DVector<f64> {
        let mut column = DVector::zeros(self.problem.values());
        for (&[case, quantity], part) in sensor.group.values.iter().zip(pattern) {
            column[case * self.problem.quantities.len() + quantity] = part;
        }
        column
    }

    /// Frees an error of a sensor that moves its values along a column. Its prior is so wide that it costs nothing.
    fn free(&self, problem: &mut Problem, sensor: &Sensor, column: &DVector<f64>, scale: f64) {
        let quantities = self.problem.quantities.len();
        let effects = sensor
            .group
            .values
            .iter()
            .map(|&[case, quantity]| {
                let change = scale * column[case * quantities + quantity];
                Effect { case, quantity, change, part: None }
            })
            .collect();
        problem.sources.push(Source { effects, rectangular: false });
    }

    /// Constants, each by the run with another value.
    fn of_constants(&self, linear: &Linear) -> Vec<Candidate> {
        let predicted = &self.optimum.minimum.misfit.predicted;
        self.constants
            .iter()
            .enumerate()
            .filter_map(|(number, constant)| {
                let (other, moved) = &constant.moved;
                let [here, there] = [constant.value, *other].map(|value| constant.free.place(value));
                let column = predicted
                    .iter()
                    .flatten()
                    .zip(moved.iter().flatten())
                    .map(|(old, new)| (new - old) / (there - here));
                let column = DVector::from_iterator(linear.accuracies.len(), column).component_div(&linear.accuracies);
                let (fall, size) = linear.score(&column, None)?;
                Some(Candidate { what: What::Constant(number), fall, size: here + size })
            })
            .collect()
    }

    /// Other units, signs and rows, of which a run of the search says that they may explain much: with the places of that run.
    fn units(&self) -> Result<Vec<Candidate>, NoPrediction> {
        /// A unit is wrong by far or not at all.
        const PART: f64 = 0.25;
        let now = self.optimum.minimum.cost();
        let starts = self.starts.iter().map(|start| unknowns(self.problem, start));
        let places: Vec<Vec<f64>> = starts.chain([self.optimum.minimum.places.clone()]).collect();
        let mut candidates = Vec::new();
        for (number, sensor) in self.sensors.iter().enumerate() {
            for (which, confusion) in sensor.confusions.iter().enumerate() {
                let problem = self.read_as(sensor, confusion);
                // All of these runs were made.
                let best = Objective::new(&problem, self.model, self.difference)
                    .misfits(&places)?
                    .iter()
                    .zip(&places)
                    .filter_map(|(misfit, at)| Some((misfit.as_ref().ok()?.cost(), at)))
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    .filter(|(cost, _)| *cost < PART * now);
                candidates.extend(best.map(|(cost, at)| Candidate {
                    what: What::Unit(number, which, at.clone()),
                    fall: now - cost,
                    size: 0.0,
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

    /// A suspect, fitted by runs; none where they fail.
    fn fitted(&self, candidate: &Candidate) -> Result<Option<Suspect>, NoPrediction> {
        let fitted = match &candidate.what {
            What::Range(k) => self.beyond(*k, candidate.size),
            What::Constant(number) => self.constant(&self.constants[*number], candidate.size),
            What::Sensor(number, fault, pattern) => self.sensor(&self.sensors[*number], fault, pattern, candidate.size),
            What::Unit(number, which, from) => self.unit(&self.sensors[*number], *which, from),
        };
        match fitted {
            Err(NoPrediction::Here(_)) => Ok(None),
            ended => ended.map(Some),
        }
    }

    fn minimised(&self, problem: &Problem, model: &dyn Simulate, start: Vec<f64>) -> Result<Minimum, NoPrediction> {
        let limits = Limits { iterations: 30, decrease: 1e-4 };
        let objective = Objective::new(problem, model, self.difference);
        minimise(&objective, start, &[], Differences::Forward, &limits)
    }

    /// The suspect of a minimum.
    fn suspect(&self, fault: Fault, name: &str, problem: &Problem, minimum: &Minimum) -> Suspect {
        let more = usize::from(matches!(fault, Fault::Offset | Fault::Gain | Fault::Delay));
        let after = minimum.cost();
        Suspect {
            fault,
            name: name.to_owned(),
            value: 0.0,
            unit: None,
            allowed: None,
            departure: 0.0,
            cost: [self.optimum.minimum.cost(), after],
            probability: expected(problem, minimum, more).chance(after),
        }
    }

    /// A parameter with a wider range and without a prior.
    fn beyond(&self, k: usize, place: f64) -> Result<Suspect, NoPrediction> {
        let old = &self.problem.free[k];
        // The others are at their bounds here, and leave these once it moves: so it may go much farther than the slopes say.
        let ends = [4.0 * place.min(0.0) - 5.0, 4.0 * place.max(1.0) + 2.0].map(|place| wide(old, place));
        let mut free = Free { prior: None, ..old.clone() };
        [free.min, free.max] = [ends[0].max(self.reach[k][0]), ends[1].min(self.reach[k][1])];
        // What is positive stays so.
        if old.min > 0.0 {
            free.min = free.min.max(0.05 * old.min);
        }
        let mut problem = self.problem.clone();
        let mut start = self.optimum.minimum.places.clone();
        start[k] = free.place(old.value(start[k]));
        problem.free[k] = free;
        let minimum = self.minimised(&problem, self.model, start)?;
        let value = problem.free[k].value(minimum.places[k]);
        let outside = match old.prior_place() {
            Some((centre, deviation)) => ((old.place(value) - centre) / (2.0 * deviation)).abs(),
            None => 2.0 * (old.place(value) - old.place(value).clamp(0.0, 1.0)).abs(),
        };
        let allowed = match old.prior {
            Some(prior) if old.scale == Spacing::Linear => {
                [-2.0, 2.0].map(|side| (prior.centre + side * prior.spread).clamp(old.min, old.max))
            }
            _ => [old.min, old.max],
        };
        Ok(Suspect {
            value,
            unit: old.unit.clone(),
            allowed: Some(allowed),
            departure: outside,
            ..self.suspect(Fault::Range, &old.name, &problem, &minimum)
        })
    }

    fn constant(&self, constant: &Constant, place: f64) -> Result<Suspect, NoPrediction> {
        let free = &constant.free;
        let last = self.problem.free.len();
        let mut problem = self.problem.clone();
        problem.free.push(free.clone());
        let mut start = self.optimum.minimum.places.clone();
        start.insert(last, place.clamp(0.02, 0.98));
        let model = Remembered::new(&*constant.model, []);
        let minimum = self.minimised(&problem, &model, start)?;
        let value = free.value(minimum.places[last]);
        let departure = match constant.usual {
            0.0 => 2.0,
            usual => ((value - constant.value) / usual).abs(),
        };
        Ok(Suspect {
            value,
            unit: free.unit.clone(),
            allowed: (constant.fault == Fault::Constant).then_some([constant.value; 2]),
            departure,
            ..self.suspect(constant.fault.clone(), &free.name, &problem, &minimum)
        })
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

    fn unit(&self, sensor: &Sensor, which: usize, from: &[f64]) -> Result<Suspect, NoPrediction> {
        /// Units are confused as often as instruments are twice as wrong as stated.
        const ODD: f64 = 2.0;
        let confusion = &sensor.confusions[which];
        let mut problem = self.read_as(sensor, confusion);
        let spacing = spacing(&sensor.times);
        // What is left of a delay by whole rows.
        if confusion.rows != 0 {
            let column = self.column(sensor, sensor.rates(&self.predicted(sensor)));
            self.free(&mut problem, sensor, &column, WIDE * spacing);
        }
        let minimum = self.minimised(&problem, self.model, from.to_vec())?;
        let fault = match confusion.rows {
            0 => Fault::Unit(confusion.words.clone()),
            _ => Fault::Delay,
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

    /// A sensor's values at the optimum.
    fn predicted(&self, sensor: &Sensor) -> Vec<f64> {
        let predicted = &self.optimum.minimum.misfit.predicted;
        sensor.group.values.iter().map(|&[case, quantity]| predicted[case][quantity]).collect()
    }

    /// The middle accuracy of a sensor's values.
    fn accuracy(&self, sensor: &Sensor) -> f64 {
        let values = sensor.group.values.iter();
        let all = values.map(|&[case, quantity]| self.problem.cases[case].measured[quantity].accuracy);
        middle(all.collect(), 0.0)
    }
}

/// What is expected of the sum of squares at a minimum, with so many more unknowns than those between their bounds.
fn expected(problem: &Problem, minimum: &Minimum, more: usize) -> Expected {
    let inside = minimum.places.iter().filter(|place| **place > 0.0 && **place < 1.0).count();
    let squares = minimum.misfit.residuals.len() - problem.sources.len();
    Expected::new(problem, squares, inside + more)
}

/// A value at a place that may be outside of the bounds.
fn wide(free: &Free, place: f64) -> f64 {
    match free.scale {
        Spacing::Linear => free.min + place * (free.max - free.min),
        Spacing::Log => free.min * (free.max / free.min).powf(place),
    }
}

/// The middle distance of times.
fn spacing(times: &[Vec<f64>]) -> f64 {
    let all = times.iter().flat_map(|times| times.windows(2)).map(|pair| pair[1] - pair[0]);
    middle(all.collect(), 1.0)
}

/// The middle one of some values, or another value where there are none.
fn middle(values: Vec<f64>, without: f64) -> f64 {
    let values = sorted(values);
    values.get(values.len() / 2).copied().unwrap_or(without)
}

/// The linear problem at the optimum, with the shared errors as unknowns. An unknown at a bound is known.
struct Linear<'a> {
    slopes: &'a DMatrix<f64>,
    /// The effects of the shared errors, a row a value.
    effects: DMatrix<f64>,
    accuracies: DVector<f64>,
    residuals: DVector<f64>,
    full: DMatrix<f64>,
    open: Vec<usize>,
    /// The degrees of freedom.
    freedom: f64,
}

impl<'a> Linear<'a> {
    fn new(inquiry: &Inquiry<'a>) -> Option<Self> {
        let (problem, minimum) = (inquiry.problem, &inquiry.optimum.minimum);
        let posterior = &inquiry.optimum.posterior;
        let (errors, values) = (Errors::new(problem), problem.values());
        let (full, open) = inquiry.optimum.precision(&errors);
        let mut effects = DMatrix::zeros(values, problem.sources.len());
        let quantities = problem.quantities.len();
        for value in 0..values {
            let row = errors.effects(value / quantities, value % quantities);
            effects.set_row(value, &row.transpose());
        }
        let accuracies = problem.cases.iter().flat_map(|case| &case.measured).map(|measured| measured.accuracy);
        (values > 0).then(|| Self {
            slopes: &posterior.slopes[0],
            effects,
            accuracies: DVector::from_iterator(values, accuracies),
            residuals: minimum.misfit.residuals.rows(0, values).into_owned(),
            full,
            open,
            freedom: expected(problem, minimum, 0).freedom,
        })
    }

    /// By how much the sum of squares falls if a further unknown moves the misfits along a column, and how far that goes; without
    /// the unknown `but`, whose column it is. None where the others do the same.
    fn score(&self, column: &DVector<f64>, but: Option<usize>) -> Option<(f64, f64)> {
        /// Less than this part of a column is left of one that the others make up.
        const LEFT: f64 = 1e-6;
        let n = self.slopes.ncols();
        let along_all = [self.slopes.tr_mul(column), self.effects.tr_mul(column)];
        let open: Vec<usize> = self.open.iter().copied().filter(|k| Some(*k) != but).collect();
        let along = DVector::from_iterator(
            open.len(),
            open.iter().map(|&k| if k < n { along_all[0][k] } else { along_all[1][k - n] }),
        );
        let factor = Cholesky::new(self.full.select_rows(&open).select_columns(&open))?;
        let square = column.norm_squared();
        let own = square - along.dot(&factor.solve(&along));
        let pull = column.dot(&self.residuals);
        (own > LEFT * square).then(|| (pull * pull / own, -pull / own))
    }
}

#[cfg(test)]
#[path = "suspects_tests.rs"]
mod tests;
