//! Deciding while points are still coming in.
//!
//! An interval for a fixed number of points is right at that number. Who looks at it again and again
//! and stops when it suits finds a wrong answer far more often: Wilson's 95 % interval, looked at
//! every 50 points, excludes the true share at some time in a fifth of the cases. A confidence sequence
//! holds the true share at all times together with the stated probability.

use statrs::function::{beta::beta_reg, gamma::ln_gamma};

use super::{decision::Rule, interval::crossing};

/// Intervals of a share from independent points, valid at all numbers of points together.
///
/// The likelihood ratio of a mixture of all shares (here with Jeffreys' weights) to one share is a
/// martingale if that share is the true one, so that it ever exceeds 1/a with a probability of at most
/// a (Ville 1939). The interval holds the shares for which it does not (Robbins 1970, "Statistical
/// methods related to the law of the iterated logarithm", Annals of Mathematical Statistics 41;
/// Howard, Ramdas, McAuliffe and Sekhon 2021, "Time-uniform, nonparametric, nonasymptotic confidence
/// sequences", Annals of Statistics 49).
#[derive(Clone, Copy, Debug)]
pub struct ConfidenceSequence {
    /// The probability that all intervals hold the true share.
    pub confidence: f64,
}

impl ConfidenceSequence {
    /// The interval after a number of points.
    pub fn interval(&self, hits: u64, points: u64) -> [f64; 2] {
        let limit = -(1.0 - self.confidence).ln();
        let (k, n) = (hits as f64, points as f64);
        let best = if points == 0 { 0.5 } else { k / n };
        let evidence = |share: f64| log_ratio(k, n, share) - limit;
        let low = best * crossing(|part| -evidence(best * part))[0];
        let rest = 1.0 - best;
        let high = best + rest * crossing(|part| evidence(best + rest * part))[1];
        [low, high]
    }

    /// Whether a share lies outside of the interval after so many points.
    pub fn excludes(&self, share: f64, hits: u64, points: u64) -> bool {
        log_ratio(hits as f64, points as f64, share) >= -(1.0 - self.confidence).ln()
    }
}

/// After about how many points the sequence would decide, if the share stays what it is; none where the
/// share is the required one, or so near that a thousand billion points would not be enough.
pub fn points_needed(rule: Rule, share: f64) -> Option<u64> {
    let limit = -(1.0 - rule.confidence).ln();
    least_points(|n| log_ratio(share * n, n, rule.share) >= limit)
}

/// How many points would decide at a single look, whose number is fixed beforehand (see
/// [`clopper_pearson`](super::interval::clopper_pearson)), if their share is this one; none as above.
pub fn points_needed_once(rule: Rule, share: f64) -> Option<u64> {
    // Of equal shares rounding would decide.
    if share == rule.share {
        return None;
    }
    let tail = 0.5 * (1.0 - rule.confidence);
    least_points(|n| {
        let (hits, misses) = (share * n, (1.0 - share) * n);
        if share > rule.share {
            beta_reg(hits, misses + 1.0, rule.share) <= tail
        } else {
            beta_reg(hits + 1.0, misses, rule.share) > 1.0 - tail
        }
    })
}

/// The smallest number of points that is enough. Assumes that every larger number is enough, too.
fn least_points(enough: impl Fn(f64) -> bool) -> Option<u64> {
    const MOST: u64 = 1 << 40;
    let mut most = 1;
    while !enough(most as f64) {
        most *= 2;
        if most > MOST {
            return None;
        }
    }
    let mut few = most / 2;
    while most - few > 1 {
        let middle = few + (most - few) / 2;
        if enough(middle as f64) {
            most = middle;
        } else {
            few = middle;
        }
    }
    Some(most)
}

