//! The scatter of a recording's rows, where nobody states it.

use sampling::statistics::moments::{quantile, sorted};

/// Fewer rows tell no scatter.
const FEWEST: usize = 40;

/// The standard deviation of what is independent from row to row, as far as the rows show it; none where they are too few.
///
/// Differences of a high order leave next to nothing of a signal that several rows follow, and of independent numbers their
/// scatter times a known factor; the median makes spikes harmless. Rows that were smoothed share their scatter with their
/// neighbours: then the differences of every second or third row show more of it. They count where orders agree, as they do
/// of scatter, and not of a signal: alone where they show more than chance does, else in the mean with the others, as the
/// largest of several estimates would be too large.
pub fn scatter(values: &[f64]) -> Option<f64> {
    const STRIDES: std::ops::RangeInclusive<usize> = 1..=3;
    const AGREE: f64 = 0.85;
    // No usual smoothing hides more, but a signal near the highest frequency that so many rows show may look the same.
    const MOST: f64 = 3.5;
    // Of white noise chance makes the ratio of two estimates larger by more in one record of 200.
    const CHANCE: f64 = 7.0;
    if values.len() < FEWEST {
        return None;
    }
    let single = by_differences(values, 8, 1);
    let all: Vec<f64> = STRIDES
        .filter_map(|stride| {
            let [low, high] = [6, 8].map(|order| by_differences(values, order, stride));
            (stride == 1 || (high >= AGREE * low && high <= MOST * single)).then_some(high)
        })
        .collect();
    let most = single * (1.0 + CHANCE / (values.len() as f64).sqrt());
    match all.iter().copied().reduce(f64::max) {
        Some(largest) if largest > most => Some(largest),
        _ => Some((all.iter().map(|part| part * part).sum::<f64>() / all.len() as f64).sqrt()),
    }
}

/// The degrees of freedom of the square of the [`scatter`] of so many rows of white noise; none where they are too few. By
/// 3,000 draws each of 60 to 3,000 rows.
pub fn freedom(rows: usize) -> Option<f64> {
    (rows >= FEWEST).then_some(0.24 * rows as f64)
}

/// The scatter by differences of an order, of rows so far apart.
fn by_differences(values: &[f64], order: usize, stride: usize) -> f64 {
    /// The median of the absolute value of a standard normal number.
    const MEDIAN: f64 = 0.674_489_750_196_081_7;
    let mut rows = values.to_vec();
    let mut square = 1.0;
    for step in 1..=order {
        rows = rows.windows(stride + 1).map(|pair| pair[stride] - pair[0]).collect();
        // The squares of the binomial coefficients add up to that of twice the order.
        square *= (order + step) as f64 / step as f64;
    }
    let sizes = sorted(rows.iter().map(|row| row.abs()).collect());
    quantile(&sizes, 0.5) / MEDIAN / square.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::random::{Purpose, Random};

    /// A load's period has 20 rows, with a second harmonic.
    fn signal(row: usize, period: f64) -> f64 {
        let angle = std::f64::consts::TAU * row as f64 / period;
        0.05 * angle.sin() + 0.02 * (2.0 * angle).cos()
    }

    /// By the largest of the estimates these would be 9, 5 and 2 % too large.
    #[test]
    fn independent_rows_have_the_scatter_that_they_have() {
        for (rows, most, draws) in [(275, 0.035, 150), (1000, 0.015, 60), (6000, 0.01, 20)] {
            let squares = (0..draws).map(|seed| {
                let noise = Random::new(seed, Purpose::Search, 0).normals(rows);
                scatter(&noise).unwrap().powi(2)
            });
            let told = (squares.sum::<f64>() / draws as f64).sqrt();
            assert!((told - 1.0).abs() < most, "{rows}: {told}");
        }
    }

    #[test]
    fn noise_on_a_signal_is_told_also_where_it_was_smoothed() {
        let noise = Random::new(3, Purpose::Search, 0).normals(2000);
        let with = |noise: &[f64], period: f64| {
            let rows = noise.iter().enumerate();
            let rows = rows.map(|(row, noise)| signal(row, period) + 0.003 * noise);
            scatter(&rows.collect::<Vec<_>>()).unwrap()
        };
        assert!((with(&noise, 20.0) / 0.003 - 1.0).abs() < 0.12, "{}", with(&noise, 20.0));
        // The mean of two neighbours has a deviation of 1 / sqrt(2), which single differences would put at a tenth of it.
        let smooth: Vec<f64> = noise.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        let told = with(&smooth, 20.0);
        assert!((told / 0.003 * 2.0_f64.sqrt() - 1.0).abs() < 0.15, "{told}");
        // A signal that a few rows hardly follow is not taken for scatter of every third row.
        assert!(with(&noise, 10.0) < 0.006, "{}", with(&noise, 10.0));
        assert!(scatter(&[1.0; 10]).is_none());
    }
}
