//! Looks for an event of which a run says only whether it happens: by points drawn wider, and then step by step back to
//! the parameters' own distribution (sequential importance sampling; Papaioannou, Papadimitriou and Straub 2016).

use super::Plain;
use super::explore::Population;
use super::moves::Moves;
use super::runs::Runs;
use super::scatter::effective;
use crate::random::Random;

/// How much wider points are drawn, one after the other, until enough of them meet the event.
const WIDER: [f64; 4] = [1.5, 2.0, 3.0, 4.0];
/// Points that meet the event before the way back begins.
const ENOUGH: usize = 40;
/// A step towards the parameters' own distribution is so long that its weights leave this effective part of the points.
const KEPT: f64 = 0.4;
/// Moves of each chain at a step.
const MOVES: usize = 4;
const MOST_STEPS: usize = 40;
/// Chains at a step.
const CHAINS: u64 = 500;

/// Points that meet the event, distributed as the parameters are. `wider` counts the wider draws.
pub(super) fn widen<E>(
    dimensions: usize,
    size: u64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
    wider: &mut Plain,
) -> Result<Option<Population>, E> {
    for scale in WIDER {
        if runs.left() < 2 * size {
            return Ok(None);
        }
        let draw = |_| -> Vec<f64> {
            let scores = random.normals(dimensions);
            scores.into_iter().map(|z| scale * z).collect()
        };
        let points: Vec<Vec<f64>> = (0..size).map(draw).collect();
        let results = runs.of(&points)?;
        let pairs = points.into_iter().zip(&results);
        let hits: Vec<Vec<f64>> = pairs.filter(|(_, r)| r.met).map(|(p, _)| p).collect();
        wider.runs += size;
        wider.met += hits.len() as u64;
        let share = hits.len() as f64 / size as f64;
        let is_last = scale >= WIDER[WIDER.len() - 1];
        if hits.len() >= ENOUGH || is_last && !hits.is_empty() {
            return back(hits, share, scale, size.min(CHAINS), runs, random);
        }
    }
    Ok(None)
}

/// The way back from points that meet the event among those drawn wider, of which they are a share.
fn back<E>(
    mut points: Vec<Vec<f64>>,
    mut share: f64,
    mut scale: f64,
    size: u64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
) -> Result<Option<Population>, E> {
    let size = usize::try_from(size).expect("a population has 2,000 points at most");
    let mut widths = [0.6, 1.0];
    for _ in 0..MOST_STEPS {
        if runs.left() < 2 * (size * MOVES) as u64 {
            return Ok(None);
        }
        let next = narrower(&points, scale);
        let weights = weights(&points, scale, next);
        share *= weights.iter().sum::<f64>() / points.len() as f64;
        let chosen: Vec<usize> = (0..size).map(|_| random.pick(&weights)).collect();
        points = chosen.iter().map(|&k| points[k].clone()).collect();
        scale = next;
        let mut moves = Moves::along(&points, widths);
        for _ in 0..MOVES {
            let tried: Vec<Vec<f64>> = points.iter().map(|point| moves.from(point, scale, random)).collect();
            let results = runs.of(&tried)?;
            let mut accepted = 0;
            for ((point, next), result) in points.iter_mut().zip(tried).zip(results) {
                if result.met {
                    accepted += 1;
                    *point = next;
                }
            }
            moves.adapt(f64::from(accepted) / size as f64);
        }
        widths = moves.widths;
        if scale <= 1.0 {
            return Ok(Some(Population::at_the_event(points, share)));
        }
    }
    Ok(None)
}

/// The ratios of the densities of two normal distributions about 0.
fn weights(points: &[Vec<f64>], from: f64, to: f64) -> Vec<f64> {
    let factor = 0.5 * (1.0 / (to * to) - 1.0 / (from * from));
    let ratio = |point: &Vec<f64>| {
        let squares: f64 = point.iter().map(|x| x * x).sum();
        (point.len() as f64 * (from / to).ln() - factor * squares).exp()
    };
    points.iter().map(ratio).collect()
}

/// The narrowest distribution, but not narrower than the parameters' own, that keeps enough points effective.
fn narrower(points: &[Vec<f64>], scale: f64) -> f64 {
    let kept = |to: f64| effective(&weights(points, scale, to)) / points.len() as f64;
    if kept(1.0) >= KEPT {
        return 1.0;
    }
    let (mut low, mut high) = (1.0, scale);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if kept(middle) >= KEPT {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}
