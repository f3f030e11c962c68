//! Latin hypercubes whose points are spread well: of all ways to pair the slices of the inputs, one with a
//! small centred L2 discrepancy (Hickernell 1998, eq. 1.11).
//!
//! Like Jin, Chen, Sudjianto (2005), "An efficient algorithm for constructing optimal design of computer
//! experiments": slices of one input are exchanged between two points, a change for the worse is accepted
//! below a threshold, and the discrepancy is updated in O(N). The threshold falls geometrically. Everything
//! follows from the seed, the number of points and the number of inputs.

use super::hypercube::Hypercube;
use super::random::{self, Purpose};
use super::rule::{Inputs, Numbers, Registered, Rule};
use crate::distribution::BELOW_ONE;

/// Above this number, random pairing already spreads the points well.
pub(super) const MOST: u64 = 4096;
/// Budget: factors of the discrepancy that may be computed, some tenths of a second.
const EFFORT: usize = 40_000_000;
/// Most exchanges tried; more find nothing better, even for few points.
const MOST_TRIALS: usize = 50_000;

/// A table of slices.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    seed: u64,
    points: usize,
    /// The slice of each point, input after input.
    slices: Vec<Vec<u32>>,
}

impl Registered for Spread {
    fn new(numbers: &Numbers, inputs: &Inputs) -> Result<Self, String> {
        Self::of(numbers.seed, inputs.dimensions(), numbers.points)
    }
}

impl Rule for Spread {
    #[allow(clippy::cast_precision_loss)]
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        let place = usize::try_from(index).unwrap_or(0) % self.points;
        let slice = self.slices[dimension as usize][place];
        let within = random::uniform(self.seed, Purpose::Jitter, index, dimension);
        ((f64::from(slice) + within) / self.points as f64).min(BELOW_ONE)
    }
}

impl Spread {
    fn of(seed: u64, dimensions: usize, points: u64) -> Result<Self, String> {
        if points > MOST {
            return Err(format!(
                "an optimised Latin hypercube has at most {MOST} points; more are spread well \
                 enough by method = \"latin-hypercube\" or \"sobol\""
            ));
        }
        let start = Hypercube::of(seed, points);
        // At most MOST, checked above.
        let slice = |index, dimension| u32::try_from(start.slice(index, dimension)).unwrap_or(0);
        let slices = (0..)
            .take(dimensions)
            .map(|dimension| (0..points).map(|index| slice(index, dimension)).collect());
        let spread = Self {
            seed,
            points: usize::try_from(points).unwrap_or(0),
            slices: slices.collect(),
        };
        Ok(spread.improved())
    }

    /// The best pairing that was found.
    fn improved(self) -> Self {
        let (points, dimensions) = (self.points, self.slices.len());
        if points < 3 || dimensions < 2 {
            return self;
        }
        let trials = (EFFORT / (4 * points * dimensions)).min(MOST_TRIALS);
        let mut state = Discrepancy::new(&self.slices);
        let mut best = (state.discrepancy(), self.slices.clone());
        let mut threshold = 1e-2 * best.0;
        // Over all trials, the threshold falls by four orders of magnitude.
        let fall = 1e-4_f64.powf(1.0 / trials.max(1) as f64);
        for trial in 0..trials as u64 {
            let draw = |which, below: usize| {
                let bits = random::bits(self.seed, Purpose::Swap, trial, which);
                // The remainder is below a length.
                (bits % below as u64) as usize
            };
            let (dimension, a, b) = (draw(0, dimensions), draw(1, points), draw(2, points));
            if a == b {
                continue;
            }
            let change = state.exchange(dimension, a, b);
            if change > threshold * random::uniform(self.seed, Purpose::Swap, trial, 3) {
                state.exchange(dimension, a, b);
            } else if state.discrepancy() < best.0 * (1.0 - 1e-9) {
                best = (state.discrepancy(), state.slices());
            }
            threshold *= fall;
        }
        Self {
            slices: best.1,
            ..self
        }
    }
}

