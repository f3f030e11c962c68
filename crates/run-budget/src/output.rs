//! One output of the model: the processes that may be it, checked by leaving runs out.

use crate::fit::{Summit, members};
use crate::process::{Data, Draws, Process};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sampling::random::{Purpose, Random};
use sampling::statistics::moments::{mean, sorted, variance};

/// Processes of the sample.
const MEMBERS: usize = 8;
/// Points that are worked on at a time.
const CHUNK: usize = 500;

/// What leaving runs out says of an output's surrogate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Check {
    /// Root mean square of the errors when each run is left out, in the output's unit.
    pub error: f64,
    /// The same over the deviation of the output among its runs.
    pub relative: f64,
    /// The part of the runs that the 95 % band without them held.
    pub held: f64,
    /// By how much all deviations were widened, so that the errors of runs left out fit them.
    pub widening: f64,
    /// The part of the output's variance that is no smooth function of the parameters: noise, or jumps too fine to follow.
    pub noise: f64,
}

/// A fitted output.
#[derive(Clone, Debug)]
pub struct Output {
    data: Data,
    members: Vec<Process>,
    summits: Vec<Summit>,
    centre: f64,
    /// The deviation of the values; 1 where they are all the same.
    pub unit: f64,
    /// Mean and deviation at each run by the others.
    pub left_out: Vec<[f64; 2]>,
    /// The check by leaving runs out.
    pub check: Check,
}

impl Output {
    /// Fits points (one a column, standardised) and values. `None` where no process fits.
    pub fn fit(points: DMatrix<f64>, values: &[f64], earlier: Option<&Self>, seed: u64, stream: u32) -> Option<Self> {
        let n = values.len() as f64;
        let (centre, spread) = (mean(values), variance(values, 0).sqrt());
        let unit = if spread > 0.0 { spread } else { 1.0 };
        let standard = DVector::from_iterator(values.len(), values.iter().map(|v| (v - centre) / unit));
        let data = Data::new(points, standard);
        let mut random = Random::new(seed, Purpose::Surrogate, stream);
        let (members, summits) = members(&data, MEMBERS, earlier.map_or(&[], |e| &e.summits), &mut random);
        let best = members.first()?;
        let left_out = best.left_out();
        let squares: f64 = left_out.iter().map(|[e, _]| e * e).sum();
        let scores = sorted(left_out.iter().map(|[e, s]| (e / s).abs()).collect());
        let held = scores.iter().filter(|z| **z <= 1.96).count() as f64 / n;
        let mean_square = (scores.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
        // Errors with heavy tails (kinks, jumps) are not normal: the band has to reach their 95th percentile.
        let tail = scores[((0.95 * n) as usize).min(scores.len() - 1)] / 1.96;
        let noise = (best.nugget() * best.variance).min(1.0);
        // Length scales, interaction and nugget were tuned on the runs left out, so that errors come out too small.
        let tuned = (best.unknowns.len() as f64 / n).min(0.75);
        let widening = mean_square.max(tail).max(1.0) / (1.0 - tuned).sqrt();
        let relative = (squares / n).sqrt();
        let check = Check { error: unit * relative, relative, held, widening, noise };
        let by_others =
            |(value, [error, deviation]): (&f64, &[f64; 2])| [value - unit * error, check.widening * unit * deviation];
        let left_out = values.iter().zip(&left_out).map(by_others).collect();
        Some(Self { data, members, summits, centre, unit, left_out, check })
    }

    /// Means and deviations of the function by each member, in the output's unit, without noise.
    pub fn predict(&self, points: &DMatrix<f64>) -> Vec<Vec<[f64; 2]>> {
        self.members.iter().map(|process| self.of(process, points)).collect()
    }

    /// The same by the most probable member.
    pub fn at_once(&self, points: &DMatrix<f64>) -> Vec<[f64; 2]> {
        self.of(&self.members[0], points)
    }

    fn of(&self, process: &Process, points: &DMatrix<f64>) -> Vec<[f64; 2]> {
        let parts = in_chunks(points, |columns| process.predict(&columns));
        let factor = self.check.widening * self.unit;
        let in_unit = |[mean, deviation]: [f64; 2]| [self.centre + self.unit * mean, factor * deviation];
        parts.into_iter().map(in_unit).collect()
    }

    /// Means by the most probable member, in the output's unit.
    pub fn means(&self, points: &DMatrix<f64>) -> Vec<f64> {
        let means = in_chunks(points, |columns| self.members[0].means(&columns).as_slice().to_vec());
        means.into_iter().map(|mean| self.centre + self.unit * mean).collect()
    }

    /// So many functions that the output may be from each member.
    pub fn functions(&self, each: usize, seed: u64, stream: u32) -> Functions<'_> {
        let mut random = Random::new(seed, Purpose::Surrogate, stream);
        let mut draws = Vec::new();
        for process in &self.members {
            draws.push(process.draws(&self.data, each, self.check.widening, &mut random));
        }
        Functions { output: self, draws }
    }
}

/// What is told of each of many points, a column a point.
fn in_chunks<T: Send>(points: &DMatrix<f64>, told: impl Fn(DMatrix<f64>) -> Vec<T> + Sync) -> Vec<T> {
    let starts: Vec<usize> = (0..points.ncols()).step_by(CHUNK).collect();
    let chunk = |&start: &usize| told(points.columns(start, CHUNK.min(points.ncols() - start)).into_owned());
    starts.par_iter().flat_map(chunk).collect()
}

/// Functions that an output may be.
pub struct Functions<'a> {
    output: &'a Output,
    draws: Vec<Draws<'a>>,
}

impl Functions<'_> {
    /// Values in the output's unit: a row a point, a column a function.
    pub fn at(&self, points: &DMatrix<f64>) -> DMatrix<f64> {
        let parts: Vec<DMatrix<f64>> = self.draws.par_iter().map(|draws| draws.at(points)).collect();
        let count: usize = parts.iter().map(DMatrix::ncols).sum();
        let mut values = DMatrix::zeros(points.ncols(), count);
        let mut start = 0;
        for part in parts {
            values.columns_mut(start, part.ncols()).copy_from(&part);
            start += part.ncols();
        }
        values.apply(|v| *v = self.output.centre + self.output.unit * *v);
        values
    }

    /// The deviation of the noise of each function.
    pub fn noise(&self) -> Vec<f64> {
        self.draws.iter().flat_map(|d| d.errors.iter().map(|e| e * self.output.unit)).collect()
    }
}
