//! Latin hypercubes whose points are spread well: of all ways to pair the slices of the inputs, one with a
//! small centred L2 discrepancy.
//!
//! The search starts from the ranks of a scrambled Sobol net, which is more even than random pairing from the start. Then
//! it exchanges slices of one input between two points (Jin, Chen, Sudjianto 2005). A change for the worse is accepted
//! below a threshold that falls geometrically. Everything follows from the seed, the number of points and the number of
//! inputs.

use super::{
    discrepancy::{Discrepancy, Exchange},
    hypercube::Hypercube,
    rule::{Inputs, Numbers, Registered, Rule},
    slices::{Slices, ranks},
    sobol::Nets,
};
use crate::random::{self, Purpose};

/// Above this number, a Sobol net spreads the points as well.
pub(super) const MOST: u64 = 4096;
/// Budget: points whose products with two others may be looked at, in about half a second.
const EFFORT: usize = 300_000_000;
/// Most exchanges tried; more find little that is better, even for few points.
const MOST_TRIALS: usize = 300_000;

/// How many exchanges are tried.
fn trials(points: usize) -> usize {
    (EFFORT / points).min(MOST_TRIALS)
}

/// A well spread table of slices.
#[derive(Clone, Debug)]
pub(super) struct Spread(Slices);

impl Registered for Spread {
    const STRATIFIED: bool = true;

    fn new(numbers: &Numbers, inputs: &Inputs) -> Result<Self, String> {
        Self::of(numbers.seed, inputs.dimensions(), numbers.points)
    }
}

impl Rule for Spread {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        self.0.uniform(index, dimension)
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
        let start = start(seed, dimensions, points);
        let points = usize::try_from(points).expect("at most MOST, checked above");
        let columns = Search::new(seed, points, start).best();
        Ok(Self(Slices::new(seed, points, columns)))
    }
}

/// The ranks of a Sobol net, input after input; of random points where there are more inputs than nets have.
fn start(seed: u64, dimensions: usize, points: u64) -> Vec<Vec<u32>> {
    let numbers = Numbers { points, seed, replicates: 1 };
    let rule: Box<dyn Rule> = match Nets::of(&numbers, dimensions) {
        Ok(net) => Box::new(net),
        Err(_) => Box::new(Hypercube::of(seed, points)),
    };
    let column = |dimension| -> Vec<f64> { (0..points).map(|index| rule.uniform(index, dimension)).collect() };
    (0..).take(dimensions).map(|dimension| ranks(&column(dimension))).collect()
}

/// A search for a better pairing of slices.
struct Search {
    seed: u64,
    points: usize,
    columns: Vec<Vec<u32>>,
    state: Discrepancy,
}

impl Search {
    fn new(seed: u64, points: usize, columns: Vec<Vec<u32>>) -> Self {
        let place = |dimension, slices: &Vec<u32>| {
            slices.iter().map(|&slice| Slices::place(seed, points, slice, dimension)).collect()
        };
        let coordinates: Vec<Vec<f64>> =
            (0..).zip(&columns).map(|(dimension, slices)| place(dimension, slices)).collect();
        Self { seed, points, state: Discrepancy::new(&coordinates), columns }
    }

    /// The best pairing that was found.
    fn best(mut self) -> Vec<Vec<u32>> {
        if self.points <= 1 || self.columns.len() <= 1 {
            return self.columns;
        }
        let trials = trials(self.points);
        let mut best = (self.state.square(), self.columns.clone());
        // One exchange changes less where there are more points. Over all trials, the threshold falls by four orders of
        // magnitude.
        let mut threshold = 0.2 / self.points as f64 * best.0;
        let fall = 1e-4_f64.powf(1.0 / trials as f64);
        for trial in 0..trials as u64 {
            let exchange = self.draw(trial);
            let now = self.state.square_after(exchange);
            let allowed = threshold * random::uniform(self.seed, Purpose::Swap, trial, 3);
            if now - self.state.square() <= allowed {
                self.state.make(exchange);
                self.columns[exchange.dimension].swap(exchange.a, exchange.b);
                // Of equally good pairings the first one stays.
                if now <= best.0 * (1.0 - 1e-9) {
                    best = (now, self.columns.clone());
                }
            }
            threshold *= fall;
        }
        best.1
    }

