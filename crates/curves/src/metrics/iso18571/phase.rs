//! The phase rating, and the shift that it is about.

/// The largest shift, as a part of the curves' length.
const LARGEST: f64 = 0.2;

/// The shift of the model, in samples, that gives the largest correlation with the reference on their overlap; positive
/// where the model is late. Of equal correlations the smallest shift counts, and of a pair of these the late one.
pub fn shift(reference: &[f64], model: &[f64]) -> isize {
    let sums = [RunningSums::of(reference), RunningSums::of(model)];
    let correlate = |shift: isize| {
        let (reference_part, model_part) = overlap(reference, model, shift);
        let begins = [shift.min(0).unsigned_abs(), shift.max(0).unsigned_abs()];
        let count = reference_part.len();
        let mean = |which: usize| sums[which].mean(begins[which], count);
        correlation([reference_part, model_part], [mean(0), mean(1)])
    };
    let most = (reference.len() as f64 * LARGEST).floor() as isize;
    let (mut best, mut largest) = (0, correlate(0));
    for distance in 1..=most {
        for shift in [distance, -distance] {
            let correlation = correlate(shift);
            if correlation > largest {
                (best, largest) = (shift, correlation);
            }
        }
    }
    best
}

/// The samples that lie on each other when the model is moved back by a shift.
pub fn overlap<'a>(reference: &'a [f64], model: &'a [f64], shift: isize) -> (&'a [f64], &'a [f64]) {
    let by = shift.unsigned_abs();
    let rest = reference.len() - by;
    if shift >= 0 { (&reference[..rest], &model[by..]) } else { (&reference[by..], &model[..rest]) }
}

/// One without a shift, zero for the largest one, and straight between.
pub fn rating(shift: isize, samples: usize) -> f64 {
    let most = samples as f64 * LARGEST;
    ((most - shift.unsigned_abs() as f64) / most).max(0.0)
}

/// Pearson's correlation about given means; not a number where a curve is constant.
fn correlation([a, b]: [&[f64]; 2], [mean_a, mean_b]: [f64; 2]) -> f64 {
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - mean_a, y - mean_b);
        aa += x * x;
        bb += y * y;
        ab += x * y;
    }
    (ab / (aa.sqrt() * bb.sqrt())).clamp(-1.0, 1.0)
}

/// Running sums of a curve about its first value: means of its parts.
struct RunningSums {
    first: f64,
    sums: Vec<f64>,
}

impl RunningSums {
    fn of(values: &[f64]) -> Self {
        let first = values.first().copied().unwrap_or(0.0);
        let mut sum = 0.0;
        let running = values.iter().map(|value| {
            sum += value - first;
            sum
        });
        Self { first, sums: std::iter::once(0.0).chain(running).collect() }
    }

    fn mean(&self, begin: usize, count: usize) -> f64 {
        self.first + (self.sums[begin + count] - self.sums[begin]) / count as f64
    }
}
