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
const FIRST: u64 = 6;
/// The part of the parameters that move at a time.
const SOME: f64 = 0.5;

/// Moves of the chains of a population: by turns of all axes of its scatter, and of some of the parameters themselves. Where
/// a region's own axes are not those of a population that lies in many, only the latter bring the parameters that do not
/// matter far from where they were.
#[derive(Debug)]
pub(super) struct Moves {
    axes: Vec<Vec<f64>>,
    spreads: Vec<f64>,
    /// The width of a step of either kind, in deviations.
    pub(super) widths: [f64; 2],
    steps: u64,
}

impl Moves {
    /// Moves along the axes of a population.
    pub(super) fn along(points: &[Vec<f64>], widths: [f64; 2]) -> Self {
        let scatter = Scatter::of(points, &vec![1.0; points.len()]);
        let spreads = scatter.variances.iter().map(|v| v.sqrt().min(1.0));
        Self { spreads: spreads.collect(), axes: scatter.axes, widths, steps: 0 }
    }

    /// Which kind is next.
    fn kind(&self) -> usize {
        (self.steps % 2) as usize
    }

    /// The next point of a chain, if it is accepted. `scale` is the deviation of the normal distribution that is kept.
    pub(super) fn from(&self, point: &[f64], scale: f64, random: &mut Random) -> Vec<f64> {
        let width = self.widths[self.kind()];
        let moved = |place: f64, spread: f64, random: &mut Random| {
            let step = (width * spread).min(1.0);
            (1.0 - step * step).sqrt() * place + step * scale * random.normal()
        };
        if self.kind() == 1 {
            let one = |&place: &f64| match random.unit() < SOME {
                true => moved(place, 1.0, random),
                false => place,
            };
            return point.iter().map(one).collect();
        }
        let mut next = vec![0.0; point.len()];
        for (axis, spread) in self.axes.iter().zip(&self.spreads) {
            let place: f64 = axis.iter().zip(point).map(|(a, x)| a * x).sum();
            let moved = moved(place, *spread, random);
            for (x, a) in next.iter_mut().zip(axis) {
                *x += moved * a;
            }
        }
        next
    }

    /// Makes steps narrower where too few of them are accepted, and wider where too many are.
    pub(super) fn adapt(&mut self, accepted: f64) {
        let width = &mut self.widths[self.kind()];
        self.steps += 1;
        let gain = if self.steps <= FIRST { 3.0 } else { 1.0 };
        *width = (*width * (gain * (accepted - ACCEPTED)).exp()).min(WIDEST);
    }
}
