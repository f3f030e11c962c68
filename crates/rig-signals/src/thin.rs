//! A recorded input as a polyline with few corners: what is left out is noise.

use super::scatter::scatter;

/// A polyline through a signal.
#[derive(Debug)]
pub struct Polyline {
    /// Times of the corners, s.
    pub time: Vec<f64>,
    /// Values at the corners.
    pub values: Vec<f64>,
    /// What was allowed to be left out beside the noise.
    pub tolerance: f64,
    /// The root mean square of what was left out.
    pub left: f64,
    /// The standard deviation of a sample's noise, where the samples show it.
    pub noise: Option<f64>,
}

/// Left out of a signal's range in any case.
const LEAST: f64 = 1e-4;
/// Of white noise the running sum stays within so many standard deviations of its end: chance leaves it once in 1,500 pieces.
const RUNS: f64 = 2.0;
/// No sample of normal noise is farther off in millions.
const FAR: f64 = 5.0;

/// Thins a signal, finite samples at growing times. The corners are those of the least squares; a piece is halved as long as
/// its samples differ from it by more than their noise and the tolerance, which is the noise's standard deviation where the
/// user states none. A sum of the differences that runs away counts, too: the integral of the input, such as an angle, stays.
pub fn polyline(time: &[f64], values: &[f64], tolerance: Option<f64>) -> Polyline {
    let noise = scatter(values);
    let deviation = noise.unwrap_or(0.0);
    // A short excursion is none of the usual range.
    let ordered = sampling::statistics::moments::sorted(values.to_vec());
    let place = |part: f64| (ordered.len().saturating_sub(1) as f64 * part).round() as usize;
    let [low, high] = [0.01, 0.99].map(|part| ordered.get(place(part)).copied().unwrap_or(0.0));
    let least = LEAST * (high - low) + 1e-9 * high.abs().max(low.abs());
    let stated = tolerance.unwrap_or(0.0).max(least);
    let allowed = tolerance.unwrap_or(deviation).max(least);
    let is_good = |left: &[f64]| {
        let count = left.len() as f64;
        let spread = deviation.powi(2) * (1.0 + 3.0 * (2.0 / count).sqrt()) + allowed.powi(2);
        let far = left.iter().any(|off| off.abs() > FAR * deviation + allowed);
        let sums = left.iter().scan(0.0, |sum: &mut f64, off| {
            *sum += off;
            Some(sum.abs())
        });
        let runs = sums.fold(0.0, f64::max) > RUNS * deviation * count.sqrt() + stated * count / 8.0;
        !far && !runs && left.iter().map(|off| off * off).sum::<f64>() <= spread * count
    };
    let last = values.len().saturating_sub(1);
    let mut knots = if last == 0 { vec![0] } else { vec![0, last] };
    loop {
        let corners = fit(time, values, &knots);
        let left = residuals(time, values, &knots, &corners);
        let halves: Vec<usize> = knots
            .windows(2)
            .map(|pair| [pair[0], pair[1]])
            .filter(|[from, to]| to - from > 1 && !is_good(&left[*from..=*to]))
            .map(|[from, to]| usize::midpoint(from, to))
            .collect();
        if halves.is_empty() {
            let squares = left.iter().map(|off| off * off).sum::<f64>();
            return Polyline {
                time: knots.iter().map(|&knot| time[knot]).collect(),
                values: corners,
                tolerance: allowed,
                left: (squares / left.len().max(1) as f64).sqrt(),
                noise,
            };
        }
        knots.extend(halves);
        knots.sort_unstable();
    }
}

/// Where a sample stands between two corners, as a part of the way.
fn part(time: &[f64], [from, to]: [usize; 2], k: usize) -> f64 {
    (time[k] - time[from]) / (time[to] - time[from])
}

