//! Element-wise arithmetic over arrays of cells.
//!
//! Each sweep writes to a single array. The compiler therefore knows that the written array overlaps none of those read,
//! and vectorises the loop.

/// Computes each value of an array from those at the same place of others.
#[inline(always)]
pub fn fill<const N: usize>(values: &mut [f64], of: [&[f64]; N], formula: impl Fn([f64; N]) -> f64) {
    change(values, of, |_, of| formula(of));
}

/// Computes each value anew, from itself and those at the same place of other arrays.
#[inline(always)]
pub fn change<const N: usize>(values: &mut [f64], of: [&[f64]; N], formula: impl Fn(f64, [f64; N]) -> f64) {
    let n = values.len();
    let of = of.map(|of| &of[..n]);
    for k in 0..n {
        values[k] = formula(values[k], of.map(|of| of[k]));
    }
}

/// Adds what leaves through one edge less what enters through the other: `flux += through[1] - through[0]`.
pub fn add_difference(flux: &mut [f64], through: [&[f64]; 2]) {
    change(flux, through, |flux, [enters, leaves]| flux + (leaves - enters));
}
