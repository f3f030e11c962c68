//! The magnitude rating: dynamic time warping, which compares what belongs together although it comes a little earlier
//! or later.

use super::part;

/// The error at which the rating is zero.
const WORST: f64 = 0.5;
/// How far apart the samples may be that are compared, as a part of the curves' length.
const WINDOW: f64 = 0.1;

/// One without an error, zero for the worst one, and straight between. The error is the sum of the deviations along the
/// path of least squares, as a part of the sum of the reference's magnitudes along it.
pub fn rating(reference: &[f64], model: &[f64]) -> f64 {
    let (mut deviations, mut magnitudes) = (0.0, 0.0);
    for (m, r) in path(reference, model) {
        deviations += (model[m] - reference[r]).abs();
        magnitudes += reference[r].abs();
    }
    ((WORST - part(deviations, magnitudes)) / WORST).max(0.0)
}

/// From where the path comes to a cell. Of equal costs the first one here counts.
const FROM: [(usize, usize); 3] = [(1, 0), (0, 1), (1, 1)];

/// The pairs of samples, of the model and of the reference, from the last ones to the first: the way through all pairs
/// with the least sum of squared deviations that leaves out no sample, never goes back and stays in the window.
fn path(reference: &[f64], model: &[f64]) -> impl Iterator<Item = (usize, usize)> {
    let count = reference.len();
    let most = ((WINDOW * count as f64).ceil() as usize).max(1) - 1;
    let ways = ways(reference, model, most);
    let width = 2 * most + 1;
    let mut next = count.checked_sub(1).map(|last| (last, last));
    std::iter::from_fn(move || {
        let (m, r) = next?;
        let (back_m, back_r) = FROM[usize::from(ways[m * width + r + most - m])];
        next = (m > 0 || r > 0).then(|| (m - back_m, r - back_r));
        Some((m, r))
    })
}

/// For each pair in the window from where its least cost comes, as a number in `FROM`: a row for each sample of the
/// model, in which the pair with the reference's sample of the same number stands in the middle.
fn ways(reference: &[f64], model: &[f64], most: usize) -> Vec<u8> {
    let (count, width) = (reference.len(), 2 * most + 1);
    let mut ways = vec![0; count * width];
    // Infinite costs around the rows: nothing comes from outside of the window.
    let mut above = vec![f64::INFINITY; width + 2];
    let mut row = above.clone();
    for (m, value) in model.iter().enumerate() {
        row.fill(f64::INFINITY);
        let first = m.saturating_sub(most);
        for (place, measured) in reference[first..count.min(m + most + 1)].iter().enumerate() {
            let r = first + place;
            let column = r + most - m;
            // The row above is that of the sample before, one column further left.
            let costs = [above[column + 2], row[column], above[column + 1]];
            let square = (value - measured).powi(2);
            let mut way = 0;
            for other in 1..costs.len() {
                if costs[other] < costs[way] {
                    way = other;
                }
            }
            let before = if m == 0 && r == 0 { 0.0 } else { costs[way] };
            row[column + 1] = before + square;
            ways[m * width + column] = way as u8;
        }
        std::mem::swap(&mut above, &mut row);
    }
    ways
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All ways through a small square, tried one by one.
    fn least(reference: &[f64], model: &[f64], (m, r): (usize, usize), most: usize) -> f64 {
        if m.abs_diff(r) > most {
            return f64::INFINITY;
        }
        let square = (model[m] - reference[r]).powi(2);
        if (m, r) == (0, 0) {
            return square;
        }
        let from = |(dm, dr): &(usize, usize)| {
            let before = m.checked_sub(*dm).zip(r.checked_sub(*dr));
            before.map_or(f64::INFINITY, |before| least(reference, model, before, most))
        };
        square + FROM.iter().map(from).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn no_way_is_shorter() {
        let reference: Vec<f64> = (0..12).map(|k| (0.5 * f64::from(k)).sin()).collect();
        let model: Vec<f64> = (0..12).map(|k| (0.5 * f64::from(k) - 0.5).sin()).collect();
        let squares = path(&reference, &model).map(|(m, r)| (model[m] - reference[r]).powi(2));
        let length: f64 = squares.sum();
        let expected = least(&reference, &model, (11, 11), 1);
        assert!((length - expected).abs() < 1e-12, "{length} {expected}");
        let straight: f64 = model.iter().zip(&reference).map(|(m, r)| (m - r).powi(2)).sum();
        assert!(length < 0.5 * straight);
    }
}
