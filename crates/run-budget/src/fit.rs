//! Which processes fit the runs: maxima of the posterior of length scales and nugget, and a sample around them.

use crate::kernel::{FARTHEST, LEAST_NUGGET, Smoothness};
use crate::process::{Data, Process};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use sampling::random::Random;

/// Steps of a search at most.
const STEPS: usize = 60;
/// A kind of process whose maximum is so far below the best one's has no weight.
const NEGLIGIBLE: f64 = 6.0;
/// Candidates for each member of the sample.
const CANDIDATES: usize = 4;

/// Priors of the logarithms: centre and deviation. Points have deviations of 1 in each coordinate.
fn priors(data: &Data) -> Vec<[f64; 2]> {
    let mut priors = vec![[2.5_f64.ln(), 1.2]; data.points.nrows()];
    priors.push([0.5_f64.ln(), 1.5]);
    priors.push([1e-6_f64.ln(), 5.0]);
    priors
}

fn bounds(data: &Data) -> Vec<[f64; 2]> {
    // No run is farther from the centre than half of what is as good as infinity.
    let least = |farthest: f64| [(farthest * 5_f64.sqrt() / (0.5 * FARTHEST)).max(0.02).ln(), 1000_f64.ln()];
    let mut bounds: Vec<[f64; 2]> = data.points.row_iter().map(|row| least(row.amax())).collect();
    bounds.push([1e-3_f64.ln(), 1e3_f64.ln()]);
    bounds.push([LEAST_NUGGET.ln(), 100_f64.ln()]);
    bounds
}

/// The logarithm of the posterior, and its gradient.
fn posterior(data: &Data, smoothness: Smoothness, at: &[f64], sloped: bool) -> Option<(f64, DVector<f64>)> {
    let (mut value, mut gradient) = data.likelihood(smoothness, at, sloped)?;
    for (k, (u, [centre, deviation])) in at.iter().zip(priors(data)).enumerate() {
        let z = (u - centre) / deviation;
        value -= 0.5 * z * z;
        if let Some(slope) = gradient.get_mut(k) {
            *slope -= z / deviation;
        }
    }
    value.is_finite().then(|| (value, DVector::from_vec(gradient)))
}

/// A maximum by the method of Broyden, Fletcher, Goldfarb and Shanno, within bounds. Covariances that were found before save steps.
fn climb(
    data: &Data,
    smoothness: Smoothness,
    start: &[f64],
    known: Option<DMatrix<f64>>,
) -> Option<(f64, DVector<f64>)> {
    let bounds = bounds(data);
    let within = |x: DVector<f64>| {
        let clamped = x.iter().zip(&bounds).map(|(v, [low, high])| v.clamp(*low, *high));
        DVector::from_iterator(bounds.len(), clamped)
    };
    let mut x = within(DVector::from_column_slice(start));
    let (mut value, mut slope) = posterior(data, smoothness, x.as_slice(), true)?;
    let m = x.len();
    let mut metric = known.unwrap_or_else(|| DMatrix::identity(m, m) / slope.norm().max(1.0));
    for _ in 0..STEPS {
        let mut direction = &metric * &slope;
        if direction.dot(&slope) <= 0.0 {
            metric = DMatrix::identity(m, m) / slope.norm().max(1.0);
            direction = &metric * &slope;
        }
        // No step beyond a factor of 20 in a length scale: the model is another there.
        let longest = direction.amax();
        if longest > 3.0 {
            direction *= 3.0 / longest;
        }
        let mut length = 1.0;
        let next = loop {
            let to = within(&x + &direction * length);
            let found = posterior(data, smoothness, to.as_slice(), true);
            if let Some((v, s)) = found.filter(|(v, _)| *v >= value + 1e-4 * slope.dot(&(&to - &x))) {
                break Some((to, v, s));
            }
            length *= 0.4;
            if length < 1e-4 {
                break None;
            }
        };
        let Some((to, v, s)) = next else { break };
        let (step, change) = (&to - &x, &slope - &s);
        let gained = v - value;
        (x, value, slope) = (to, v, s);
        let curvature = step.dot(&change);
        if curvature > 1e-10 {
            let rho = 1.0 / curvature;
            let left = DMatrix::identity(m, m) - &step * change.transpose() * rho;
            metric = &left * metric * left.transpose() + &step * step.transpose() * rho;
        }
        if gained < 1e-3 {
            break;
        }
    }
    Some((value, x))
}

/// A maximum, and the normal approximation around it.
#[derive(Clone, Debug)]
pub struct Summit {
    smoothness: Smoothness,
    value: f64,
    at: DVector<f64>,
    /// Standard normal numbers to deviations from the maximum.
    spread: DMatrix<f64>,
    /// The logarithm of the weight of this kind.
    evidence: f64,
}

