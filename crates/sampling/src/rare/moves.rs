//! Moves of a chain that keep the standard normal distribution: conditional sampling (Papaioannou, Betz, Zwirglmaier and
//! Straub 2015, "MCMC algorithms for subset simulation").
//!
//! Along each axis a point is drawn a little towards the centre, and normal noise is added that makes up for it. The
//! standard normal distribution looks the same from all sides, so that the axes may be turned: here they are those of the
//! scatter of the points that the chains begin with, and the steps are as wide as this scatter.

use super::scatter::Scatter;
use crate::random::Random;

/// How often a move should be accepted (Roberts and Rosenthal 2001).
const ACCEPTED: f64 = 0.44;
/// Steps wider than this many deviations of the scatter are not needed: they hardly depend on where they begin.
const WIDEST: f64 = 3.0;
/// The first steps look for a good width, later ones refine it.
const FIRST: u64 = 3;

/// Moves of the chains of a population.
#[derive(Debug)]
pub(super) struct Moves {
    axes: Vec<Vec<f64>>,
    spreads: Vec<f64>,
    /// The width of a step in deviations of the scatter.
    pub(super) width: f64,
    steps: u64,
}

impl Moves {
    /// Moves along the axes of a population.
    pub(super) fn along(points: &[Vec<f64>], width: f64) -> Self {
        let scatter = Scatter::of(points, &vec![1.0; points.len()]);
        let spreads = scatter.variances.iter().map(|v| v.sqrt().min(1.0));
        Self {
            spreads: spreads.collect(),
            axes: scatter.axes,
            width,
            steps: 0,
        }
    }

    /// The next point of a chain, if it is accepted. `scale` is the deviation of the normal distribution that is kept.
    pub(super) fn from(&self, point: &[f64], scale: f64, random: &mut Random) -> Vec<f64> {
        let mut next = vec![0.0; point.len()];
        for (axis, spread) in self.axes.iter().zip(&self.spreads) {
            let step = (self.width * spread).min(1.0);
            let place: f64 = axis.iter().zip(point).map(|(a, x)| a * x).sum();
            let moved = (1.0 - step * step).sqrt() * place + step * scale * random.normal();
            for (x, a) in next.iter_mut().zip(axis) {
                *x += moved * a;
            }
        }
        next
    }

    /// Makes steps narrower where too few of them are accepted, and wider where too many are.
    pub(super) fn adapt(&mut self, accepted: f64) {
        self.steps += 1;
        let gain = if self.steps <= FIRST { 3.0 } else { 1.0 };
        self.width = (self.width * (gain * (accepted - ACCEPTED)).exp()).min(WIDEST);
    }
}
