//! Indices of outputs that are pass or fail, of which one hardly ever occurs.
//!
//! With the probability p of the rare value, and q of two of them in runs that share nothing but the parameter, a first-order index
//! is (q - p^2) / (p (1 - p)); a total one is 1 minus the same of runs that share all but the parameter. Where hardly any such
//! pair was seen, the scatter of the runs does not show how many there could be: the interval of q is Clopper and Pearson's then.
//! Where hardly any run has the rare value, nothing shows how often it occurs.

use conformity::interval::clopper_pearson;

use sampling::statistics::estimate::Estimate;

/// So many pairs show their scatter themselves.
const ENOUGH: usize = 3;

/// What pairs of runs share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shared {
    /// The parameter alone: they tell its first-order index.
    Parameter,
    /// All others: they tell its total index.
    Others,
}

/// The estimate of an index, with a wider interval where the output has two values and hardly any of the `pairs` has the rarer one
/// twice. `ends` are the independent runs.
pub(crate) fn widened<P: Iterator<Item = [f64; 2]>>(
    estimate: Estimate,
    shared: Shared,
    ends: &[[f64; 2]],
    pairs: impl Fn() -> P,
) -> Estimate {
    let Some((rare, share)) = rarer(ends) else {
        return estimate;
    };
    let count = pairs().count();
    let both = pairs().filter(|pair| *pair == [rare; 2]).count();
    if both >= ENOUGH {
        return estimate;
    }
    let index = |q: f64| (q - share * share) / (share * (1.0 - share));
    let [low, high] = clopper_pearson(both as f64, count as f64, 0.95).map(index);
    let [low, high] = match shared {
        Shared::Parameter => [low, high],
        Shared::Others => [(1.0 - high).max(0.0), 1.0 - low],
    };
    Estimate { low: estimate.low.min(low), high: estimate.high.max(high.min(1.0)), ..estimate }
}

/// The estimates, without intervals where few runs carry the variance, such as a jump in one of a hundred: how many more there are,
/// nothing shows. Without them, too, where the output has two values and the rarer one was seen in no more than so `few` of the
/// independent runs, the `ends`; without values, too, where these show no variance of an output that has one.
pub(crate) fn where_seen(estimates: &mut [Estimate], outputs: &[f64], ends: &[[f64; 2]], few: usize) {
    let Some(both) = two(outputs.iter().copied().filter(|value| value.is_finite())) else {
        if carriers(ends) < CARRIERS {
            estimates.iter_mut().for_each(|estimate| *estimate = Estimate::around(estimate.value, f64::NAN));
        }
        return;
    };
    let counts = both.map(|one| ends.iter().flatten().filter(|value| **value == one).count());
    let seen = counts[0].min(counts[1]);
    if seen <= few {
        let value = |estimate: &Estimate| if seen == 0 { f64::NAN } else { estimate.value };
        estimates.iter_mut().for_each(|estimate| *estimate = Estimate::around(value(estimate), f64::NAN));
    }
}

/// Fewer independent runs than these that carry an output's variance tell no interval of its parts: 128 normal numbers have 43.
const CARRIERS: f64 = 8.0;

/// How many of the independent runs carry the variance: all of them where each is as far from the mean, 1 where one is far off.
fn carriers(ends: &[[f64; 2]]) -> f64 {
    let centre = crate::ratio::centre(ends);
    let squares = ends.iter().flatten().map(|value| (value - centre).powi(2)).filter(|square| square.is_finite());
    let [sum, of_squares] = squares.fold([0.0, 0.0], |[sum, of], square| [sum + square, of + square * square]);
    if of_squares > 0.0 { sum * sum / of_squares } else { f64::INFINITY }
}

/// The values, where there are two.
fn two(values: impl Iterator<Item = f64> + Clone) -> Option<[f64; 2]> {
    let first = values.clone().next()?;
    let other = values.clone().find(|value| *value != first)?;
    values.clone().all(|value| value == first || value == other).then_some([first, other])
}

