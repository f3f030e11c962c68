//! The ratio of two means over base points, such as a part of the variance over the variance, with its 95 % interval.

use crate::pairs::{BLOCKS, block};
use sampling::statistics::{
    estimate::Estimate,
    moments::{mean, moderate_unit},
};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Parts of the base points whose estimators are weighted by the others.
const FOLDS: usize = 4;

/// The contribution of every base point to a mean: the sum of its terms, and how many they are.
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
        (0..self.sums.len())
            .filter(|&j| keep(j))
            .fold([0.0, 0.0], |[sum, count], j| [sum + self.sums[j], count + self.counts[j]])
    }

    /// Each base point's own mean.
    pub fn means(&self) -> impl Iterator<Item = f64> {
        self.sums.iter().zip(&self.counts).map(|(sum, count)| sum / count)
    }

    /// The mean of all terms.
    pub fn mean(&self) -> f64 {
        let [sum, count] = self.total(|_| true);
        sum / count
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
            let [sum, count] = point
                .into_iter()
                .filter(|term| term.is_finite())
                .fold([0.0, 0.0], |[sum, n], term| [sum + term, n + 1.0]);
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
    let parts: Parts = points.iter().map(|point| point.map(square)).collect();
    if is_seen(parts.mean(), centre) {
        return parts;
    }
    Parts { sums: vec![0.0; parts.sums.len()], ..parts }
}

/// The mean of the values that are numbers.
pub fn centre(points: &[[f64; 2]]) -> f64 {
    let known = points.iter().flatten().copied().filter(|v| v.is_finite());
    mean(&known.collect::<Vec<f64>>())
}

/// Whether a variance is more than rounding about this mean.
fn is_seen(variance: f64, mean: f64) -> bool {
    variance > f64::EPSILON * mean.powi(2).max(f64::MIN_POSITIVE)
}

/// How many independent runs carry the variance of an output, of as many as the `ends` have: all of them where each is as far from the
/// mean, 1 where one is far off. All runs of the design show it, since each alone has the output's distribution. Without a
/// variance they are infinitely many.
pub fn carriers(outputs: &[f64], ends: &[[f64; 2]]) -> f64 {
    let known: Vec<f64> = outputs.iter().copied().filter(|value| value.is_finite()).collect();
    let (centre, count) = (mean(&known), known.len() as f64);
    let [sum, of_squares] = known
        .iter()
        .map(|value| (value - centre).powi(2))
        .fold([0.0, 0.0], |[sum, of], square| [sum + square, of + square * square]);
    let independent = ends.iter().flatten().filter(|value| value.is_finite()).count() as f64;
    if is_seen(sum / count, centre) { independent / count * sum * sum / of_squares } else { f64::INFINITY }
}

/// The ratio of two means over the base points to keep.
pub fn ratio(over: &Parts, under: &Parts, keep: impl Fn(usize) -> bool) -> f64 {
    let mean = |parts: &Parts| {
        let [sum, count] = parts.total(&keep);
        sum / count
    };
    mean(over) / mean(under)
}

/// A ratio with an offset, and its interval, of an output with so many [`carriers`]. The terms `scatter` show how far it scatters, and its
/// standard error is not less than `least`.
///
/// `None` where fewer than two blocks have terms.
///
/// The interval of a ratio that few runs carry is wider by trials (`docs/evidence/coverage.md`): such a ratio is skewed, by a part of 16
/// over their number. Where they are fewer than 12, or than the root of the number of base points, so that hardly any pair of runs
/// are both carriers, what so many have not shown counts, too: 3.7 over their number (the upper limit of Clopper and Pearson's interval of
/// none). Of fewer than 8 there is no interval.
///
/// Without any variance nothing explains it: the ratio is 0. Where the independent runs alone show none, it is unknown.
pub fn scattering(
    over: &Parts,
    scatter: &Parts,
    under: &Parts,
    offset: f64,
    least: f64,
    carriers: f64,
) -> Option<Estimate> {
    let half = half_width(scatter, under, least)?;
    let value = match ratio(over, under, |_| true) {
        ratio if ratio.is_finite() => offset + ratio,
        _ if carriers.is_infinite() => 0.0,
        _ => f64::NAN,
    };
    let rare = carriers < 12.0_f64.max((over.sums.len() as f64).sqrt());
    let half = if carriers < 8.0 {
        f64::NAN
    } else {
        half * (1.0 + 16.0 / carriers) + if rare { 3.7 / carriers } else { 0.0 }
    };
    Some(Estimate::around(value, half))
}

