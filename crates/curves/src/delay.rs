//! How far a measured curve is behind a simulated one.

use crate::curve::Curve;

/// The most delays that are tried before the best of them are refined.
const MOST: f64 = 4000.0;
/// How many of them are refined.
const REFINED: usize = 3;

/// A delay that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// By how much the reference is late: its value at `t` belongs to the model's at `t - delay`.
    pub delay: f64,
    /// The root of the mean square of the deviations that is left.
    pub rmse: f64,
}

/// Finds the delay in a range that leaves the least rmse at the reference's times.
///
/// First it tries delays at a distance of half the reference's usual step, or a 4,000th of the range where that is more.
/// Then it refines the best three of those that are better than their neighbours, each between these, by a golden
/// section search. A valley that is narrower than the distance of the delays that it tries can be missed. Of equally
/// good delays the smallest counts.
///
/// # Errors
/// The first time at which the model's value would be needed and is not there.
pub fn find(reference: &Curve, model: &Curve, [least, most]: [f64; 2]) -> Result<Found, f64> {
    let ([begin, end], [first, last]) = (reference.span(), model.span());
    let slack = 1e-9 * (first.abs() + last.abs());
    if begin - most < first - slack {
        return Err(begin - most);
    }
    if end - least > last + slack {
        return Err(end - least);
    }
    let parts = (2.0 * (most - least) / reference.step()).ceil();
    let parts = parts.clamp(1.0, MOST) as usize;
    let place = |part: usize| least + (most - least) * (part as f64 / parts as f64);
    let tried: Vec<Found> = (0..=parts).map(|part| at(reference, model, place(part))).collect();
    let rank = |a: &Found, b: &Found| a.rmse.total_cmp(&b.rmse).then(a.delay.abs().total_cmp(&b.delay.abs()));
    let mut valleys: Vec<usize> = (0..=parts)
        .filter(|&part| {
            let lower = |other: Option<&Found>| other.is_none_or(|other| tried[part].rmse <= other.rmse);
            lower(part.checked_sub(1).map(|before| &tried[before])) && lower(tried.get(part + 1))
        })
        .collect();
    valleys.sort_by(|&a, &b| rank(&tried[a], &tried[b]));
    Ok(valleys
        .iter()
        .take(REFINED)
        .flat_map(|&part| {
            let ends = [place(part.saturating_sub(1)), place((part + 1).min(parts))];
            [tried[part], golden(ends, |delay| at(reference, model, delay))]
        })
        .min_by(rank)
        .unwrap_or(tried[0]))
}

/// The rmse for one delay. The model's times must reach far enough, but for rounding.
pub fn at(reference: &Curve, model: &Curve, delay: f64) -> Found {
    let [first, last] = model.span();
    let (mut after, mut squares) = (0, 0.0);
    for (time, value) in reference.times().iter().zip(reference.values()) {
        let time = (time - delay).clamp(first, last);
        while model.times()[after] < time {
            after += 1;
        }
        squares += (model.between(after, time) - value).powi(2);
    }
    Found { delay, rmse: (squares / reference.times().len() as f64).sqrt() }
}

/// The least of a function with one valley between two ends.
fn golden([mut a, mut b]: [f64; 2], of: impl Fn(f64) -> Found) -> Found {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let inner = |a: f64, b: f64| [b - RATIO * (b - a), a + RATIO * (b - a)];
    let [mut low, mut high] = inner(a, b).map(&of);
    for _ in 0..80 {
        if low.rmse <= high.rmse {
            (b, high) = (high.delay, low);
            low = of(inner(a, b)[0]);
        } else {
            (a, low) = (low.delay, high);
            high = of(inner(a, b)[1]);
        }
    }
    if low.rmse <= high.rmse { low } else { high }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(count: i32, step: f64, value: impl Fn(f64) -> f64) -> Curve {
        let times: Vec<f64> = (0..count).map(|k| step * f64::from(k)).collect();
        let values = times.iter().map(|&time| value(time)).collect();
        Curve::new(times, values).unwrap()
    }

    #[test]
    fn a_delay_within_a_sample_is_found() {
        let model = curve(4001, 0.005, |t| (-0.3 * t).exp() * (2.0 * t).sin());
        for delay in [0.0, 0.137, -0.821, 0.5] {
            let late = |t: f64| (-0.3 * (t - delay)).exp() * (2.0 * (t - delay)).sin();
            let reference = curve(160, 0.1, late).cut([2.0, 14.0]).unwrap();
            let fit = find(&reference, &model, [-1.0, 1.0]).unwrap();
            assert!((fit.delay - delay).abs() < 1e-4, "{delay}: {fit:?}");
            assert!(fit.rmse < 1e-5);
        }
    }

    #[test]
    fn without_a_difference_the_smallest_delay_counts() {
        let flat = |count| curve(count, 0.1, |_| 1.0);
        let fit = find(&flat(100).cut([2.0, 4.0]).unwrap(), &flat(100), [-1.0, 1.0]).unwrap();
        assert_eq!((fit.delay, fit.rmse), (0.0, 0.0));
    }

    #[test]
    fn the_model_must_reach_far_enough() {
        let line = curve(11, 1.0, |t| t);
        assert_eq!(find(&line, &line, [0.0, 1.0]), Err(-1.0));
        assert_eq!(find(&line, &line, [-2.0, 0.0]), Err(12.0));
        assert_eq!(find(&line, &line, [0.0, 0.0]).map(|fit| fit.rmse), Ok(0.0));
    }
}
