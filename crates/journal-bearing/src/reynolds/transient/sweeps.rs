//! Element-wise arithmetic over arrays of cells.
//!
//! Each sweep writes to a single array. The compiler therefore knows that the written array overlaps none of those read,
//! and vectorises the loop.

/// `product = a b`.
pub fn multiply(product: &mut [f64], a: &[f64], b: &[f64]) {
    let n = product.len();
    let (a, b) = (&a[..n], &b[..n]);
    for k in 0..n {
        product[k] = a[k] * b[k];
    }
}

/// `values *= by`.
pub fn scale(values: &mut [f64], by: &[f64]) {
    for (value, by) in values.iter_mut().zip(by) {
        *value *= by;
    }
}

/// `values += more`.
pub fn add(values: &mut [f64], more: &[f64]) {
    for (value, more) in values.iter_mut().zip(more) {
        *value += more;
    }
}

/// Adds what leaves through one edge less what enters through the other: `flux += through[1] - through[0]`.
pub fn add_difference(flux: &mut [f64], through: [&[f64]; 2]) {
    let n = flux.len();
    let through = through.map(|t| &t[..n]);
    for k in 0..n {
        flux[k] += through[1][k] - through[0][k];
    }
}