    fn draw(&self, trial: u64) -> Exchange {
        let below = |which, count: usize| {
            let bits = random::bits(self.seed, Purpose::Swap, trial, which);
            // The remainder is below a length.
            (bits % count as u64) as usize
        };
        let a = below(1, self.points);
        Exchange { dimension: below(0, self.columns.len()), a, b: (a + 1 + below(2, self.points - 1)) % self.points }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn discrepancy(seed: u64, columns: &[Vec<u32>]) -> f64 {
        let search = Search::new(seed, columns[0].len(), columns.to_vec());
        search.state.square()
    }

    /// The least discrepancies of five runs of `scipy.stats.qmc.LatinHypercube(7, optimization="random-cd")`, SciPy 1.17.1.
    /// tests/python/test_designs.py compares 1000 points, too.
    #[test]
    fn points_are_spread_better_than_scipy_spreads_them_and_in_slices() {
        for (points, most) in [(50, 1.019e-2), (200, 1.693e-3)] {
            let columns = Spread::of(3, 7, points).unwrap().0.columns().to_vec();
            let discrepancy = discrepancy(3, &columns);
            assert!(discrepancy < 0.9 * most, "{points}: {discrepancy}");
            for mut column in columns {
                column.sort_unstable();
                assert!(column.into_iter().map(u64::from).eq(0..points));
            }
        }
    }

    /// The discrepancy that the search keeps is that of the points.
    #[test]
    fn the_search_sees_the_points_as_they_are() {
        let spread = Spread::of(3, 3, 20).unwrap();
        let column = |dimension| (0..20).map(|index| spread.uniform(index, dimension)).collect();
        let points: Vec<Vec<f64>> = (0..3).map(column).collect();
        let discrepancy = discrepancy(3, spread.0.columns());
        assert_eq!(discrepancy, Discrepancy::new(&points).square());
    }

    #[test]
    fn the_search_starts_from_a_net() {
        let numbers = Numbers { points: 32, seed: 5, replicates: 1 };
        let net = Nets::of(&numbers, 3).unwrap();
        for (dimension, column) in (0..).zip(start(5, 3, 32)) {
            for (index, slice) in (0..).zip(column) {
                let expected = (32.0 * net.uniform(index, dimension)).floor();
                assert_eq!(f64::from(slice), expected, "{dimension} {index}");
            }
        }
        // Nets have at most 100 inputs.
        let plain = Hypercube::of(5, 6);
        let many = start(5, 101, 6);
        assert_eq!(many.len(), 101);
        let slice = |index| u64::from(many[100][index as usize]);
        assert!((0..6).all(|index| slice(index) == plain.slice(index, 100)));
    }

    #[test]
    fn the_effort_is_bounded() {
        assert_eq!([1, 1000].map(trials), [MOST_TRIALS; 2]);
        assert_eq!(trials(4000), EFFORT / 4000);
    }

    /// Three points in two or three inputs: of all pairings the best one, whatever the seed.
    #[test]
    fn of_three_points_the_best_pairing_is_found() {
        for (seed, pairings) in (0..3).flat_map(|seed| [2, 3].map(|d| (seed, pairings(d)))) {
            let values = pairings.iter().map(|columns| discrepancy(seed, columns));
            let least = values.fold(f64::INFINITY, f64::min);
            let spread = Spread::of(seed, pairings[0].len(), 3).unwrap();
            let discrepancy = discrepancy(seed, spread.0.columns());
            assert!((discrepancy - least).abs() < 1e-12, "{seed}: {discrepancy} {least}");
        }
    }

    /// A start that cannot be better is the result.
    #[test]
    fn a_start_that_cannot_be_better_stays() {
        let mut kept = 0;
        for seed in 0..20 {
            let start = start(seed, 2, 3);
            let values = pairings(2).into_iter().map(|c| discrepancy(seed, &c));
            let least = values.fold(f64::INFINITY, f64::min);
            if discrepancy(seed, &start) < least + 1e-12 {
                assert_eq!(Spread::of(seed, 2, 3).unwrap().0.columns(), start, "{seed}");
                kept += 1;
            }
        }
        assert!(kept > 2, "{kept}");
    }

    /// All pairings of three slices.
    fn pairings(dimensions: usize) -> Vec<Vec<Vec<u32>>> {
        const ORDERS: [[u32; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        (1..dimensions).fold(vec![vec![vec![0, 1, 2]]], |pairings, _| {
            let longer = |known: &Vec<Vec<u32>>| {
                let with = |order: [u32; 3]| [&known[..], &[order.to_vec()]].concat();
                ORDERS.map(with)
            };
            pairings.iter().flat_map(longer).collect()
        })
    }

    #[test]
    fn nothing_is_sought_where_there_is_no_choice() {
        assert_eq!(Spread::of(1, 3, 1).unwrap().0.columns(), [[0], [0], [0]]);
        assert_eq!(Spread::of(1, 1, 8).unwrap().0.columns(), start(1, 1, 8));
    }

    #[test]
    fn too_many_points_are_refused_with_the_remedy() {
        let error = Spread::of(1, 1, MOST + 1).unwrap_err();
        assert!(error.contains("4096") && error.contains("sobol"), "{error}");
        assert!(Spread::of(1, 1, MOST).is_ok());
    }
}