/// The middles of the slices, measured from the centre, and what the discrepancy is made of.
struct Discrepancy {
    /// Point after point, so that the factors of a pair lie together.
    x: Vec<f64>,
    dimensions: usize,
    points: usize,
    /// The second and the third term of the discrepancy without their factors.
    single: f64,
    double: f64,
}

impl Discrepancy {
    #[allow(clippy::cast_precision_loss)]
    fn new(slices: &[Vec<u32>]) -> Self {
        let (dimensions, points) = (slices.len(), slices[0].len());
        let middle = |slice: u32| (f64::from(slice) + 0.5) / points as f64 - 0.5;
        let place = |k: usize| middle(slices[k % dimensions][k / dimensions]);
        let mut state = Self {
            x: (0..points * dimensions).map(place).collect(),
            dimensions,
            points,
            single: 0.0,
            double: 0.0,
        };
        state.single = (0..points).map(|i| state.one(i)).sum();
        let row = |i: usize| (0..points).map(move |j| (i, j));
        state.double = (0..points)
            .flat_map(row)
            .map(|(i, j)| state.two(i, j))
            .sum();
        state
    }

    fn slices(&self) -> Vec<Vec<u32>> {
        let slice = |x: f64| {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                clippy::cast_precision_loss
            )]
            let slice = ((x + 0.5) * self.points as f64) as u32;
            slice
        };
        let column = |d: usize| self.x.iter().skip(d).step_by(self.dimensions);
        (0..self.dimensions)
            .map(|d| column(d).map(|&x| slice(x)).collect())
            .collect()
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.x[i * self.dimensions..(i + 1) * self.dimensions]
    }

    /// Hickernell's product over one point.
    fn one(&self, i: usize) -> f64 {
        let factor = |&x: &f64| 1.0 + 0.5 * x.abs() - 0.5 * x * x;
        self.row(i).iter().map(factor).product()
    }

    /// Hickernell's product over a pair of points.
    fn two(&self, i: usize, j: usize) -> f64 {
        let pairs = self.row(i).iter().zip(self.row(j));
        pairs
            .map(|(x, y)| 1.0 + 0.5 * (x.abs() + y.abs() - (x - y).abs()))
            .product()
    }

    /// The square of the discrepancy.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation)]
    fn discrepancy(&self) -> f64 {
        let n = self.points as f64;
        let whole = (13.0_f64 / 12.0).powi(self.dimensions as i32);
        whole - 2.0 / n * self.single + self.double / (n * n)
    }

    /// Contribution of the points `a` and `b` to the sums.
    fn part(&self, a: usize, b: usize) -> [f64; 2] {
        let others = (0..self.points).filter(|&i| i != a && i != b);
        let crossed: f64 = others.map(|i| self.two(i, a) + self.two(i, b)).sum();
        let own = self.two(a, a) + self.two(b, b) + 2.0 * self.two(a, b);
        [self.one(a) + self.one(b), own + 2.0 * crossed]
    }

    /// Exchanges the slices of two points and returns the change of the discrepancy's square.
    fn exchange(&mut self, dimension: usize, a: usize, b: usize) -> f64 {
        let (before, [single, double]) = (self.discrepancy(), self.part(a, b));
        let d = self.dimensions;
        self.x.swap(a * d + dimension, b * d + dimension);
        let [new_single, new_double] = self.part(a, b);
        self.single += new_single - single;
        self.double += new_double - double;
        self.discrepancy() - before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn discrepancy(slices: &[Vec<u32>]) -> f64 {
        Discrepancy::new(slices).discrepancy()
    }

    #[test]
    fn the_discrepancy_is_the_published_one() {
        // One point in the middle of d inputs: (13/12)^d - 2 + 1 by Hickernell's formula.
        let middle = discrepancy(&[vec![0], vec![0]]);
        assert!((middle - ((13.0_f64 / 12.0).powi(2) - 1.0)).abs() < 1e-15);
        // Two points in one input at 1/4 and 3/4: 13/12 - 2 * (1 + 1/8 - 1/32) + (1.25 + 1) / 2.
        let two = discrepancy(&[vec![0, 1]]);
        assert!((two - (13.0 / 12.0 - 2.0 * 1.09375 + 1.125)).abs() < 1e-15);
    }

    #[test]
    fn the_spread_is_better_and_still_a_hypercube() {
        for (points, dimensions) in [(20, 4), (50, 3), (333, 6)] {
            let spread = Spread::of(3, dimensions, points).unwrap();
            let plain = Hypercube::of(3, points);
            let slice = |i, d| u32::try_from(plain.slice(i, d)).unwrap();
            let column = |d| (0..points).map(|i| slice(i, d)).collect();
            let start: Vec<Vec<u32>> = (0..).take(dimensions).map(column).collect();
            let (before, after) = (discrepancy(&start), discrepancy(&spread.slices));
            assert!(after < 0.7 * before, "{points} points: {before} {after}");
            for column in &spread.slices {
                let mut sorted = column.clone();
                sorted.sort_unstable();
                assert!(sorted.iter().copied().eq(0..u32::try_from(points).unwrap()));
            }
        }
    }

    /// Three points in two or three inputs: of all pairings the best one, whatever the seed. Two points have no choice:
    /// their pairings are mirror images.
    #[test]
    fn of_three_points_the_best_pairing_is_found() {
        const ORDERS: [[u32; 3]; 6] = [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ];
        let orders = || ORDERS.map(Vec::from).into_iter();
        let pairs = orders().map(|b| vec![vec![0, 1, 2], b]).collect::<Vec<_>>();
        let triples = pairs
            .iter()
            .flat_map(|pair| orders().map(|c| [&pair[..], &[c]].concat()));
        for all in [triples.collect(), pairs.clone()] {
            let values = all.iter().map(|slices| discrepancy(slices));
            let least = values.fold(f64::INFINITY, f64::min);
            for seed in 0..3 {
                let spread = Spread::of(seed, all[0].len(), 3).unwrap();
                let found = discrepancy(&spread.slices);
                assert!((found - least).abs() < 1e-12, "{seed}: {found} {least}");
            }
        }
    }

    /// Of equally good pairings the first one stays: a start that cannot be better is the result.
    #[test]
    fn a_start_that_cannot_be_better_stays() {
        let best = discrepancy(&Spread::of(0, 2, 3).unwrap().slices);
        let mut kept = 0;
        for seed in 0..20 {
            let plain = Hypercube::of(seed, 3);
            let slice = |i, d| u32::try_from(plain.slice(i, d)).unwrap();
            let start: Vec<Vec<u32>> = (0..2)
                .map(|d| (0..3).map(|i| slice(i, d)).collect())
                .collect();
            if discrepancy(&start) < best + 1e-12 {
                assert_eq!(Spread::of(seed, 2, 3).unwrap().slices, start, "{seed}");
                kept += 1;
            }
        }
        assert!(kept > 2, "{kept}");
    }

    #[test]
    fn updates_do_not_drift() {
        let start = [3, 7, 11].map(|step| (0..40).map(|i| step * i % 40).collect());
        let mut state = Discrepancy::new(&start);
        for k in 0..1000 {
            state.exchange(k % 3, k % 40, (7 * k + 1) % 40);
        }
        let fresh = discrepancy(&state.slices());
        assert!((state.discrepancy() - fresh).abs() < 1e-12);
    }

    #[test]
    fn too_many_points_are_refused_with_the_remedy() {
        let error = Spread::of(1, 1, MOST + 1).unwrap_err();
        assert!(error.contains("4096") && error.contains("sobol"), "{error}");
        assert!(Spread::of(1, 1, MOST).is_ok());
    }
}
