//! First-order indices of outputs that are pass or fail, of which one hardly ever occurs.
//!
//! Such an index is (q - p^2) / (p (1 - p)) with the probability p of the rare value, and q of two of them in runs that
//! share nothing but the parameter. Where hardly any such pair was seen, the scatter of the runs does not show how many there
//! could be: the interval of q is Clopper and Pearson's then.

use conformity::interval::clopper_pearson;

use sampling::statistics::estimate::Estimate;

/// So many pairs show their scatter themselves.
const ENOUGH: usize = 3;

/// The estimate of a first-order index, with a wider interval where the output has two values and hardly any of the `pairs`
/// with the parameter in common has the rarer one twice. `ends` are the independent runs.
pub(crate) fn widened<P: Iterator<Item = [f64; 2]>>(
    estimate: Estimate,
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
    Estimate { low: estimate.low.min(low), high: estimate.high.max(high.min(1.0)), ..estimate }
}

/// The rarer one of two values, and its share; nothing where there are more, or one only, or runs without a value.
fn rarer(ends: &[[f64; 2]]) -> Option<(f64, f64)> {
    let values = || ends.iter().flatten().copied();
    let first = values().next()?;
    let other = values().find(|value| *value != first)?;
    if values().any(|value| value != first && value != other) {
        return None;
    }
    let share = values().filter(|value| *value == first).count() as f64 / (2 * ends.len()) as f64;
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
        let interval = widened(narrow, &ends, none);
        // Clopper and Pearson: 1 - 0.025^(1/100) = 0.0362 of the pairs at most.
        let p: f64 = 0.01;
        let most = (0.036_217 - p * p) / (p * (1.0 - p));
        assert!(most > 1.0 && interval.high == 1.0 && interval.low < -0.0149, "{interval:?}");
        // Many pairs tell by themselves, and so do values of other kinds.
        let many = || (0..100).map(|k| [f64::from(u8::from(k < 5)); 2]);
        assert_eq!(widened(narrow, &ends, many), narrow);
        ends[7][0] = 0.5;
        assert_eq!(widened(narrow, &ends, none), narrow);
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
        let interval = widened(Estimate::around(-0.3, 0.01), &ends, one);
        let index = |q: f64| (q - 0.09) / 0.21;
        assert!((interval.low - index(0.000_253_146)).abs() < 1e-6, "{interval:?}");
        assert!((interval.high - index(0.054_459_4)).abs() < 1e-6, "{interval:?}");
        assert_eq!(interval.value, -0.3);
        // Whether the rare value comes first does not matter, nor do ends that the scatter sets wider.
        ends.reverse();
        let turned = widened(Estimate::around(-0.3, 0.01), &ends, one);
        holds(turned, [-0.3, interval.low, interval.high]);
        let wide = Estimate::around(-0.3, 0.9);
        assert_eq!(widened(wide, &ends, one), wide);
    }
}
