//! What is asked of a fit that misses, and what the kinds of suspects share.

use nalgebra::DVector;
use sampling::statistics::moments::sorted;
use serde::Serialize;

use super::super::{
    expected::Expected,
    influence::Group,
    local::{Limits, Minimum, minimise},
    objective::{Differences, Objective},
    optima::Optimum,
    problem::{Effect, Free, NoPrediction, Problem, Simulate, Source},
};

/// What may be wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Suspicion {
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
    pub fault: Suspicion,
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
    pub(super) fn rank(&self) -> f64 {
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
    pub(super) fn rates(&self, values: &[f64]) -> Vec<f64> {
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
    pub fault: Suspicion,
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

/// The prior of a freed error is so much wider than the error.
pub const WIDE: f64 = 30.0;

/// A suspect before it is fitted.
pub struct Candidate<'a> {
    /// By how much the sum of squares would fall.
    pub fall: f64,
    /// Fits it by runs.
    pub fit: Box<dyn Fn() -> Result<Suspect, NoPrediction> + 'a>,
}

impl Inquiry<'_> {
    /// What a pattern of a sensor's values is among all values.
    pub(super) fn column(&self, sensor: &Sensor, pattern: &[f64]) -> DVector<f64> {
        let mut column = DVector::zeros(self.problem.values());
        for (&[case, quantity], part) in sensor.group.values.iter().zip(pattern) {
            column[case * self.problem.quantities.len() + quantity] = *part;
        }
        column
    }

    /// Frees an error of a sensor that moves its values along a column. Its prior is so wide that it costs nothing.
    pub(super) fn free(&self, problem: &mut Problem, sensor: &Sensor, column: &DVector<f64>, scale: f64) {
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

    pub(super) fn minimised(
        &self,
        problem: &Problem,
        model: &dyn Simulate,
        start: Vec<f64>,
    ) -> Result<Minimum, NoPrediction> {
        let limits = Limits { iterations: 30, decrease: 1e-4 };
        let objective = Objective::new(problem, model, self.difference);
        minimise(&objective, start, &[], Differences::Forward, &limits)
    }

    /// The suspect of a minimum.
    pub(super) fn suspect(&self, fault: Suspicion, name: &str, problem: &Problem, minimum: &Minimum) -> Suspect {
        let more = usize::from(matches!(fault, Suspicion::Offset | Suspicion::Gain | Suspicion::Delay));
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

    /// A sensor's values at the optimum.
    pub(super) fn predicted(&self, sensor: &Sensor) -> Vec<f64> {
        let predicted = &self.optimum.minimum.misfit.predicted;
        sensor.group.values.iter().map(|&[case, quantity]| predicted[case][quantity]).collect()
    }
}

/// What is expected of the sum of squares at a minimum, with so many more unknowns than those between their bounds.
pub fn expected(problem: &Problem, minimum: &Minimum, more: usize) -> Expected {
    let inside = minimum.places.iter().filter(|place| **place > 0.0 && **place < 1.0).count();
    let squares = minimum.misfit.residuals.len() - problem.sources.len();
    Expected::new(problem, squares, inside + more)
}

/// The middle distance of times.
pub fn spacing(times: &[Vec<f64>]) -> f64 {
    let all = times.iter().flat_map(|times| times.windows(2)).map(|pair| pair[1] - pair[0]);
    middle(all.collect(), 1.0)
}

/// The middle one of some values, or another value where there are none.
pub fn middle(values: Vec<f64>, without: f64) -> f64 {
    let values = sorted(values);
    values.get(values.len() / 2).copied().unwrap_or(without)
}
