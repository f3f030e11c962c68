//! Functions as plain arithmetic, which compilers do for several numbers at once.

use std::f64::consts::{LN_2, TAU};

/// Added and taken away, it leaves the nearest whole number, which the sum's last bits hold.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

/// Terms of a series in pairs: each is that before it times the factor over its number, or over those of the sine.
const fn terms<const PAIRS: usize>(mut term: f64, factor: f64, of_sine: bool) -> [[f64; 2]; PAIRS] {
    let mut terms = [[0.0; 2]; PAIRS];
    let mut k = 0;
    while k < 2 * PAIRS {
        terms[k / 2][k % 2] = term;
        k += 1;
        term *= factor / (if of_sine { 2 * k * (2 * k + 1) } else { k }) as f64;
    }
    terms
}

/// Of sin(2 pi x) / x in squares of x, and of 2 to the power of x.
const SINE: [[f64; 2]; 5] = terms(TAU, -TAU * TAU, true);
const POWER: [[f64; 2]; 6] = terms(1.0, LN_2, false);

/// The sum of a series, of which even and odd terms do not wait for each other.
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

/// 2 to the power of a number between -1000 and 1000, to 1e-14 of it: nuggets, which are 1e-9 or more, hide that.
pub fn power_of_2(x: f64) -> f64 {
    let shifted = x + TO_WHOLE;
    // The whole number becomes an exponent's bits.
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