/// Half the width of a ratio's 95 % interval, without what few carriers ask for.
///
/// The wider one of two:
/// - Student's from the ratio with each of sixteen blocks left out (delete-a-group jackknife; Kott 2001, "The delete-a-group
///   jackknife", J. Official Statistics 17), each of which is a net of its own;
/// - Student's of as many independent points, by linearisation (Efron 1982, "The jackknife, the bootstrap and other resampling
///   plans", chapter 6), since sixteen nets may scatter little by chance.
///
/// `None` where fewer than two blocks have terms.
fn half_width(over: &Parts, under: &Parts, least: f64) -> Option<f64> {
    let points = over.sums.len();
    let block = |j: usize| block(j, points);
    let mut filled = [false; BLOCKS];
    (0..points).filter(|&j| over.counts[j] > 0.0).for_each(|j| filled[block(j)] = true);
    let filled: Vec<usize> = (0..BLOCKS).filter(|&k| filled[k]).collect();
    let quantile = |numbers: usize| Some(StudentsT::new(0.0, 1.0, numbers as f64 - 1.0).ok()?.inverse_cdf(0.975));
    quantile(filled.len())?;
    let ratio_of_all = ratio(over, under, |_| true);
    if !ratio_of_all.is_finite() {
        return Some(0.0);
    }
    let without = |&left_out: &usize| ratio(over, under, |j| block(j) != left_out);
    let without: Vec<f64> = filled.iter().map(without).collect();
    let ([above, terms], [below, squares]) = (over.total(|_| true), under.total(|_| true));
    let (above, below) = (above / terms, below / squares);
    let n = points as f64;
    let independent = (0..points)
        .map(|j| {
            let term = (over.sums[j] - above * over.counts[j]) * n / terms;
            let square = (under.sums[j] - below * under.counts[j]) * n / squares;
            (term - ratio_of_all * square).powi(2)
        })
        .sum::<f64>()
        .sqrt()
        / (n * below);
    let of_points = quantile(over.used())? * independent.max(least);
    let of_nets = quantile(filled.len())? * jackknife(&without);
    Some(of_points.max(of_nets))
}

/// The standard error of an estimate from its values with each group left out.
pub fn jackknife(without: &[f64]) -> f64 {
    let (n, centre) = (without.len() as f64, mean(without));
    let squares: f64 = without.iter().map(|v| (v - centre).powi(2)).sum();
    ((n - 1.0) / n * squares).sqrt()
}

/// The weighted mean of two estimators that scatters least.
#[derive(Clone, Debug)]
pub struct Combined {
    /// The terms of the estimate.
    pub terms: Vec<f64>,
    /// The terms that show how far it scatters: the weights of each of four parts of the base points come from the others.
    /// Weights that suit the very points they are taken from make the scatter look smaller than it is.
    pub crosswise: Vec<f64>,
    /// The weight of the second one.
    pub weight: f64,
}

impl Combined {
    /// One estimator with all the weight.
    pub fn only(terms: Vec<f64>, weight: f64) -> Self {
        Self { crosswise: terms.clone(), terms, weight }
    }
}

/// Combines two estimators of the same ratio, from the terms of each. All terms are finite.
pub fn combined(first: &[f64], second: &[f64], under: &Parts) -> Combined {
    let deviations = |terms: &[f64]| -> Vec<f64> {
        let ratio = ratio(&Parts::of(terms.iter().copied()), under, |_| true);
        terms.iter().zip(under.means()).map(|(term, v)| term - ratio * v).collect()
    };
    let (one, other) = (deviations(first), deviations(second));
    // The weight with the least variance is the sum of the first products over that of the second.
    let products: Vec<[f64; 2]> =
        one.iter().zip(&other).map(|(one, other)| [one * (one - other), (other - one).powi(2)]).collect();
    let points = products.len();
    let fold = |j: usize| j * FOLDS / points;
    let weight = |left_out: Option<usize>| {
        let [above, below] = (0..points)
            .filter(|&j| Some(fold(j)) != left_out)
            .fold([0.0, 0.0], |[above, below], j| [above + products[j][0], below + products[j][1]]);
        // Both are the same where nothing scatters.
        match above / below {
            weight if weight.is_finite() => weight.clamp(0.0, 1.0),
            _ => 0.5,
        }
    };
    let weighted = |weight: &dyn Fn(usize) -> f64| {
        first.iter().zip(second).enumerate().map(|(j, (a, b))| (1.0 - weight(j)) * a + weight(j) * b).collect()
    };
    let of_all = weight(None);
    let of_others: [f64; FOLDS] = std::array::from_fn(|k| weight(Some(k)));
    Combined { terms: weighted(&|_| of_all), crosswise: weighted(&|j| of_others[fold(j)]), weight: of_all }
}

