//! Elementary functions as plain arithmetic, which compilers do for several numbers at once.

use std::f64::consts::{LOG2_E, TAU};

/// Added and taken away, it leaves the nearest whole number, which the sum has in its lowest bits.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;
/// The logarithm of 2: the first part times a whole number below 2^21 is exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// Terms of the exponential's series.
const EXPONENTIAL: [f64; 14] = {
    let mut terms = [1.0; 14];
    let mut k = 1;
    while k < terms.len() {
        terms[k] = terms[k - 1] / k as f64;
        k += 1;
    }
    terms
};

/// Terms of the series of sin(2 pi x) / x in squares of x.
const SINE: [f64; 10] = {
    let mut terms = [TAU; 10];
    let mut k = 1;
    while k < terms.len() {
        terms[k] = -terms[k - 1] * TAU * TAU / (2 * k * (2 * k + 1)) as f64;
        k += 1;
    }
    terms
};

/// exp(-x) of a number that is not negative; that of 700 beyond 700.
#[inline(always)]
pub fn exp_minus(x: f64) -> f64 {
    let x = if x > 700.0 { 700.0 } else { x };
    let shifted = TO_WHOLE - x * LOG2_E;
    let whole = shifted - TO_WHOLE;
    let rest = -x - whole * LN_2[0] - whole * LN_2[1];
    let square = rest * rest;
    let half = |odd: usize| (0..7).rev().fold(0.0, |sum, k| sum * square + EXPONENTIAL[2 * k + odd]);
    // The whole number belongs to the exponent.
    let bits = (half(0) + rest * half(1)).to_bits();
    f64::from_bits(bits.wrapping_add(shifted.to_bits() << 52))
}

/// The cosine of an angle in turns.
#[inline(always)]
pub fn cosine(turns: f64) -> f64 {
    let part = 0.25 - (turns - ((turns + TO_WHOLE) - TO_WHOLE)).abs();
    let square = part * part;
    part * SINE.iter().rev().fold(0.0, |sum, term| sum * square + term)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_the_library() {
        for k in 0..200_000 {
            let x = f64::from(k) * 3.3e-3;
            assert!((exp_minus(x) / (-x).exp() - 1.0).abs() < 1e-15, "{x}");
            let turns = f64::from(k - 100_000) * 1.7e-4;
            assert!((cosine(turns) - (TAU * turns).cos()).abs() < 3e-14, "{turns}");
        }
        assert!(exp_minus(1e9) < 1e-300 && exp_minus(f64::NAN).is_nan() && cosine(f64::NAN).is_nan());
    }
}