/// The values at the corners by least squares: a tridiagonal system, solved by elimination.
fn fit(time: &[f64], values: &[f64], knots: &[usize]) -> Vec<f64> {
    let count = knots.len();
    let (mut diagonal, mut beside, mut right) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    for (piece, pair) in knots.windows(2).enumerate() {
        let ends = [pair[0], pair[1]];
        // The last sample of a piece is the first one of the next.
        let end = ends[1] + usize::from(piece + 2 == count);
        for (k, value) in values.iter().enumerate().take(end).skip(ends[0]) {
            let b = part(time, ends, k);
            let a = 1.0 - b;
            diagonal[piece] += a * a;
            diagonal[piece + 1] += b * b;
            beside[piece] += a * b;
            right[piece] += a * value;
            right[piece + 1] += b * value;
        }
    }
    if count < 2 {
        return knots.iter().map(|&knot| values[knot]).collect();
    }
    for k in 1..count {
        let ratio = beside[k - 1] / diagonal[k - 1];
        diagonal[k] -= ratio * beside[k - 1];
        right[k] -= ratio * right[k - 1];
    }
    for k in (0..count).rev() {
        let next = if k + 1 < count { beside[k] * right[k + 1] } else { 0.0 };
        right[k] = (right[k] - next) / diagonal[k];
    }
    right
}

fn residuals(time: &[f64], values: &[f64], knots: &[usize], corners: &[f64]) -> Vec<f64> {
    let mut left = vec![0.0; values.len()];
    for (pair, ends) in corners.windows(2).zip(knots.windows(2)) {
        let ends = [ends[0], ends[1]];
        for k in ends[0]..=ends[1] {
            let b = part(time, ends, k);
            left[k] = values[k] - (1.0 - b) * pair[0] - b * pair[1];
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::random::{Purpose, Random};

    const RATE: f64 = 1000.0;

    fn thinned(signal: impl Fn(f64) -> f64, noise: f64) -> (Polyline, f64) {
        let normals = Random::new(5, Purpose::Search, 0).normals(6000);
        let time: Vec<f64> = (0..6000).map(|k| f64::from(k) / RATE).collect();
        let values: Vec<f64> = time.iter().zip(&normals).map(|(t, n)| signal(*t) + noise * n).collect();
        let line = polyline(&time, &values, None);
        // The largest difference of the integrals, in units of the signal times seconds.
        let knots: Vec<usize> = line.time.iter().map(|t| (t * RATE).round() as usize).collect();
        let truth: Vec<f64> = time.iter().map(|t| signal(*t)).collect();
        let sums = residuals(&time, &truth, &knots, &line.values).into_iter().scan(0.0, |sum, off| {
            *sum += off / RATE;
            Some(f64::abs(*sum))
        });
        let sum = sums.fold(0.0, f64::max);
        (line, sum)
    }

    #[test]
    fn noise_is_left_out_and_the_signal_stays() {
        for (name, signal, noise, most) in [
            ("line", (|t| 300.0 - 0.5 * t) as fn(f64) -> f64, 2.0, 4),
            ("exact line", |t| 300.0 - 0.5 * t, 0.0, 2),
            ("constant", |_| 300.0, 0.0, 2),
            ("step", |t| if t < 2.3 { 300.0 } else { 450.0 }, 2.0, 80),
            ("slow wave", |t| 300.0 + 20.0 * t.sin(), 2.0, 30),
        ] {
            let (line, sum) = thinned(signal, noise);
            assert!(line.time.len() <= most, "{name}: {} corners", line.time.len());
            assert!(line.left <= 1.03 * noise + line.tolerance.min(0.1), "{name}: {line:?}");
            // Three deviations of what the noise itself adds up to.
            let drift = 3.0 * noise * 6000_f64.sqrt() / RATE + 1e-9;
            assert!(sum < drift, "{name}: the integral differs by {sum}");
        }
        // What is far above the noise is no noise, however quick.
        let (line, _) = thinned(|t| 300.0 + 20.0 * (300.0 * t).sin(), 2.0);
        assert!(line.left < 3.0 && line.time.len() > 600, "{}", line.time.len());
    }

    #[test]
    fn a_stated_tolerance_is_kept() {
        let time: Vec<f64> = (0..500).map(f64::from).collect();
        let values: Vec<f64> = time.iter().map(|t| 10.0 * (t / 80.0).sin()).collect();
        for tolerance in [0.1, 1.0] {
            let line = polyline(&time, &values, Some(tolerance));
            let knots: Vec<usize> = line.time.iter().map(|t| *t as usize).collect();
            let left = residuals(&time, &values, &knots, &line.values);
            assert!(left.iter().all(|off| off.abs() <= tolerance + 5.0 * line.noise.unwrap()));
            assert!(line.time.len() < 40, "{}", line.time.len());
        }
        let one = polyline(&[2.0], &[3.0], None);
        assert_eq!((one.time, one.values), (vec![2.0], vec![3.0]));
    }
}
