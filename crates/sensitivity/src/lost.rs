//! Bounds of an index had the failed runs values: its least and its largest value when each of them takes any value
//! within the range of the others.
//!
//! The index is a mean over base points, mean((base - mixed)^2) / 2, over the variance of base and apart. With the ratio
//! below t, the sum of (base - mixed)^2 - t ((base - centre)^2 + (apart - centre)^2) is negative whatever the missing values
//! are: bisection finds the smallest such t, and a base point's worst values are found on their own (Dinkelbach 1967, "On
//! nonlinear fractional programming", Management Science 13, 492-498).

use crate::ratio::{Parts, half_width, ratio, variance};
use sampling::statistics::moments::mean;

/// A base point's runs: the one that is compared, the one that it is compared with, and an independent one.
pub type Triple = [f64; 3];

/// The least and the largest index, each with the scatter of the design added: the 95 % interval for the index of the
/// model with values everywhere, if these lie within `range`. `None` where too few runs have values.
pub fn bounds(rows: &[Triple], range: [f64; 2]) -> Option<[f64; 2]> {
    let problem = Problem::new(rows, range)?;
    let [least, most] = [false, true].map(|most| problem.ratio(most));
    let scatter = |ratio: f64, most: bool| {
        let filled = rows.iter().map(|row| problem.worst(*row, ratio, most));
        let filled: Vec<Triple> = filled.collect();
        let differences = filled.iter().map(|[base, mixed, _]| base - mixed);
        let over = Parts::of(differences.map(half_square));
        let under = variance(&pairs(&filled));
        half_width(&over, &under, self::ratio(&over, &under, |_| true))
    };
    Some([least - scatter(least, false)?, most + scatter(most, true)?])
}

fn half_square(difference: f64) -> f64 {
    difference.powi(2) / 2.0
}

fn pairs(rows: &[Triple]) -> Vec<[f64; 2]> {
    let pairs = rows.iter().map(|[base, _, apart]| [*base, *apart]);
    pairs.collect()
}

struct Problem {
    /// Base points with a missing value.
    open: Vec<Triple>,
    /// The sums of the others: half squared differences, and parts of the variance.
    known: [f64; 2],
    /// The smallest and the largest value.
    range: [f64; 2],
    /// The centre that the variance is taken about: the mean of the known values.
    centre: f64,
    /// By how much the sum of squares about that centre can exceed that about the true mean.
    slack: f64,
}

impl Problem {
    fn new(rows: &[Triple], range: [f64; 2]) -> Option<Self> {
        let known: Vec<f64> = pairs(rows).into_iter().flatten().collect();
        let known: Vec<f64> = known.into_iter().filter(|v| v.is_finite()).collect();
        let centre = mean(&known);
        let missing = 1.0 - known.len() as f64 / (2 * rows.len()) as f64;
        let reach = (range[1] - centre).max(centre - range[0]);
        let mut problem = Self {
            open: Vec::new(),
            known: [0.0; 2],
            range,
            centre,
            slack: rows.len() as f64 * (missing * reach).powi(2),
        };
        for row in rows {
            if row.iter().all(|v| v.is_finite()) {
                problem.known[0] += half_square(row[0] - row[1]);
                problem.known[1] += problem.spread(row);
            } else {
                problem.open.push(*row);
            }
        }
        centre.is_finite().then_some(problem)
    }

    /// A base point's part of the variance.
    fn spread(&self, row: &Triple) -> f64 {
        half_square(row[0] - self.centre) + half_square(row[2] - self.centre)
    }

    /// The largest ratio (`most`) or the least.
    fn ratio(&self, most: bool) -> f64 {
        // No estimate of a share of the variance is near this.
        let (mut low, mut high) = (0.0, 8.0);
        let slack = if most { self.slack } else { 0.0 };
        for _ in 0..40 {
            let t = 0.5 * (low + high);
            let open = self.open.iter().map(|row| {
                let row = self.worst(*row, t, most);
                half_square(row[0] - row[1]) - t * self.spread(&row)
            });
            let all = self.known[0] - t * (self.known[1] - slack) + open.sum::<f64>();
            if all > 0.0 {
                low = t;
            } else {
                high = t;
            }
        }
        0.5 * (low + high)
    }