impl Summit {
    fn new(data: &Data, smoothness: Smoothness, value: f64, at: DVector<f64>) -> Option<Self> {
        let m = at.len();
        let (_, base) = posterior(data, smoothness, at.as_slice(), true)?;
        let mut curvature = DMatrix::zeros(m, m);
        let h = 0.05;
        for k in 0..m {
            let mut moved = at.clone();
            // The nugget's derivative is none below its bound.
            moved[k] += h;
            let (_, slope) = posterior(data, smoothness, moved.as_slice(), true)?;
            curvature.set_column(k, &((&base - slope) / h));
        }
        let eigen = SymmetricEigen::new((&curvature + curvature.transpose()) / 2.0);
        // Nothing is known less well than by half of its prior's precision.
        let least = 0.5 / 25.0;
        let values = eigen.eigenvalues.map(|v| v.max(least));
        let spread = &eigen.eigenvectors * DMatrix::from_diagonal(&values.map(|v| v.powf(-0.5)));
        let evidence = value - 0.5 * values.iter().map(|v| v.ln()).sum::<f64>();
        Some(Self { smoothness, value, at, spread, evidence })
    }
}

/// Members of the posterior of smoothness, length scales and nugget, of which the first is the best maximum; and the maxima.
/// `earlier` are those of a fit to fewer runs, from which the search starts.
pub fn members(data: &Data, count: usize, earlier: &[Summit], random: &mut Random) -> (Vec<Process>, Vec<Summit>) {
    let centre: Vec<f64> = priors(data).iter().map(|p| p[0]).collect();
    let summit = |smoothness: Smoothness| {
        let found = match earlier.iter().find(|summit| summit.smoothness == smoothness) {
            Some(before) => {
                let metric = &before.spread * before.spread.transpose();
                climb(data, smoothness, before.at.as_slice(), Some(metric))
            }
            None => {
                let mut rough: Vec<f64> = centre.iter().map(|c| c - 1.2).collect();
                rough[data.points.nrows() + 1] = 0.01_f64.ln();
                let found = [&centre, &rough].into_iter().filter_map(|start| climb(data, smoothness, start, None));
                found.max_by(|a, b| a.0.total_cmp(&b.0))
            }
        };
        found.and_then(|(value, at)| Summit::new(data, smoothness, value, at))
    };
    let summits: Vec<Summit> = Smoothness::ALL.into_iter().filter_map(summit).collect();
    let best = summits.iter().map(|s| s.value).fold(f64::NEG_INFINITY, f64::max);
    let kept = || summits.iter().filter(|s| s.value > best - NEGLIGIBLE);
    let Some(top) = kept().max_by(|a, b| a.evidence.total_cmp(&b.evidence)) else {
        return (Vec::new(), Vec::new());
    };
    let mut members: Vec<Process> =
        Process::new(data, top.smoothness, top.at.as_slice().to_vec()).into_iter().collect();
    let bounds = bounds(data);
    let kept: Vec<&Summit> = kept().collect();
    let weights: Vec<f64> = kept.iter().map(|s| (s.evidence - top.evidence).exp()).collect();
    let mut candidates = Vec::new();
    for _ in 0..CANDIDATES * count {
        let summit = kept[random.pick(&weights)];
        let z = DVector::from_vec(random.normals(summit.at.len()));
        let at = &summit.at + &summit.spread * &z;
        let clamped = at.iter().zip(&bounds).map(|(v, [low, high])| v.clamp(*low, *high));
        let at: Vec<f64> = clamped.collect();
        if let Some((value, _)) = posterior(data, summit.smoothness, &at, false) {
            // The posterior over the normal approximation; cut, so that no member stands for all.
            let weight = (value - summit.value + 0.5 * z.norm_squared()).clamp(-30.0, 2.0).exp();
            candidates.push((weight, summit.smoothness, at));
        }
    }
    // Systematic resampling: each candidate as often as its weight says, to within one.
    let sum: f64 = candidates.iter().map(|c| c.0).sum();
    let (mut passed, mut place) = (0.0, random.unit());
    for (weight, smoothness, at) in candidates {
        passed += weight / sum * (count - 1) as f64;
        while place < passed {
            members.extend(Process::new(data, smoothness, at.clone()));
            place += 1.0;
        }
    }
    (members, summits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::random::Purpose;

    fn data() -> Data {
        let mut random = Random::new(3, Purpose::Unstated, 0);
        let points = DMatrix::from_fn(2, 25, |_, _| random.normal());
        let values = DVector::from_fn(25, |i, _| (points[(0, i)] * 1.3).sin() + 0.3 * points[(1, i)].powi(2));
        Data::new(points, values)
    }

    /// Two parameters are the same one, in two narrow groups, and the output is an exact product.
    #[test]
    fn parameters_that_move_together_have_a_process() {
        let mut random = Random::new(8, Purpose::Unstated, 0);
        let rows: Vec<[f64; 2]> =
            (0..64).map(|i| [(i % 2) as f64 * 2.0 - 1.0 + 0.05 * random.normal(), random.normal()]).collect();
        let points = DMatrix::from_fn(3, 64, |k, i| if k == 1 { rows[i][1] } else { rows[i][0] });
        let values = DVector::from_fn(64, |i, _| (rows[i][0] + 1.7).powi(2) * (rows[i][1] + 1.7));
        let data = Data::new(points, values);
        assert!(!members(&data, 8, &[], &mut random).0.is_empty());
    }

    #[test]
    fn gradients_are_those_of_differences() {
        let data = data();
        for smoothness in Smoothness::ALL {
            let at = [0.3, 0.9, 0.4, -4.0];
            let (_, slope) = posterior(&data, smoothness, &at, true).unwrap();
            for k in 0..4 {
                let value = |h: f64| {
                    let mut moved = at;
                    moved[k] += h;
                    posterior(&data, smoothness, &moved, false).unwrap().0
                };
                let difference = (value(1e-5) - value(-1e-5)) / 2e-5;
                assert!((difference - slope[k]).abs() < 1e-4 * (1.0 + slope[k].abs()), "{difference} {}", slope[k]);
            }
        }
    }

    /// Leaving out by the formula is what leaving out the run gives.
    #[test]
    fn a_run_left_out_is_predicted_as_without_it() {
        let data = data();
        let unknowns = vec![0.3, 0.9, 0.4, -6.0];
        let all = Process::new(&data, Smoothness::Twice, unknowns.clone()).unwrap();
        let rest = Data::new(data.points.clone().remove_column(4), data.values.clone().remove_row(4));
        let without = Process::new(&rest, Smoothness::Twice, unknowns).unwrap();
        let [mean, deviation] = without.predict(&data.points.columns(4, 1).into_owned())[0];
        let [error, stated] = all.left_out()[4];
        assert!((data.values[4] - mean - error).abs() < 1e-9);
        let with_error = (deviation.powi(2) / without.variance + without.nugget()).sqrt();
        assert!((with_error - stated / all.variance.sqrt()).abs() < 1e-7);
    }

    /// Points that share coordinates are predicted as each of them alone.
    #[test]
    fn points_of_a_grid_share_factors() {
        let data = data();
        for smoothness in Smoothness::ALL {
            let process = Process::new(&data, smoothness, vec![0.0, 0.3, 0.5, -9.0]).unwrap();
            let grid = DMatrix::from_fn(2, 12, |k, i| if k == 0 { (i % 3) as f64 } else { (i / 3) as f64 - 1.5 });
            for (i, told) in process.means(&grid).iter().enumerate() {
                let alone = process.means(&grid.columns(i, 1).into_owned())[0];
                assert!((told - alone).abs() < 1e-12, "{told} {alone}");
            }
        }
    }

    /// Draws have the mean and the covariance that the closed form gives, and pass through the runs.
    #[test]
    fn draws_have_the_moments_of_the_closed_form() {
        let data = data();
        let process = Process::new(&data, Smoothness::Twice, vec![0.0, 0.3, 0.5, -9.0]).unwrap();
        let mut random = Random::new(5, Purpose::Unstated, 0);
        let points = DMatrix::from_column_slice(2, 3, &[2.2, -1.9, -2.5, 2.0, 0.1, 0.2]);
        let (mut sum, mut square) = ([0.0; 3], [0.0; 3]);
        let (blocks, each) = (60, 60);
        for _ in 0..blocks {
            let values = process.draws(&data, each, 1.0, &mut random).at(&points);
            for i in 0..3 {
                sum[i] += values.row(i).sum();
                square[i] += values.row(i).norm_squared();
            }
        }
        let count = (blocks * each) as f64;
        let t = process.freedom / (process.freedom - 2.0);
        for (i, [mean, deviation]) in process.predict(&points).into_iter().enumerate() {
            let (m, s) = (sum[i] / count, (square[i] / count - (sum[i] / count).powi(2)).sqrt());
            assert!((m - mean).abs() < 0.1 * deviation, "{m} {mean} {deviation}");
            assert!((s / deviation / t.sqrt() - 1.0).abs() < 0.12, "{s} {deviation}");
        }
    }
}
