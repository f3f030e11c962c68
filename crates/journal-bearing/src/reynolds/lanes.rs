//! Sums and extremes over cells. Eight partial results run side by side, which the compiler keeps in vector registers; the
//! order of summation is fixed, so that results are the same on every machine.

/// Cells that are processed side by side. A column of cells is padded to a multiple.
pub const LANES: usize = 8;

/// The sum of a term over the values at the same place of arrays, which are as long as the first one.
#[inline(always)]
pub fn sum_of<const N: usize>(of: [&[f64]; N], term: impl Fn([f64; N]) -> f64) -> f64 {
    let n = of[0].len();
    let of = of.map(|of| of[..n].as_chunks::<LANES>());
    let mut sum = [0.0; LANES];
    for chunk in 0..n / LANES {
        let lanes = of.map(|(chunks, _)| &chunks[chunk]);
        for q in 0..LANES {
            sum[q] += term(lanes.map(|lane| lane[q]));
        }
    }
    for q in 0..n % LANES {
        sum[q] += term(of.map(|(_, rest)| rest[q]));
    }
    ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]))
}

/// The scalar product.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    sum_of([a, b], |[a, b]| a * b)
}

/// The smallest value of an array of whole lanes; infinity of an empty array.
pub fn smallest(a: &[f64]) -> f64 {
    let least = extremes(a, f64::INFINITY, |a, least| a < least);
    least.into_iter().fold(f64::INFINITY, f64::min)
}

/// The largest value of an array of whole lanes; minus infinity of an empty array.
pub fn largest(a: &[f64]) -> f64 {
    let most = extremes(a, f64::NEG_INFINITY, |a, most| a > most);
    most.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// The value of each lane that goes beyond `start` and all others of the lane, in an array of whole lanes.
#[inline(always)]
fn extremes(a: &[f64], start: f64, beyond: impl Fn(f64, f64) -> bool) -> [f64; LANES] {
    debug_assert!(a.len().is_multiple_of(LANES), "{} values fill no whole lanes", a.len());
    let mut most = [start; LANES];
    for a in a.as_chunks::<LANES>().0 {
        for q in 0..LANES {
            most[q] = if beyond(a[q], most[q]) { a[q] } else { most[q] };
        }
    }
    most
}
