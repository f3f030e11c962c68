//! Whether a population lies in one region or in several.
//!
//! Its clusters are regions of their own where every way between them leaves the level: straight ones, and arcs about the
//! centre, along which points in many dimensions keep their distance from it.

use super::mixture::Mixture;
use super::runs::Runs;
use crate::random::Random;

const MOST_CLUSTERS: usize = 4;
/// Pairs of points that are tried between two clusters.
const PAIRS: usize = 5;
/// The partner of a pair is the nearest of so many.
const NEAREST_OF: usize = 20;
/// Places on a way at which the model is run.
const PLACES: [f64; 5] = [0.2, 0.35, 0.5, 0.65, 0.8];

/// The part to which each point belongs, counted from 0.
pub(super) fn parts<E>(
    points: &[Vec<f64>],
    level: f64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
) -> Result<Vec<usize>, E> {
    let weights = vec![1.0; points.len()];
    let clusters = Mixture::fit(points, &weights, MOST_CLUSTERS, random);
    let nearest: Vec<usize> = points.iter().map(|p| clusters.nearest(p)).collect();
    let members = |cluster: usize| -> Vec<usize> {
        let of_cluster = (0..points.len()).filter(|&i| nearest[i] == cluster);
        of_cluster.collect()
    };
    let groups: Vec<Vec<usize>> = (0..clusters.len()).map(members).collect();
    let mut owner: Vec<usize> = (0..groups.len()).collect();
    for a in 0..groups.len() {
        for b in a + 1..groups.len() {
            if owner[a] == owner[b] || groups[a].is_empty() || groups[b].is_empty() {
                continue;
            }
            let ways = ways(points, &groups[a], &groups[b], random);
            let flat: Vec<Vec<f64>> = ways.concat();
            let levels = runs.levels(&flat)?;
            let mut each = levels.chunks(PLACES.len());
            if each.any(|way| way.iter().all(|at_place| *at_place <= level)) {
                let (from, to) = (owner[b], owner[a]);
                owner.iter_mut().for_each(|o| {
                    if *o == from {
                        *o = to;
                    }
                });
            }
        }
    }
    let mut roots: Vec<usize> = nearest.iter().map(|&cluster| owner[cluster]).collect();
    let mut names = roots.clone();
    names.sort_unstable();
    names.dedup();
    for root in &mut roots {
        *root = names.binary_search(root).expect("each root is a name");
    }
    Ok(roots)
}

/// Ways from points of one cluster to near ones of another.
fn ways(points: &[Vec<f64>], a: &[usize], b: &[usize], random: &mut Random) -> Vec<Vec<Vec<f64>>> {
    let mut ways = Vec::new();
    for _ in 0..PAIRS {
        let from = &points[a[random.below(a.len())]];
        let candidates = random.choice(NEAREST_OF, b.len());
        let square = |k: &usize| -> f64 {
            let to = &points[b[*k]];
            from.iter().zip(to).map(|(x, y)| (x - y).powi(2)).sum()
        };
        let nearest = candidates
            .iter()
            .min_by(|p, q| square(p).total_cmp(&square(q)));
        let Some(&nearest) = nearest else { continue };
        let to = &points[b[nearest]];
        ways.push(PLACES.iter().map(|&f| straight(from, to, f)).collect());
        ways.push(PLACES.iter().map(|&f| arc(from, to, f)).collect());
    }
    ways
}

fn straight(from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    let pairs = from.iter().zip(to);
    pairs.map(|(x, y)| x + part * (y - x)).collect()
}

/// A place on the arc about the centre; its distance from the centre changes evenly.
fn arc(from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (a, b) = (length(from), length(to));
    let product: f64 = from.iter().zip(to).map(|(x, y)| x * y).sum();
    let angle = (product / (a * b)).clamp(-1.0, 1.0).acos();
    if angle.is_nan() || angle.sin() <= 1e-9 {
        return straight(from, to, part);
    }
    let radius = (a + part * (b - a)) / angle.sin();
    let (p, q) = (((1.0 - part) * angle).sin() / a, (part * angle).sin() / b);
    let pairs = from.iter().zip(to);
    pairs.map(|(x, y)| radius * (p * x + q * y)).collect()
}
