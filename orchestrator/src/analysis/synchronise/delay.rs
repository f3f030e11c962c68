//! The delay between two signals of which one should be proportional to the other.
//!
//! The friction coefficient mu(t) = M(t) / (F_N(t) D/2) of a steady state hardly varies. Where the
//! torque channel lags behind the load channel, it seems to. The delay is the shift of the torque
//! that leaves the least variance of mu (Vrublevskyi & Skonieczna, section 5.1).

use super::signal::{Even, SignalError, Spline};
use crate::analysis::sensitivity::Estimate;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The delay that was found, with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Delay {
    /// How much later the torque is than the load, s, with its 95 % interval.
    pub delay: Estimate,
    /// Relative standard deviation of mu before the shift.
    pub before: f64,
    /// Relative standard deviation of mu after it.
    pub after: f64,
    /// Relative standard deviation of mu by delays, s, over the range that was searched.
    pub scan: Vec<(f64, f64)>,
    /// The delays of parts of the record, s, of which the interval is made.
    pub parts: Vec<f64>,
    /// Whether the least variance lies at the edge of the searched range: then it is no minimum.
    pub at_edge: bool,
}

/// Parts of the record of which each gives a delay of its own, for the uncertainty.
const PARTS: usize = 16;

/// Finds the delay of `late` (torque) after `base` (load), searched within `longest` seconds to
/// either side. Both should be smoothed alike before, so that the interpolation between samples
/// is true; `late` is a spline and `base` even samples.
///
/// The variance is scanned at steps of the samples and its minimum refined by golden section. The
/// interval is Student's, from the delays of 16 parts of the record.
pub fn find(base: &Even, late: &Spline, longest: f64) -> Result<Delay, SignalError> {
    let (start, end) = late.span();
    let times = base.times();
    // The samples whose shifted partner exists for every delay that is tried.
    let kept: Vec<(f64, f64)> = times
        .iter()
        .zip(&base.values)
        .filter(|(t, _)| **t - longest >= start && **t + longest <= end)
        .map(|(t, v)| (*t, *v))
        .collect();
    if kept.len() < 20 * PARTS {
        return Err(SignalError::TooShort {
            name: "load".into(),
            found: kept.len(),
            needed: 20 * PARTS,
        });
    }
    if kept.iter().any(|(_, v)| *v == 0.0) {
        return Err(SignalError::Setting(
            "the load passes through zero: M/F_N has no meaning there".into(),
        ));
    }
    // The coarse scan needs no more samples than to see the shape.
    let thin: Vec<(f64, f64)> = kept
        .iter()
        .copied()
        .step_by((kept.len() / 4000).max(1))
        .collect();
    let half = (longest / base.step).floor() as i64;
    let scan: Vec<(f64, f64)> = (-half..=half)
        .map(|k| k as f64 * base.step)
        .map(|delay| (delay, scatter(&thin, late, delay)))
        .collect();
    let least = scan.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let coarse = least.map_or(0.0, |(delay, _)| *delay);
    let around = |points: &[(f64, f64)], centre: f64, width: f64| {
        golden(centre - width, centre + width, |d| scatter(points, late, d))
    };
    let reach = (2.0 * base.step).max(longest / 50.0).min(longest);
    let best = around(&kept, coarse, reach).clamp(-longest, longest);
    let parts: Vec<f64> = kept
        .chunks(kept.len().div_ceil(PARTS))
        .map(|part| around(part, best, reach))
        .collect();
    let n = parts.len() as f64;
    let mean = parts.iter().sum::<f64>() / n;
    let error = (parts.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
    let quantile = StudentsT::new(0.0, 1.0, n - 1.0).map_or(2.131, |t| t.inverse_cdf(0.975));
    Ok(Delay {
        delay: Estimate::around(best, quantile * error),
        before: scatter(&kept, late, 0.0),
        after: scatter(&kept, late, best),
        scan,
        parts,
        at_edge: coarse.abs() >= longest - 1.5 * base.step,
    })
}

/// Relative standard deviation of late(t + delay) / base(t).
fn scatter(points: &[(f64, f64)], late: &Spline, delay: f64) -> f64 {
    let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
    for (t, v) in points {
        let ratio = late.at(t + delay) / v;
        n += 1.0;
        let off = ratio - mean;
        mean += off / n;
        squares += off * (ratio - mean);
    }
    (squares / n).sqrt() / mean.abs()
}

/// The place of the least value between two places, by golden section (Kiefer 1953).
fn golden(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut c, mut d) = (b - RATIO * (b - a), a + RATIO * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    // 2e-7 s is far below any delay that could matter.
    while b - a > 2e-7 {
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - RATIO * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + RATIO * (b - a);
            fd = f(d);
        }
    }
    (a + b) / 2.0
}

#[cfg(test)]
mod tests {
    use super::super::smooth::Smoothing;
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use rand_distr::StandardNormal;
    use std::f64::consts::PI;

    const STEP: f64 = 1e-3;
    const DELAY: f64 = 0.016;

    /// The paper's record: 300 rpm, power between 4 and 22 W, a second harmonic; 5 % noise on
    /// both channels, of their means.
    fn record(seconds: f64, delay: f64, seed: u64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let mut random = StdRng::seed_from_u64(seed);
        let mut noise = || random.sample::<f64, _>(StandardNormal);
        let wave = |t: f64| {
            1.0 + 0.64 * (2.0 * PI * 5.0 * t).sin() + 0.05 * (2.0 * PI * 10.0 * t + 0.6).sin()
        };
        let time: Vec<f64> = (0..(seconds / STEP) as usize)
            .map(|k| k as f64 * STEP)
            .collect();
        let load = time
            .iter()
            .map(|t| 750.0 * (wave(*t) + 0.05 * noise()))
            .collect();
        let torque = time
            .iter()
            .map(|t| 0.443 * (wave(t - delay) + 0.05 * noise()))
            .collect();
        (time, load, torque)
    }

    fn found(time: &[f64], load: &[f64], torque: &[f64]) -> Delay {
        let smoothing = Smoothing::Butterworth {
            cutoff: 40.0,
            order: 4,
        };
        let load = Even {
            start: 0.0,
            step: STEP,
            values: smoothing.apply(load, STEP).unwrap(),
        };
        let torque = smoothing.apply(torque, STEP).unwrap();
        find(
            &load,
            &Spline::new("torque", time, &torque, 5.0).unwrap(),
            0.05,
        )
        .unwrap()
    }

    #[test]
    fn the_delay_is_found_within_a_tenth_of_a_millisecond() {
        let mut held = 0;
        for seed in 0..100 {
            let (time, load, torque) = record(60.0, DELAY, seed);
            let d = found(&time, &load, &torque);
            assert!((d.delay.value - DELAY).abs() < 1e-4, "{seed}: {d:?}");
            assert!(d.after < 0.5 * d.before && !d.at_edge);
            held += usize::from(d.delay.contains(DELAY));
        }
        assert!(held >= 90, "{held} of 100 intervals hold the delay");
    }

    #[test]
    fn a_delay_between_samples_and_to_the_other_side() {
        let (time, load, torque) = record(20.0, -0.003_37, 1);
        let d = found(&time, &load, &torque);
        assert!((d.delay.value + 0.003_37).abs() < 1e-4, "{d:?}");
    }

    #[test]
    fn no_minimum_within_the_range_is_said() {
        let (time, load, torque) = record(20.0, 0.065, 1);
        assert!(found(&time, &load, &torque).at_edge);
    }
}