/// The logarithm of the likelihood of all shares, with Jeffreys' weights, relative to that of one
/// share.
fn log_ratio(hits: f64, points: f64, share: f64) -> f64 {
    let ln_beta = |a: f64, b: f64| ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
    let misses = points - hits;
    let mixture = ln_beta(hits + 0.5, misses + 0.5) - std::f64::consts::PI.ln();
    // A share of 0 is as good as any other while there are no hits: 0 times infinity is 0 here.
    let term = |count: f64, p: f64| if count == 0.0 { 0.0 } else { count * p.ln() };
    mixture - term(hits, share) - term(misses, 1.0 - share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::Decision;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use sampling::statistics::share::wilson;

    const NINETY_FIVE: ConfidenceSequence = ConfidenceSequence { confidence: 0.95 };

    /// With one hit of one point the mixture's likelihood is 1/2: excluded are shares below 1/40.
    #[test]
    fn intervals_of_few_points_by_hand() {
        assert_eq!(NINETY_FIVE.interval(0, 0), [0.0, 1.0]);
        let [low, high] = NINETY_FIVE.interval(1, 1);
        assert!((low - 0.025).abs() < 1e-12 && high == 1.0, "{low}");
        let [low, high] = NINETY_FIVE.interval(0, 1);
        assert!((high - 0.975).abs() < 1e-12 && low == 0.0, "{high}");
        // Two points, one hit: the mixture's likelihood is 1/8, so that p (1 - p) = 1/160.
        let [low, high] = NINETY_FIVE.interval(1, 2);
        let expected = 0.5 - (0.25_f64 - 1.0 / 160.0).sqrt();
        assert!((low - expected).abs() < 1e-12, "{low}");
        assert!((high - (1.0 - expected)).abs() < 1e-12, "{high}");
    }

    #[test]
    fn intervals_shrink_around_the_share() {
        let mut width = 1.0;
        for points in [10, 100, 1000, 10_000, 1_000_000] {
            let [low, high] = NINETY_FIVE.interval(points / 5, points);
            assert!(low < 0.2 && high > 0.2 && high - low < width);
            width = high - low;
        }
        assert!(width < 5.5 * (0.2 * 0.8 / 1e6_f64).sqrt() * 2.0, "{width}");
    }

    #[test]
    fn the_search_for_the_least_number_ends_at_a_thousand_billion() {
        for least in [1, 2, 3, 1000, (1 << 39) + 1, 1 << 40] {
            assert_eq!(least_points(|n| n >= least as f64), Some(least));
        }
        assert_eq!(least_points(|n| n > (1_u64 << 40) as f64), None);
    }

    #[test]
    fn the_points_needed_are_those_at_which_it_is_decided() {
        let rule = Rule { share: 0.05, confidence: 0.95 };
        for (share, decision) in [(0.1, Decision::Verified), (0.02, Decision::NotVerified)] {
            let points = points_needed(rule, share).unwrap();
            let at = |n: u64| {
                let hits = (share * n as f64).round() as u64;
                rule.decide(NINETY_FIVE.interval(hits, n))
            };
            assert_eq!(at(points + 50), decision);
            assert_eq!(at(points - 50), Decision::Inconclusive);
        }
        assert_eq!(points_needed(rule, 0.05), None);
        assert!(points_needed(rule, 0.0501).unwrap() > 10_000_000);
    }

    /// Every number of points is tried, with the nearest whole number of accepted ones, from the
    /// first look on: from the number needed on, but for rounding, all are decided, and hardly any before.
    #[test]
    fn the_points_needed_at_one_look_are_those_at_which_it_is_decided() {
        use crate::interval::clopper_pearson;
        for (hits, points, required, published) in [
            // The shares and, by another program, the first number of points that decides.
            (87, 400, 0.2, 2090),
            (0, 50, 0.05, 72),
            (60, 1000, 0.05, 1959),
            (20, 20, 0.9, 36),
            (19, 20, 0.99, 51),
            (0, 10, 0.001, 3691),
            (1, 64, 0.05, 142),
        ] {
            let rule = Rule { share: required, confidence: 0.95 };
            let share = f64::from(hits) / f64::from(points);
            let decided = |n: u64| {
                let hits = (share * n as f64).round();
                let decision = rule.decide(clopper_pearson(hits, n as f64, 0.95));
                decision != Decision::Inconclusive
            };
            let needed = points_needed_once(rule, share).unwrap();
            // A rounded count is off by half a point at most, which so many points make up for at the limit.
            let off = (1.0 / (share - required).abs()).ceil() as u64 + 1;
            let first = (1..).find(|&n| decided(n)).unwrap();
            assert!(first + off >= needed && first <= needed + off, "{needed} {first}");
            assert!((needed + off..needed + 20 * off).all(decided), "{needed}");
            assert!(needed.abs_diff(published) <= off, "{needed} {published}");
            // Waiting takes longer.
            assert!(points_needed(rule, share).unwrap() > needed);
        }
        let rule = Rule { share: 0.05, confidence: 0.95 };
        assert_eq!(points_needed_once(rule, 0.05), None);
        assert!(points_needed_once(rule, 0.0501).unwrap() > 10_000_000);
        assert!(points_needed_once(rule, 1.0).unwrap() <= 2);
    }

    /// Looks at every point of 1,000 studies: in how many does the interval ever exclude the true
    /// share? Wilson's interval shows that the test would notice.
    #[test]
    fn the_true_share_is_hardly_ever_excluded() {
        for share in [0.02, 0.3] {
            let mut random = StdRng::seed_from_u64(4);
            let (mut excluded, mut wilson_excluded) = (0, 0);
            for _ in 0..1000 {
                let (mut hits, mut wrong, mut wilson_wrong) = (0, false, false);
                for points in 1..=2000 {
                    hits += u64::from(random.random::<f64>() < share);
                    let k = hits as f64;
                    wrong |= log_ratio(k, points as f64, share) >= 20.0_f64.ln();
                    if points % 50 == 0 {
                        let observed = k / points as f64;
                        let [low, high] = wilson(observed, points as f64, 0.95);
                        wilson_wrong |= share < low || share > high;
                    }
                }
                excluded += u32::from(wrong);
                wilson_excluded += u32::from(wilson_wrong);
            }
            assert!(excluded <= 50, "{share}: {excluded}");
            assert!(wilson_excluded > 150, "{share}: {wilson_excluded}");
        }
    }
}