/// Outputs in a unit in which their squares are numbers: no part of a variance depends on the unit.
pub fn moderate(outputs: &[f64]) -> Vec<f64> {
    let unit = moderate_unit(outputs.iter().copied());
    outputs.iter().map(|value| value / unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{holds, near};

    const MANY: f64 = f64::INFINITY;

    /// An estimate whose own terms show how far it scatters.
    fn estimate(over: &Parts, under: &Parts, offset: f64, carriers: f64) -> Option<Estimate> {
        scattering(over, over, under, offset, 0.0, carriers)
    }

    /// numpy: the residuals of a ratio of means, with Student's quantile of 63 degrees of freedom.
    #[test]
    fn few_points_have_the_interval_of_independent_ones() {
        let numbers = 0..64_u32;
        let over = Parts::of(numbers.clone().map(|k| f64::from(k * k % 7)));
        let under = Parts::of(numbers.map(|k| f64::from(1 + k % 3)));
        let estimate = estimate(&over, &under, 0.0, MANY).unwrap();
        assert!((estimate.value - 0.992_125_984).abs() < 1e-9);
        let half = estimate.high - estimate.value;
        assert!((half - 0.204_155_408_9).abs() < 1e-9, "{half}");
    }

    /// The wider one of the intervals of points and of sixteen blocks: numpy, with Student's quantiles.
    #[test]
    fn blocks_that_differ_have_their_own_interval() {
        let of_points = |points: u32, trend: f64, lost: &[u32]| {
            let over = (0..points).map(|k| match lost.contains(&k) {
                true => f64::NAN,
                false if trend > 0.0 => trend * f64::from(k / 16) + f64::from(k * k % 7) / 10.0,
                false => f64::from(5 * k % 16) + f64::from(k * k % 7) / 10.0,
            });
            let under = (0..points).map(|k| 1.0 + f64::from(k % 16) / 8.0);
            let over = Parts::of(over);
            let estimate = estimate(&over, &Parts::of(under), 0.0, MANY).unwrap();
            (over.used(), [estimate.value, estimate.high - estimate.value])
        };
        near(of_points(256, 0.0, &[]).1, [3.973_991_935_5, 0.319_516_497_2]);
        let (used, all) = of_points(256, 1.0, &[]);
        assert_eq!(used, 256);
        near(all, [3.973_991_935_5, 1.309_618_288_0]);
        // A block without any term is none; a point without one leaves its variance.
        let lost: Vec<u32> = (32..48).chain([100]).collect();
        let (used, fewer) = of_points(256, 1.0, &lost);
        assert_eq!(used, 239);
        near(fewer, [4.166_392_225_7, 1.345_763_932_1]);
        near(of_points(64, 0.0, &[5]).1, [3.958_627_752_2, 0.656_308_657_4]);
    }

    /// Where all terms lie in one of the sixteen blocks, or there is one only, nothing shows how they scatter.
    #[test]
    fn terms_of_one_block_have_no_interval() {
        let under = Parts::of([1.0, 2.0].repeat(16));
        let with = |count: usize| {
            let terms = (0..32).map(|k| if k < count { k as f64 } else { f64::NAN });
            estimate(&Parts::of(terms), &under, 0.0, MANY)
        };
        assert_eq!([0, 1, 2].map(|count| with(count).is_some()), [false; 3]);
        assert!(with(3).is_some());
    }

    /// The values of each base point are counted by themselves; the variance is about the mean of all, 3.
    #[test]
    fn values_that_are_missing_do_not_count() {
        let ends = [[1.0, 3.0], [5.0, f64::NAN], [f64::NAN; 2]];
        let parts = variance(&ends);
        assert_eq!(parts.used(), 2);
        let [two, one, none] = parts.means().collect::<Vec<_>>()[..] else { panic!("one mean a base point") };
        assert_eq!([two, one], [2.0, 4.0]);
        assert!(none.is_nan());
        assert_eq!(parts.total(|_| true), [8.0, 3.0]);
        assert_eq!(parts.total(|j| j != 1), [4.0, 2.0]);
    }

    /// Values that scatter by no more than the square root of the rounding error, 2^-26 of their size, count as equal.
    #[test]
    fn what_scatters_by_rounding_alone_has_no_variance() {
        let scattering = |size: f64, step: f64| [[size + step, size - step]; 4];
        let kept = |parts: Parts| parts.total(|_| true)[0] > 0.0;
        let step = 2.0_f64.powi(-26);
        assert!(!kept(variance(&scattering(1.0, step))));
        assert!(kept(variance(&scattering(1.0, 2.0 * step))));
        assert!(!kept(variance(&scattering(1024.0, 1024.0 * step))));
        assert!(kept(variance(&scattering(1024.0, 2048.0 * step))));
        assert!(kept(variance(&scattering(0.0, step))));
        // Nothing explains such an output.
        let over = Parts::of([0.0, 1.0, 0.0, 1.0]);
        let none = estimate(&over, &variance(&[[1.0; 2]; 4]), 1.0, carriers(&[1.0; 4], &[]));
        assert_eq!(none, Some(Estimate::around(0.0, 0.0)));
    }

    /// Of two in twenty that are far off 2.44 carry the variance: (sum of squares)^2 over the sum of fourth powers, in numpy.
    #[test]
    fn few_runs_that_carry_the_variance_widen_the_interval_or_leave_none() {
        let mut outputs = [0.0; 20];
        (outputs[3], outputs[12]) = (1.0, 1.0);
        let of = |outputs: &[f64]| carriers(outputs, &[[0.0; 2]; 10]);
        near([of(&outputs), of(&[-1.0, 1.0])], [180.0 / 73.0, 20.0]);
        let some = [&outputs[..], &[f64::NAN; 5]].concat();
        near([of(&some)], [180.0 / 73.0]);
        assert_eq!(of(&[0.1 + 0.2, 0.3]), f64::INFINITY);
        let (over, under) = (Parts::of([1.0, 2.0].repeat(16)), Parts::of([1.0; 32]));
        let [bare, wider, none] = [MANY, 32.0, 7.9].map(|carriers| estimate(&over, &under, 0.0, carriers).unwrap());
        holds(wider, [1.5, 1.5 + 1.5 * (bare.low - 1.5), 1.5 + 1.5 * (bare.high - 1.5)]);
        assert!(none.value == 1.5 && none.low.is_nan() && none.high.is_nan());
        // What fewer than 12, or of 400 base points than 20, have not shown.
        let more = |over: &Parts, carriers: f64| {
            let estimate = |carriers| estimate(over, over, 0.0, carriers).unwrap();
            estimate(carriers).high - 1.0 - (1.0 + 16.0 / carriers) * (estimate(MANY).high - 1.0)
        };
        let many = Parts::of([1.0, 2.0].repeat(200));
        near(
            [more(&over, 8.0), more(&over, 12.0), more(&many, 19.0), more(&many, 20.0)],
            [3.7 / 8.0, 0.0, 3.7 / 19.0, 0.0],
        );
        // The error is that of the terms, or the least one with Student's factor of 31 degrees of freedom.
        let least = scattering(&over, &over, &under, 0.0, 1.0, MANY).unwrap();
        near([least.high], [1.5 + 2.039_513_446]);
        // The independent runs show no variance of an output that has one.
        assert!(estimate(&over, &Parts::of([0.0; 32]), 0.0, 20.0).unwrap().value.is_nan());
    }

    /// Where both estimators are off by the same, no weight is better than another.
    #[test]
    fn estimators_that_scatter_alike_have_the_same_weight() {
        let under = Parts::of([1.0; 4]);
        let both = combined(&[1.0, 3.0, 3.0, 1.0], &[3.0, 5.0, 5.0, 3.0], &under);
        assert_eq!(both.terms, [2.0, 4.0, 4.0, 2.0]);
        assert_eq!(both.crosswise, both.terms);
        // No weight is negative, nor above 1: the better one is taken alone.
        let (wide, narrow) = ([1.0, 7.0, 1.0, 7.0], [3.0, 5.0, 3.0, 5.0]);
        assert_eq!(combined(&wide, &narrow, &under).terms, narrow);
        assert_eq!(combined(&narrow, &wide, &under).terms, narrow);
    }

    /// The weights that make the sum of squared deviations least, over all points or without one quarter of them, by
    /// scipy's `minimize_scalar`.
    #[test]
    fn each_part_of_the_points_is_weighted_by_the_others() {
        let first = [1.0, 3.0, 2.0, 5.0, 4.0, 4.0, 1.0, 2.0];
        let second = [2.0, 2.0, 4.0, 4.0, 2.0, 5.0, 3.0, 1.0];
        let under = Parts::of([1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
        let both = combined(&first, &second, &under);
        let of_others = [0.339_310, 0.315_789, 0.071_307, 0.444_822];
        for j in 0..8 {
            let with = |weight: f64| first[j] + weight * (second[j] - first[j]);
            assert!((both.terms[j] - with(0.295_345)).abs() < 1e-5);
            assert!((both.crosswise[j] - with(of_others[j / 2])).abs() < 1e-5);
        }
    }
}
