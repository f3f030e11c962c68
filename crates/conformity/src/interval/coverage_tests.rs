//! How often the intervals hold the numbers of the population: at least as often as they say.
//!
//! The hard cases are good rigs and few points: the probability of a point not to conform is 0 or 1
//! nearly everywhere, and the few points near a limit, which carry the whole risk, are often missing.

use super::*;
use crate::normal::between;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::{Distribution, StandardNormal};
use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, Normal};

/// Model values that are normal, within a tolerance about 0, and a measured value's standard uncertainty.
struct Population {
    mean: f64,
    deviation: f64,
    tolerance: f64,
    uncertainty: f64,
}

const fn population(mean: f64, deviation: f64, tolerance: f64, uncertainty: f64) -> Population {
    Population { mean, deviation, tolerance, uncertainty }
}

/// The numbers of which a study states intervals.
const NAMES: [&str; 4] = ["consumer", "producer", "conforming", "not conforming / accepted"];

impl Population {
    fn conforming(&self, value: f64) -> f64 {
        let ends = [-self.tolerance, self.tolerance].map(|end| (end - value) / self.uncertainty);
        between(ends[0], ends[1])
    }

    /// By Simpson's rule over each part of the line without a jump.
    fn exact(&self) -> [f64; 4] {
        const CELLS: u32 = 20_000;
        let over = |from: f64, to: f64, of: &dyn Fn(f64) -> f64| -> f64 {
            let width = (to - from) / f64::from(CELLS);
            let weight = |i: u32| match i {
                0 | CELLS => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let at = |i: u32| {
                let x = from + width * f64::from(i);
                let z = (x - self.mean) / self.deviation;
                of(x) * (-0.5 * z * z).exp()
            };
            let sum: f64 = (0..=CELLS).map(|i| weight(i) * at(i)).sum();
            sum * width / 3.0 / (self.deviation * std::f64::consts::TAU.sqrt())
        };
        let (t, far) = (self.tolerance, self.tolerance + 12.0 * self.uncertainty);
        let consumer = over(-t, t, &|x| 1.0 - self.conforming(x));
        let outside = |x: f64| self.conforming(x);
        let producer = over(t, far, &outside) + over(-far, -t, &outside);
        let accepted = over(-t, t, &|_| 1.0);
        [consumer, producer, accepted - consumer + producer, consumer / accepted]
    }

    /// The intervals of a study with these model values, sample by sample.
    fn intervals(&self, samples: &[Vec<f64>]) -> [[f64; 2]; 4] {
        let sums = |of: &dyn Fn(f64, bool) -> Option<f64>| -> Vec<Moments> {
            let one = |values: &Vec<f64>| {
                let mut moments = Moments::default();
                for &x in values {
                    let number = of(self.conforming(x), x.abs() <= self.tolerance);
                    number.into_iter().for_each(|number| moments.add(number));
                }
                moments
            };
            samples.iter().map(one).collect()
        };
        let consumer = sums(&|p, accepted| Some(if accepted { 1.0 - p } else { 0.0 }));
        let producer = sums(&|p, accepted| Some(if accepted { 0.0 } else { p }));
        let conforming = sums(&|p, _| Some(p));
        let part = sums(&|p, accepted| accepted.then_some(1.0 - p));
        [of_mean(&consumer, 0.95), of_mean(&producer, 0.95), of_mean(&conforming, 0.95), of_part(&part, 0.95)]
    }

    /// Refuses intervals that hold the exact numbers in fewer than 95 % of the studies, by a binomial test at 0.1 %.
    fn check(&self, name: &str, studies: u32, mut draw: impl FnMut() -> Vec<Vec<f64>>) {
        let exact = self.exact();
        let mut held = [0_u64; 4];
        for _ in 0..studies {
            let intervals = self.intervals(&draw());
            for k in 0..4 {
                held[k] += u64::from(intervals[k][0] <= exact[k] && exact[k] <= intervals[k][1]);
            }
        }
        let least = Binomial::new(0.95, u64::from(studies)).unwrap().inverse_cdf(0.001);
        for (k, held) in held.into_iter().enumerate() {
            let share = 100.0 * held as f64 / f64::from(studies);
            println!("{name}, {}: {share:.1} %", NAMES[k]);
            assert!(held >= least, "{name}, {}: {share:.1} %", NAMES[k]);
        }
    }
}

/// Numbers of points with the populations that they are drawn from.
const CASES: [(usize, Population); 14] = [
    (50, population(0.0, 1.0, 1.0, 0.05)),
    (20, population(0.0, 1.0, 2.0, 0.1)),
    (200, population(0.0, 1.0, 1.0, 0.02)),
    (50, population(2.0, 0.7, 1.0, 0.1)),
    (100, population(0.0, 1.0, 3.0, 0.05)),
    // Rigs that are not so good, few points and many.
    (50, population(0.0, 1.0, 1.0, 0.5)),
    (10, population(0.0, 1.0, 1.0, 0.3)),
    (30, population(0.0, 1.0, 1.0, 1.0)),
    (5, population(0.0, 1.0, 1.0, 0.2)),
    (2, population(0.0, 1.0, 1.0, 0.5)),
    (1000, population(0.0, 1.0, 1.0, 1.0)),
    (1000, population(0.0, 1.0, 3.0, 0.05)),
    (500, population(3.0, 1.0, 1.0, 0.3)),
    // Nearly nothing conforms, but for values that hardly ever come.
    (100, population(4.0, 1.0, 1.0, 0.05)),
];

fn independent(studies: u32, cases: &[(usize, Population)]) {
    let mut random = StdRng::seed_from_u64(16);
    for &(points, ref population) in cases {
        let name = format!(
            "{points} of N({}, {}), T {}, u {}",
            population.mean, population.deviation, population.tolerance, population.uncertainty
        );
        population.check(&name, studies, || {
            let normal = |random: &mut StdRng| -> f64 { StandardNormal.sample(random) };
            let value = |random: &mut StdRng| population.mean + population.deviation * normal(random);
            vec![(0..points).map(|_| value(&mut random)).collect()]
        });
    }
}

#[test]
fn intervals_hold_the_risks_at_least_as_often_as_they_say() {
    independent(40, &CASES[..4]);
}

#[test]
#[ignore = "takes a minute; run by scripts/test --long"]
fn intervals_hold_the_risks_in_20_000_studies() {
    independent(20_000, &CASES);
}

/// One randomisation of a net in one or two directions: each cell has one point, at random in it.
fn net(random: &mut StdRng, points: usize, plane: bool) -> Vec<[f64; 2]> {
    let side = if plane { (points as f64).sqrt().round() as usize } else { points };
    let rows = if plane { side } else { 1 };
    let cells = (0..rows).flat_map(|row| (0..side).map(move |column| (row, column)));
    cells
        .map(|(row, column)| {
            let mut place = |cell: usize, of: usize| (cell as f64 + random.random::<f64>()) / of as f64;
            [place(column, side), place(row, rows)]
        })
        .collect()
}

fn replicated(studies: u32, numbers: &[usize]) {
    let normal = Normal::standard();
    let mut random = StdRng::seed_from_u64(17);
    for (points, population) in [
        (16, population(0.0, 1.0, 1.0, 0.05)),
        (16, population(0.0, 1.0, 1.0, 0.5)),
        (36, population(0.0, 1.0, 3.0, 0.05)),
        (64, population(0.0, 1.0, 1.0, 0.02)),
        (64, population(2.0, 0.7, 1.0, 0.1)),
        (256, population(0.0, 1.0, 3.0, 0.05)),
    ] {
        for &samples in numbers {
            for plane in [false, true] {
                let name = format!(
                    "{samples} nets of {points}{}, N({}, {}), T {}, u {}",
                    if plane { " in the plane" } else { "" },
                    population.mean,
                    population.deviation,
                    population.tolerance,
                    population.uncertainty
                );
                // Two parameters of equal weight make the value, or one.
                let value = |[x, y]: [f64; 2]| {
                    let [x, y] = [x, y].map(|u| normal.inverse_cdf(u));
                    let z = if plane { (x + y) * 0.5_f64.sqrt() } else { x };
                    population.mean + population.deviation * z
                };
                population.check(&name, studies, || {
                    (0..samples).map(|_| net(&mut random, points, plane).into_iter().map(value).collect()).collect()
                });
            }
        }
    }
}

#[test]
fn intervals_of_randomised_designs_hold_the_risks_at_least_as_often_as_they_say() {
    replicated(10, &[8]);
}

#[test]
#[ignore = "takes minutes; run by scripts/test --long"]
fn intervals_of_randomised_designs_hold_the_risks_in_3_000_studies() {
    replicated(3000, &[2, 8, 16]);
}

/// A part whose numbers are squares of uniform ones: the intervals are honest, and no wider than those of zeros and
/// ones have to be.
#[test]
fn intervals_of_numbers_that_scatter_little_are_narrower() {
    let mut random = StdRng::seed_from_u64(1);
    for (size, least_gain) in [(50, 1.0), (1000, 1.3), (100_000, 1.55)] {
        let mut held = 0;
        for _ in 0..200 {
            let mut part = Moments::default();
            for _ in 0..size {
                let u: f64 = random.random();
                part.add(u * u);
            }
            let [low, high] = of_mean(&[part], 0.95);
            held += u32::from(low <= 1.0 / 3.0 && 1.0 / 3.0 <= high);
            let [from, to] = clopper_pearson(part.sum, part.count as f64, 0.95);
            assert!((to - from) >= least_gain * (high - low), "{size}");
        }
        assert!(held >= 183, "{size}: {held}");
    }
}
