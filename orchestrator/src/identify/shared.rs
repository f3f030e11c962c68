//! Errors that several values share, as sources of the problem: those of a sensor, and those that a study states as correlated.

use indexmap::IndexMap;

use super::fitted::{FittedCurve, LEAST};
use calibration::problem::{Channel, Effect, SharedKind, Source};
use conformity::uncertainty::{Law, Uncertainty};
use study::judge::{Criterion, Judge};

/// The shared errors as they are gathered.
#[derive(Default)]
pub struct Shared {
    pub sources: Vec<Source>,
    pub channels: Vec<Channel>,
    /// The sources of the sensors: of the offset and of the gain.
    sensors: IndexMap<(String, SharedKind), usize>,
}

impl Shared {
    /// Lists a channel's error. Where the same error of the same sensor is listed already, only the channel's name is added.
    fn tell(&mut self, channel: Channel) {
        match self.channels.iter_mut().find(|known| {
            known.kind == channel.kind
                && known.unit == channel.unit
                && known.sources == channel.sources
                && known.limit == channel.limit
        }) {
            Some(known) => known.name = format!("{} and {}", known.name, channel.name),
            None => self.channels.push(channel),
        }
    }

    /// The number of the source of a sensor's error.
    fn source(&mut self, sensor: String, kind: SharedKind) -> usize {
        *self.sensors.entry((sensor, kind)).or_insert_with(|| {
            self.sources.push(Source::default());
            self.sources.len() - 1
        })
    }

    /// Adds the offset and the gain of a curve's sensor.
    pub fn add(&mut self, recorded: &FittedCurve, (sensor, sign): (String, f64)) {
        let Some(errors) = &recorded.curve.errors else { return };
        let [of_offset, of_gain] = errors.coverage;
        let first = errors.shared.first().copied().unwrap_or(0.0);
        let even = errors.shared.iter().all(|shared| (shared - first).abs() <= 1e-9 * first);
        let (kind, one) = if even { (SharedKind::Offset, first) } else { (SharedKind::Scaled, of_offset.recip()) };
        // An uncertainty in per cent is a part of the value, as a gain's is.
        let values = recorded.curve.values.iter();
        let ratio = first / recorded.curve.values.first().copied().unwrap_or(1.0);
        let is_part = values
            .zip(&errors.shared)
            .all(|(value, shared)| *value > 0.0 && (shared - ratio * value).abs() <= 1e-9 * shared);
        let part_of = |kind| match kind {
            SharedKind::Gain => Some(errors.gain),
            SharedKind::Scaled if is_part => Some(ratio),
            _ => None,
        };
        let offset = errors.shared.clone();
        let gain = recorded.curve.values.iter().map(|value| errors.gain * value).collect();
        let parts =
            [(kind, offset, one, of_offset * one), (SharedKind::Gain, gain, errors.gain, of_gain * errors.gain)];
        for (kind, changes, one, limit) in parts {
            let changes: Vec<f64> = changes;
            if changes.iter().all(|change| *change == 0.0) {
                continue;
            }
            let source = self.source(sensor.clone(), kind);
            let channel = Channel {
                name: recorded.name.as_ref().clone(),
                kind,
                unit: recorded.unit.clone(),
                limit,
                sources: vec![(source, sign * one)],
            };
            let source = &mut self.sources[source];
            source.rectangular |= errors.rectangular && kind != SharedKind::Gain;
            let effects = changes.iter().enumerate().map(|(row, change)| Effect {
                case: 0,
                quantity: recorded.first + row,
                change: sign * change,
                part: part_of(kind).map(|part| sign * part),
            });
            source.effects.extend(effects);
            self.tell(channel);
        }
    }
}

/// The measured values whose errors are correlated: their numbers, and a factor of the matrix of correlations.
pub struct Tied {
    numbers: Vec<usize>,
    factor: Vec<Vec<f64>>,
    /// How many values are means of repeats.
    means: usize,
}

impl Tied {
    pub fn new(judge: &Judge) -> Self {
        let pairs = judge.measurement.correlations();
        let mut numbers: Vec<usize> = pairs.iter().flat_map(|&(a, b, _)| [a, b]).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let place = |number: usize| numbers.binary_search(&number).expect("it is in a pair");
        let count = numbers.len();
        let mut matrix = vec![vec![0.0; count]; count];
        (0..count).for_each(|k| matrix[k][k] = 1.0);
        for &(a, b, coefficient) in pairs {
            let (a, b) = (place(a), place(b));
            (matrix[a][b], matrix[b][a]) = (coefficient, coefficient);
        }
        let factor = factor(&matrix);
        Self {
            means: judge.criteria.iter().filter_map(|criterion| criterion.uncertainty?.repeats).count(),
            numbers,
            factor,
        }
    }

    /// Whether the errors of a criterion are correlated with others'.
    pub fn holds(&self, number: usize) -> bool {
        self.numbers.binary_search(&number).is_ok()
    }

    /// The independent standard uncertainty of a value, number `quantity` of the problem, and its distribution where that is not
    /// normal. What it shares with others becomes sources.
    pub fn value(
        &self,
        number: usize,
        quantity: usize,
        criterion: &Criterion,
        uncertainty: &Uncertainty,
        shared: &mut Shared,
    ) -> (f64, Option<Law>) {
        let law = uncertainty.law(criterion.measured().value.unwrap_or(criterion.limits.about));
        let Ok(place) = self.numbers.binary_search(&number) else {
            let accuracy = law.among(self.means).as_normal();
            return (accuracy, Some(law).filter(|law| !law.is_normal()));
        };
        // A correlation is that of the whole errors, as for the verdict.
        let standard = law.among(self.means).as_normal();
        let mut sources = Vec::new();
        for (column, part) in self.factor[place].iter().enumerate().filter(|(_, part)| **part != 0.0) {
            let source = shared.source(format!("\0{column}"), SharedKind::Offset);
            let change = standard * part;
            shared.sources[source].effects.push(Effect { case: 0, quantity, change, part: None });
            sources.push((source, change));
        }
        shared.tell(Channel {
            name: criterion.name.clone(),
            kind: SharedKind::Offset,
            unit: criterion.unit.clone(),
            limit: uncertainty.coverage * standard,
            sources,
        });
        (LEAST * standard, None)
    }
}

/// The triangular factor `L` of a matrix of correlations `L L'`, also where errors are fully correlated (Cholesky).
fn factor(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    const NOTHING: f64 = 1e-9;
    let mut factor = vec![vec![0.0; matrix.len()]; matrix.len()];
    for column in 0..matrix.len() {
        let left = |row: usize, factor: &[Vec<f64>]| {
            let known = factor[row][..column].iter().zip(&factor[column][..column]);
            matrix[row][column] - known.map(|(a, b)| a * b).sum::<f64>()
        };
        let square = left(column, &factor);
        if square <= NOTHING {
            continue;
        }
        for row in column..matrix.len() {
            factor[row][column] = left(row, &factor) / square.sqrt();
        }
    }
    factor
}
