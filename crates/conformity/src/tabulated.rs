//! The normal distribution for integrals that need it a thousand times for every point: a few nanoseconds a value.

use std::{f64::consts::TAU, sync::LazyLock};

use super::normal;

/// Beyond this many standard deviations nothing is left.
const FAR: f64 = 8.5;
/// Intervals of the table on every unit.
const PER_UNIT: f64 = 32.0;

/// Values and slopes of the distribution function, made at the first use.
static TABLE: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    let steps = (2.0 * FAR * PER_UNIT) as i32;
    (0..=steps + 1)
        .map(|i| {
            let z = f64::from(i) / PER_UNIT - FAR;
            [normal::cdf(z), (-0.5 * z * z).exp() / TAU.sqrt() / PER_UNIT]
        })
        .collect()
});

/// The probability that a standard normal number is below `z`, to 4e-9: by Hermite's cubic between the table's
/// values.
pub fn cdf(z: f64) -> f64 {
    if z <= -FAR {
        return 0.0;
    }
    if z >= FAR {
        return 1.0;
    }
    let place = (z + FAR) * PER_UNIT;
    let index = place as usize;
    let table: &[[f64; 2]] = &TABLE;
    let ([a, slope_a], [b, slope_b]) = (table[index], table[index + 1]);
    let t = place - index as f64;
    let rest = 1.0 - t;
    // Hermite's cubic: what the slopes at both ends add to the straight line between them.
    let bend = t * rest * ((slope_a - (b - a)) * rest + ((b - a) - slope_b) * t);
    a + t * (b - a) + bend
}

/// The quantile of a standard normal number, to 1e-7 of its value (Wichura 1988, "Algorithm AS 241: The percentage
/// points of the normal distribution", Applied Statistics 37, PPND7).
pub fn quantile(probability: f64) -> f64 {
    const SPLIT: f64 = 0.425;
    let q = probability - 0.5;
    if q.abs() <= SPLIT {
        let r = SPLIT * SPLIT - q * q;
        let above = [3.387_132_717_9, 50.434_271_938, 159.291_132_02, 59.109_374_720];
        let below = [1.0, 17.895_169_469, 78.757_757_664, 67.187_563_600];
        return q * polynomial(above, r) / polynomial(below, r);
    }
    let tail = probability.min(1.0 - probability);
    if tail <= 0.0 {
        return FAR.copysign(q);
    }
    let r = (-tail.ln()).sqrt();
    let size = if r <= 5.0 {
        let above = [1.423_437_277_7, 2.756_815_390_0, 1.306_728_481_6, 0.170_238_211_03];
        let below = [1.0, 0.737_001_642_50, 0.120_211_329_75, 0.0];
        polynomial(above, r - 1.6) / polynomial(below, r - 1.6)
    } else {
        let above = [6.657_905_115_0, 3.081_226_386_0, 0.428_682_943_37, 0.017_337_203_997];
        let below = [1.0, 0.241_978_942_25, 0.012_258_202_635, 0.0];
        polynomial(above, r - 5.0) / polynomial(below, r - 5.0)
    };
    size.copysign(q)
}

fn polynomial([a, b, c, d]: [f64; 4], x: f64) -> f64 {
    a + x * (b + x * (c + x * d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, Normal};

    #[test]
    fn the_table_agrees_with_the_distribution_function() {
        for i in -100_000..=100_000 {
            let z = f64::from(i) * 1e-4;
            let error = (cdf(z) - normal::cdf(z)).abs();
            assert!(error < 4e-9, "{z}: {error}");
        }
        assert_eq!(cdf(f64::INFINITY), 1.0);
        assert_eq!(cdf(f64::NEG_INFINITY), 0.0);
        assert!((cdf(FAR.next_down()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn quantiles_agree_with_the_precise_ones() {
        let precise = Normal::standard();
        for i in 1..20_000 {
            let x = f64::from(i) / 20_000.0;
            // Both tails as well.
            for probability in [x, x.powi(8), 1.0 - 1e-3 * x] {
                let expected = precise.inverse_cdf(probability);
                let error = (quantile(probability) - expected).abs();
                assert!(error < 1e-6 * expected.abs().max(1.0), "{probability}: {error}");
            }
        }
        assert_eq!((quantile(0.0), quantile(1.0)), (-FAR, FAR));
    }
}
