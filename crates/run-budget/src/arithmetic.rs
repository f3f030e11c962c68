//! Functions as plain arithmetic, which compilers do for several numbers at once.

use std::f64::consts::{LN_2, TAU};

/// 1.5 * 2^52: numbers near it are spaced by 1, so adding and subtracting it rounds to the nearest whole number.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

/// The terms of sin(tau x) / x in squares of x, in pairs: term k is the one before times -tau^2 / (2k (2k+1)).
const SINE: [[f64; 2]; 5] = {
    let (mut terms, mut term, mut k) = ([[0.0; 2]; 5], TAU, 0);
    while k < 10 {
        terms[k / 2][k % 2] = term;
        k += 1;
        term *= -TAU * TAU / (2 * k * (2 * k + 1)) as f64;
    }
    terms
};

/// The terms of 2 to the power of x, in pairs: term k is the one before times ln 2 / k.
const POWER: [[f64; 2]; 6] = {
    let (mut terms, mut term, mut k) = ([[0.0; 2]; 6], 1.0, 0);
    while k < 12 {
        terms[k / 2][k % 2] = term;
        k += 1;
        term *= LN_2 / k as f64;
    }
    terms
};

/// The sum of a series in `x`; even and odd terms are summed apart, so that the processor does both at once.
fn series(terms: &[[f64; 2]], x: f64) -> f64 {
    let square = x * x;
    let next = |[even, odd]: [f64; 2], [a, b]: &[f64; 2]| [even * square + a, odd * square + b];
    let [even, odd] = terms.iter().rev().fold([0.0; 2], next);
    even + odd * x
}

/// The cosine of an angle in turns.
pub fn cosine(turns: f64) -> f64 {
    let part = 0.25 - (turns - ((turns + TO_WHOLE) - TO_WHOLE)).abs();
    part * series(&SINE, part * part)
}

/// 2 to the power of a number between -1000 and 1000, to 1e-14 of it.
pub fn power_of_2(x: f64) -> f64 {
    debug_assert!(x.abs() <= 1000.0, "2^{x}");
    let shifted = x + TO_WHOLE;
    // The sum's last bits are the whole number; moved into the exponent, it is that power of 2.
    let whole = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1_f64.to_bits()));
    whole * series(&POWER, x - (shifted - TO_WHOLE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosines_are_those_of_the_library() {
        for k in -100_000..100_000 {
            let turns = f64::from(k) * 1.7e-4;
            assert!((cosine(turns) - (TAU * turns).cos()).abs() < 3e-14, "{turns}");
        }
    }

    #[test]
    fn powers_are_those_of_the_library() {
        for x in (-100_000..=100_000).map(|k| f64::from(k) * 1e-2).chain([-0.0, 1e-300, 0.5, -0.5]) {
            assert!((power_of_2(x) / x.exp2() - 1.0).abs() < 1e-14, "{x}");
        }
    }
}
