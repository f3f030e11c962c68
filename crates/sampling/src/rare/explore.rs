//! The way to the event by levels: subset simulation (Au and Beck 2001).
//!
//! The event is approached by levels: of a population those points are kept that come nearest to it, and chains from them
//! fill the next population. Chance lets one part of the event after the other die out in a single population; so there
//! are several, which know nothing of each other (`gather`).

use super::moves::Moves;
use super::runs::Runs;
use crate::random::Random;

/// The part of a population that is kept at each level.
const KEPT: f64 = 0.1;
/// A population is kept to so many points at least.
const FEWEST: usize = 20;
/// So many levels lead below any share that a number can tell.
const MOST_LEVELS: usize = 60;

/// A population at one level.
#[derive(Clone, Debug)]
pub(super) struct Population {
    pub(super) points: Vec<Vec<f64>>,
    levels: Vec<f64>,
    /// The level that all of its points have reached.
    reached: f64,
    /// The estimated share of the space that its points stand for.
    pub(super) share: f64,
    /// The widths of the last moves, and how they changed at the last level.
    widths: [f64; 2],
    changes: [f64; 2],
}

/// A population at the event: goes down from plain points, whose levels are known, with at most so many runs. Notes the
/// levels on the way, each with the share of the space that reaches it. None where it does not arrive.
pub(super) fn explore<E>(
    (points, levels): (Vec<Vec<f64>>, Vec<f64>),
    most_runs: u64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
    passed: &mut Vec<(f64, f64)>,
) -> Result<Option<Population>, E> {
    let size = points.len();
    let end = (runs.made + most_runs).min(runs.most);
    let mut population =
        Population { points, levels, reached: f64::INFINITY, share: 1.0, widths: [0.6, 1.0], changes: [1.0; 2] };
    for _ in 0..MOST_LEVELS {
        if runs.made + size as u64 > end {
            break;
        }
        let Some(deeper) = population.deeper(size, runs, random)? else {
            break;
        };
        if deeper.reached == f64::NEG_INFINITY {
            return Ok(Some(deeper));
        }
        passed.push((deeper.reached, deeper.share));
        population = deeper;
    }
    Ok(None)
}

impl Population {
    /// Points that meet the event and stand for this share of the space.
    pub(super) fn at_the_event(points: Vec<Vec<f64>>, share: f64) -> Self {
        Self {
            levels: vec![f64::NEG_INFINITY; points.len()],
            points,
            reached: f64::NEG_INFINITY,
            share,
            widths: [1.0; 2],
            changes: [1.0; 2],
        }
    }

    /// The population at the next level; none where that is no other one.
    fn deeper<E>(&self, size: usize, runs: &mut Runs<'_, E>, random: &mut Random) -> Result<Option<Self>, E> {
        let count = self.points.len();
        let kept = ((KEPT * count as f64) as usize).max(FEWEST).min(count);
        let mut sorted = self.levels.clone();
        sorted.sort_by(f64::total_cmp);
        // Of levels in steps the next one may have fewer points.
        let below = sorted.partition_point(|level| *level < self.reached);
        if below < FEWEST.min(kept) {
            return Ok(None);
        }
        let level = sorted[kept.min(below) - 1];
        let inside: Vec<usize> = (0..count).filter(|&i| self.levels[i] <= level).collect();
        let share = self.share * inside.len() as f64 / count as f64;
        let all: Vec<Vec<f64>> = inside.iter().map(|&i| self.points[i].clone()).collect();
        // In a narrowing band the steps become narrower at each level by about the same factor.
        let widths = [0, 1].map(|kind| self.widths[kind] * self.changes[kind]);
        let mut moves = Moves::along(&all, widths);
        let chains = ((KEPT * size as f64) as usize).max(1);
        let chosen = random.choice(chains, inside.len());
        let mut points: Vec<Vec<f64>> = chosen.iter().map(|&k| all[k].clone()).collect();
        let mut levels: Vec<f64> = chosen.iter().map(|&k| self.levels[inside[k]]).collect();
        let chains = points.len();
        for _ in 1..size.div_ceil(chains) {
            let from = points.len() - chains;
            let tried: Vec<Vec<f64>> = points[from..].iter().map(|point| moves.from(point, 1.0, random)).collect();
            let results = runs.levels(&tried)?;
            let mut accepted = 0;
            for (k, (point, result)) in tried.into_iter().zip(results).enumerate() {
                if result <= level {
                    accepted += 1;
                    points.push(point);
                    levels.push(result);
                } else {
                    points.push(points[from + k].clone());
                    levels.push(levels[from + k]);
                }
            }
            moves.adapt(f64::from(accepted) / chains as f64);
        }
        Ok(Some(Self {
            points,
            levels,
            reached: level,
            share,
            changes: [0, 1].map(|kind| (moves.widths[kind] / self.widths[kind]).clamp(0.05, 1.0)),
            widths: moves.widths,
        }))
    }
}
