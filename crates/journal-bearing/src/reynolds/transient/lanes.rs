//! Sums and extremes over cells. Eight partial results run side by side, which the compiler keeps in vector registers; the
//! order of summation is fixed, so that results are the same on every machine.

/// Cells that are processed side by side. A column of cells is padded to a multiple.
pub const LANES: usize = 8;

/// Adds the partial sums.
fn total(sum: [f64; LANES]) -> f64 {
    ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]))
}

/// The sum.
pub fn sum(a: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    for a in a.as_chunks::<LANES>().0 {
        for q in 0..LANES {
            sum[q] += a[q];
        }
    }
    total(sum)
}

/// The sum of `term(0)` to `term(count - 1)`.
#[inline(always)]
pub fn sum_of(count: usize, term: impl Fn(usize) -> f64) -> f64 {
    let mut sum = [0.0; LANES];
    let whole = count - count % LANES;
    let mut start = 0;
    while start < whole {
        for (q, sum) in sum.iter_mut().enumerate() {
            *sum += term(start + q);
        }
        start += LANES;
    }
    for k in whole..count {
        sum[k - whole] += term(k);
    }
    total(sum)
}

/// The sum of absolute values.
pub fn sum_of_sizes(a: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    for a in a.as_chunks::<LANES>().0 {
        for q in 0..LANES {
            sum[q] += a[q].abs();
        }
    }
    total(sum)
}

/// The scalar product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    for (a, b) in a
        .as_chunks::<LANES>()
        .0
        .iter()
        .zip(b.as_chunks::<LANES>().0)
    {
        for q in 0..LANES {
            sum[q] += a[q] * b[q];
        }
    }
    total(sum)
}

/// The weighted sum of absolute values.
pub fn dot_of_sizes(a: &[f64], weight: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    let chunks = a.as_chunks::<LANES>().0.iter();
    for (a, weight) in chunks.zip(weight.as_chunks::<LANES>().0) {
        for q in 0..LANES {
            sum[q] += a[q].abs() * weight[q];
        }
    }
    total(sum)
}

/// The sum of the products of three arrays.
pub fn dot3(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    let chunks = a
        .as_chunks::<LANES>()
        .0
        .iter()
        .zip(b.as_chunks::<LANES>().0);
    for ((a, b), c) in chunks.zip(c.as_chunks::<LANES>().0) {
        for q in 0..LANES {
            sum[q] += a[q] * b[q] * c[q];
        }
    }
    total(sum)
}

/// The smallest value; infinity of an empty array.
pub fn smallest(a: &[f64]) -> f64 {
    let mut least = [f64::INFINITY; LANES];
    for a in a.as_chunks::<LANES>().0 {
        for q in 0..LANES {
            least[q] = if a[q] < least[q] { a[q] } else { least[q] };
        }
    }
    least.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The largest value; minus infinity of an empty array.
pub fn largest(a: &[f64]) -> f64 {
    let mut most = [f64::NEG_INFINITY; LANES];
    for a in a.as_chunks::<LANES>().0 {
        for q in 0..LANES {
            most[q] = if a[q] > most[q] { a[q] } else { most[q] };
        }
    }
    most.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}