/// The rarer one of two values, and its share; nothing where there are more, or one only, or runs without a value.
fn rarer(ends: &[[f64; 2]]) -> Option<(f64, f64)> {
    let [first, other] = two(ends.iter().flatten().copied())?;
    let share = ends.iter().flatten().filter(|value| **value == first).count() as f64 / (2 * ends.len()) as f64;
    Some(match share <= 0.5 {
        true => (first, share),
        false => (other, 1.0 - share),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::holds;

    /// 2 of 200 runs have the rare value: an index of 0 is not known to a hundredth.
    #[test]
    fn an_index_without_pairs_of_the_rare_value_is_not_called_known() {
        let mut ends = vec![[0.0; 2]; 100];
        (ends[3][0], ends[60][1]) = (1.0, 1.0);
        let narrow = Estimate::around(-0.01, 0.005);
        let none = || (0..100).map(|_| [0.0; 2]);
        let interval = widened(narrow, Shared::Parameter, &ends, none);
        // Clopper and Pearson: 1 - 0.025^(1/100) = 0.0362 of the pairs at most.
        let p: f64 = 0.01;
        let most = (0.036_217 - p * p) / (p * (1.0 - p));
        assert!(most > 1.0 && interval.high == 1.0 && interval.low < -0.0149, "{interval:?}");
        // Many pairs tell by themselves, and so do values of other kinds.
        let many = || (0..100).map(|k| [f64::from(u8::from(k < 5)); 2]);
        assert_eq!(widened(narrow, Shared::Parameter, &ends, many), narrow);
        ends[7][0] = 0.5;
        assert_eq!(widened(narrow, Shared::Parameter, &ends, none), narrow);
    }

    /// One pair of 100, where the rare value has a share of 0.3: both ends of Clopper and Pearson's interval (0.000 253 and
    /// 0.054 459, as scipy has them) as an index, (q - p^2) / (p (1 - p)).
    #[test]
    fn the_interval_is_that_of_the_pairs() {
        let mut ends = vec![[0.0; 2]; 100];
        for pair in ends.iter_mut().take(30) {
            *pair = [1.0; 2];
        }
        let one = || (0..100).map(|k| [f64::from(u8::from(k == 0)); 2]);
        let interval = widened(Estimate::around(-0.3, 0.01), Shared::Parameter, &ends, one);
        let index = |q: f64| (q - 0.09) / 0.21;
        assert!((interval.low - index(0.000_253_146)).abs() < 1e-6, "{interval:?}");
        assert!((interval.high - index(0.054_459_4)).abs() < 1e-6, "{interval:?}");
        assert_eq!(interval.value, -0.3);
        // Whether the rare value comes first does not matter, nor do ends that the scatter sets wider.
        ends.reverse();
        let turned = widened(Estimate::around(-0.3, 0.01), Shared::Parameter, &ends, one);
        holds(turned, [-0.3, interval.low, interval.high]);
        // A total index is 1 minus that, and no more than 1 by it.
        let total = widened(Estimate::around(0.9, 0.01), Shared::Others, &ends, one);
        holds(total, [0.9, 0.89, 1.0]);
        let total = widened(Estimate::around(1.3, 0.01), Shared::Others, &ends, one);
        holds(total, [1.3, 1.0 - interval.high, 1.31]);
        let wide = Estimate::around(-0.3, 0.9);
        assert_eq!(widened(wide, Shared::Parameter, &ends, one), wide);
    }

    /// 2 of 20 independent runs, and one that is none of them.
    #[test]
    fn what_was_hardly_seen_has_no_interval() {
        let mut ends = vec![[0.0; 2]; 10];
        let told = |outputs: &[f64], ends: &[[f64; 2]], few| {
            let mut estimates = [Estimate::around(0.4, 0.1)];
            where_seen(&mut estimates, outputs, ends, few);
            estimates[0]
        };
        let none = told(&[0.0, 1.0, f64::NAN], &ends, 0);
        assert!(none.value.is_nan() && none.low.is_nan());
        (ends[3][0], ends[7][1]) = (1.0, 1.0);
        let few = told(&[0.0, 1.0], &ends, 2);
        assert!(few.value == 0.4 && few.high.is_nan());
        holds(told(&[0.0, 1.0], &ends, 1), [0.4, 0.3, 0.5]);
        // Two runs of twenty carry most of the variance of an output of any values; twenty carry all of it alike.
        assert!(told(&[0.0, 1.0, 2.0], &ends, 0).high.is_nan());
        for outputs in [&[0.0, 1.0, 2.0][..], &[0.0, 0.0]] {
            holds(told(outputs, &[[0.0, 1.0]; 10], 0), [0.4, 0.3, 0.5]);
        }
    }
}
