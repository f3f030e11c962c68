//! The ratio of two means over base points, such as a part of the variance over the variance, with its 95 % interval.

use crate::Estimate;
use sampling::statistics::moments::mean;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Blocks of consecutive base points that are left out in turn.
const BLOCKS: usize = 16;

/// What every base point adds to a mean: the sum of its terms, and how many they are.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    sums: Vec<f64>,
    counts: Vec<f64>,
}

impl Parts {
    /// Of one term a base point; one that is not a finite number does not count.
    pub fn of(terms: impl IntoIterator<Item = f64>) -> Self {
        terms.into_iter().map(|term| [term]).collect()
    }

    /// Of the base points to keep: sum and count.
    fn total(&self, keep: impl Fn(usize) -> bool) -> [f64; 2] {
        let kept = (0..self.sums.len()).filter(|&j| keep(j));
        kept.fold([0.0, 0.0], |[sum, count], j| {
            [sum + self.sums[j], count + self.counts[j]]
        })
    }

    /// How many base points have a term.
    pub fn used(&self) -> usize {
        self.counts.iter().filter(|count| **count > 0.0).count()
    }
}

/// From the terms of each base point.
impl<T: IntoIterator<Item = f64>> FromIterator<T> for Parts {
    fn from_iter<I: IntoIterator<Item = T>>(points: I) -> Self {
        let mut parts = Self::default();
        for point in points {
            let finite = point.into_iter().filter(|term| term.is_finite());
            let [sum, count] = finite.fold([0.0, 0.0], |[sum, n], term| [sum + term, n + 1.0]);
            parts.sums.push(sum);
            parts.counts.push(count);
        }
        parts
    }
}

/// Each base point's part of the variance, from the values of its independent runs; 0 everywhere where these are constant
/// but for rounding.
pub fn variance(points: &[[f64; 2]]) -> Parts {
    let centre = centre(points);
    let square = |value: f64| (value - centre).powi(2);
    let parts = points.iter().map(|point| point.map(square)).collect();
    but_for_rounding(parts, centre)
}

/// The same from the difference of each two, of which both must have a value.
pub fn paired_variance(points: &[[f64; 2]]) -> Parts {
    let parts = Parts::of(points.iter().map(|[a, b]| (a - b).powi(2) / 2.0));
    but_for_rounding(parts, centre(points))
}

fn centre(points: &[[f64; 2]]) -> f64 {
    let known: Vec<f64> = points.iter().flatten().copied().collect();
    let known: Vec<f64> = known.into_iter().filter(|v| v.is_finite()).collect();
    mean(&known)
}

fn but_for_rounding(parts: Parts, centre: f64) -> Parts {
    let [sum, count] = parts.total(|_| true);
    let least = f64::EPSILON * centre.powi(2).max(f64::MIN_POSITIVE);
    if sum > least * count {
        return parts;
    }
    Parts {
        sums: vec![0.0; parts.sums.len()],
        ..parts
    }
}

/// The ratio of two means over the base points to keep.
pub fn ratio(over: &Parts, under: &Parts, keep: impl Fn(usize) -> bool) -> f64 {
    let mean = |parts: &Parts| {
        let [sum, count] = parts.total(&keep);
        sum / count
    };
    mean(over) / mean(under)
}

/// A ratio with an offset, and its interval. It is 0 where there is no variance: nothing explains it.
///
/// `None` where fewer than two blocks have terms.
pub fn estimate(over: &Parts, under: &Parts, offset: f64) -> Option<Estimate> {
    let ratio = ratio(over, under, |_| true);
    let half = half_width(over, under, ratio)?;
    let value = match ratio.is_finite() {
        true => offset + ratio,
        false => 0.0,
    };
    Some(Estimate::around(value, half))
}

/// Half the width of a ratio's 95 % interval: the smaller of two that are both wide enough.
///
/// - Student's, from the ratio with each of sixteen blocks of consecutive points left out (delete-a-group jackknife; Kott
///   2001, "The delete-a-group jackknife", J. Official Statistics 17). Each block of a scrambled net is a scrambled net of
///   its own. All together they fill the space more evenly than as many independent ones would, of which this is the
///   interval.
/// - The normal one of as many independent points, by linearisation (Efron 1982, "The jackknife, the bootstrap and other
///   resampling plans", chapter 6), which is what a bootstrap comes to. A net is better than independent points, except
///   for an output as rough as pass or fail, for which it is hardly better.
///
/// `None` where fewer than two blocks have terms.
pub fn half_width(over: &Parts, under: &Parts, ratio_of_all: f64) -> Option<f64> {
    let points = over.sums.len();
    let block = |j: usize| j * BLOCKS / points;
    let mut filled = [false; BLOCKS];
    let complete = (0..points).filter(|&j| over.counts[j] > 0.0);
    complete.for_each(|j| filled[block(j)] = true);
    let filled: Vec<usize> = (0..BLOCKS).filter(|&k| filled[k]).collect();
    let student = StudentsT::new(0.0, 1.0, filled.len() as f64 - 1.0).ok()?;
    if !ratio_of_all.is_finite() {
        return Some(0.0);
    }
    let without = |&left_out: &usize| ratio(over, under, |j| block(j) != left_out);
    let without: Vec<f64> = filled.iter().map(without).collect();
    let ([above, terms], [below, squares]) = (over.total(|_| true), under.total(|_| true));
    let (above, below) = (above / terms, below / squares);
    let n = points as f64;
    let influence = |j: usize| {
        let term = (over.sums[j] - above * over.counts[j]) * n / terms;
        let square = (under.sums[j] - below * under.counts[j]) * n / squares;
        (term - ratio_of_all * square).powi(2)
    };
    let independent = (0..points).map(influence).sum::<f64>().sqrt() / (n * below);
    let normal = Normal::standard().inverse_cdf(0.975);
    Some((student.inverse_cdf(0.975) * jackknife(&without)).min(normal * independent))
}

/// The standard error of an estimate from its values with each group left out.
fn jackknife(without: &[f64]) -> f64 {
    let (n, centre) = (without.len() as f64, mean(without));
    let squares: f64 = without.iter().map(|v| (v - centre).powi(2)).sum();
    ((n - 1.0) / n * squares).sqrt()
}

/// The terms of the weighted mean of two estimators that scatters least, and the weight of the second. All terms are finite.
pub fn combined(first: &[f64], second: &[f64], under: &Parts) -> (Vec<f64>, f64) {
    let deviations = |terms: &[f64]| -> Vec<f64> {
        let ratio = ratio(&Parts::of(terms.iter().copied()), under, |_| true);
        let each = under.sums.iter().zip(&under.counts);
        let pairs = terms.iter().zip(each.map(|(sum, count)| sum / count));
        pairs.map(|(term, v)| term - ratio * v).collect()
    };
    let (own, other) = (deviations(first), deviations(second));
    let pairs = own
        .iter()
        .zip(&other)
        .map(|(own, other)| (own, other - own));
    let sums = pairs.fold([0.0, 0.0], |[product, square], (own, difference)| {
        [product + own * difference, square + difference.powi(2)]
    });
    let weight = -sums[0] / sums[1];
    // Both are the same where nothing scatters.
    let weight = if weight.is_finite() {
        weight.clamp(0.0, 1.0)
    } else {
        0.5
    };
    let pairs = first.iter().zip(second);
    let terms = pairs.map(|(a, b)| (1.0 - weight) * a + weight * b);
    (terms.collect(), weight)
}