    /// A base point, its missing runs filled with the values that make its part of the sum largest (`most`) or least.
    fn worst(&self, row: Triple, t: f64, most: bool) -> Triple {
        let [low, high] = self.range;
        let [base, mixed, apart] = row;
        let is_high_far = high - self.centre > self.centre - low;
        let far = if is_high_far { high } else { low };
        let apart = match (apart.is_finite(), most) {
            (true, _) => apart,
            (false, true) => self.centre,
            (false, false) => far,
        };
        let or_any = |value: f64| match value.is_finite() {
            true => [value; 2],
            false => [low, high],
        };
        let mut best = (f64::NEG_INFINITY, [base, mixed, apart]);
        let mut offer = |base: f64, mixed: f64| {
            let sum = half_square(base - mixed) - t * half_square(base - self.centre);
            let sum = if most { sum } else { -sum };
            if sum > best.0 {
                best = (sum, [base, mixed, apart]);
            }
        };
        for mixed in or_any(mixed) {
            for base in or_any(base) {
                offer(base, mixed);
            }
            // Where the derivative is zero.
            let still = (mixed - t * self.centre) / (1.0 - t);
            if !base.is_finite() && still.is_finite() {
                offer(still.clamp(low, high), mixed);
            }
        }
        if !mixed.is_finite() {
            or_any(base).into_iter().for_each(|base| offer(base, base));
        }
        best.1
    }
}

/// The least and the largest of the values that are numbers; none where none is.
pub(crate) fn range(values: &[f64]) -> Option<[f64; 2]> {
    let known = values.iter().copied().filter(|value| value.is_finite());
    known.fold(None, |ends, value| {
        let [low, high] = ends.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::near;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    fn share(rows: &[Triple]) -> f64 {
        let over = Parts::of(rows.iter().map(|[base, mixed, _]| half_square(base - mixed)));
        ratio(&over, &variance(&pairs(rows)), |_| true)
    }

    /// Whatever values the missing runs get, no ratio lies outside; and some come near to both ends.
    #[test]
    fn no_values_of_the_missing_runs_lead_outside() {
        let mut random = StdRng::seed_from_u64(5);
        for case in 0..20 {
            let mut row = || -> Triple {
                let base: f64 = random.random();
                [base, 0.5 * (base + random.random::<f64>()), random.random()]
            };
            let full: Vec<Triple> = (0..12).map(|_| row()).collect();
            let mut holed = full.clone();
            for k in 0..3 {
                let (point, run) = ((5 * case + 4 * k) % 12, (case + k) % 3);
                holed[point][run] = f64::NAN;
            }
            holed[case % 12][(case + 1) % 3] = f64::NAN;
            let range = [0.0, 1.0];
            let problem = Problem::new(&holed, range).unwrap();
            let [least, most] = [false, true].map(|most| problem.ratio(most));
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for _ in 0..4000 {
                let mut filled = holed.clone();
                for value in filled.iter_mut().flatten().filter(|v| v.is_nan()) {
                    // The ends of the range are the most telling values.
                    *value = random.random_range(-0.5..1.5_f64).clamp(0.0, 1.0);
                }
                let share = share(&filled);
                (low, high) = (low.min(share), high.max(share));
            }
            assert!(least <= low && high <= most, "{least} {low} {high} {most}");
            assert!(
                low - least < 0.2 * (high - low) && most - high < 0.5 * (high - low),
                "{least} {low} {high} {most}"
            );
        }
    }

    #[test]
    fn without_missing_runs_both_ends_are_the_index() {
        let rows = [[1.0, 2.0, 5.0], [3.0, 3.5, 2.0], [0.0, 4.0, 1.0]];
        let problem = Problem::new(&rows, [0.0, 5.0]).unwrap();
        for most in [false, true] {
            assert!((problem.ratio(most) - share(&rows)).abs() < 1e-9);
        }
    }

    /// By hand: the variance is largest, and the index least, with the value that is farthest from the mean of the known
    /// ones, 4/3: that is -4, not 4.
    #[test]
    fn the_least_index_has_the_largest_variance() {
        let rows = [[0.0, 1.0, 2.0], [2.0, 1.0, f64::NAN]];
        let least = |range: [f64; 2]| Problem::new(&rows, range).unwrap().ratio(false);
        near([least([-4.0, 4.0]), least([-1.0, 4.0])], [9.0 / 140.0, 9.0 / 44.0]);
    }

    /// One value everywhere is one within its range, too: nothing depends on anything.
    #[test]
    fn a_constant_has_bounds_of_nothing() {
        let mut rows = [[0.0; 3]; 32];
        rows[4][1] = f64::NAN;
        near(bounds(&rows, [0.0, 0.0]).unwrap(), [0.0; 2]);
        assert_eq!(bounds(&[[f64::NAN; 3]; 32], [0.0, 0.0]), None);
    }
}
