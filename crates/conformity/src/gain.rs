//! The interval of a gain: the difference of two means over the same points, of which one is weighted.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// One point in both studies, with its worth from 0 to 1 in either.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// The weight in the changed study.
    pub weight: f64,
    /// Its worth there.
    pub changed: f64,
    /// Its worth in the present one.
    pub now: f64,
}

/// The interval of the weighted mean of `changed` less the mean of `now`.
///
/// The weighted mean is linearised (Owen 2013, "Monte Carlo theory, methods and examples", 9.2), so that each point
/// contributes one difference; two intervals side by side would not count that a point shows in both means. The variance
/// is that with four points more, of which two are gained and two are lost: otherwise few points that all agree would have
/// an interval without width (after Agresti and Coull 1998, "Approximate is better than exact", The American Statistician
/// 52, who add so many to a share). Student's limit counts as many points as the weights leave.
pub fn interval(pairs: &[Pair], confidence: f64) -> [f64; 2] {
    const ADDED: f64 = 4.0;
    let n = pairs.len() as f64;
    let sum = |of: &dyn Fn(&Pair) -> f64| pairs.iter().map(of).sum::<f64>();
    let weights = sum(&|p| p.weight);
    let effective = weights * weights / sum(&|p| p.weight * p.weight);
    // Not a number where no weight is left at all.
    if effective.is_nan() || effective < 2.0 {
        return [-1.0, 1.0];
    }
    let changed = sum(&|p| p.weight * p.changed) / weights;
    let now = sum(&|p| p.now) / n;
    let difference = |p: &Pair| p.weight * n / weights * (p.changed - changed) - (p.now - now);
    // Each added point has the difference 1 or -1.
    let squares = sum(&|p| difference(p).powi(2)) + ADDED;
    let limit = StudentsT::new(0.0, 1.0, effective - 1.0)
        .map_or(f64::INFINITY, |student| student.inverse_cdf(0.5 + 0.5 * confidence));
    let half = limit * squares.sqrt() / (n + ADDED);
    let gain = changed - now;
    [(gain - half).max(-1.0), (gain + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use statrs::distribution::Normal;

    fn normal(random: &mut StdRng) -> f64 {
        Normal::standard().inverse_cdf(random.random_range(1e-12..1.0 - 1e-12))
    }

    /// Of a standard normal parameter, to one of half the spread.
    fn weight(x: f64) -> f64 {
        2.0 * (-1.5 * x * x).exp()
    }

    /// The share of 2,000 studies of `n` points whose interval holds the true gain, where the points with
    /// `|x - nominal| <= tolerance` are accepted and the spread of x is halved.
    fn coverage(n: usize, nominal: f64, tolerance: f64) -> f64 {
        let mut random = StdRng::seed_from_u64(1);
        let share = |spread: f64| {
            let below = |x: f64| Normal::standard().cdf(x / spread);
            below(nominal + tolerance) - below(nominal - tolerance)
        };
        let gain = share(0.5) - share(1.0);
        let held = (0..2000).filter(|_| {
            let pairs: Vec<Pair> = (0..n)
                .map(|_| {
                    let x = normal(&mut random);
                    let worth = f64::from(u8::from((x - nominal).abs() <= tolerance));
                    Pair { weight: weight(x), changed: worth, now: worth }
                })
                .collect();
            let [low, high] = interval(&pairs, 0.95);
            low <= gain && gain <= high
        });
        held.count() as f64 / 2000.0
    }

    #[test]
    fn the_interval_holds_the_true_gain() {
        for (n, nominal, tolerance) in
            [(50, 0.0, 0.5), (50, 0.0, 2.0), (50, 1.0, 0.3), (30, 0.0, 0.1), (200, 0.5, 0.5), (1000, 0.0, 0.02)]
        {
            let held = coverage(n, nominal, tolerance);
            assert!(held > 0.935, "{n} {nominal} {tolerance}: {held}");
        }
    }

    /// Weights by a parameter that has no influence change nothing.
    #[test]
    fn noise_is_seldom_told_from_0() {
        let mut random = StdRng::seed_from_u64(2);
        let wrong = (0..2000).filter(|_| {
            let pairs: Vec<Pair> = (0..50)
                .map(|_| {
                    let worth = f64::from(u8::from(random.random_range(0.0..1.0) < 0.22));
                    Pair { weight: weight(normal(&mut random)), changed: worth, now: worth }
                })
                .collect();
            let [low, high] = interval(&pairs, 0.95);
            low > 0.0 || high < 0.0
        });
        let share = wrong.count() as f64 / 2000.0;
        assert!(share < 0.065, "{share}");
    }

    /// An eighth of the points are gained: the differences scatter by 1/8 times 7/8.
    #[test]
    fn equal_weights_leave_the_paired_difference() {
        let pairs: Vec<Pair> = (0..400)
            .map(|i| Pair {
                weight: 1.0,
                changed: f64::from(u8::from(i % 4 == 0)),
                now: f64::from(u8::from(i % 8 == 0)),
            })
            .collect();
        let [low, high] = interval(&pairs, 0.95);
        let half = 1.965_927 * (400.0_f64 * 0.125 * 0.875 + 4.0).sqrt() / 404.0;
        assert!((0.5 * (low + high) - 0.125).abs() < 1e-12);
        assert!((0.5 * (high - low) / half - 1.0).abs() < 1e-5);
    }

    #[test]
    fn points_that_agree_have_an_interval_with_width() {
        let same = |n| vec![Pair { weight: 1.0, changed: 0.0, now: 0.0 }; n];
        let [low, high] = interval(&same(50), 0.95);
        assert!(low < -0.02 && high > 0.02, "{low} {high}");
        assert_eq!(interval(&same(1), 0.95), [-1.0, 1.0]);
        assert_eq!(interval(&[], 0.95), [-1.0, 1.0]);
    }
}
