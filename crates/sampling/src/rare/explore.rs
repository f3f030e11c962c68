//! Looks for the regions of the event: subset simulation (Au and Beck 2001) with a population of its own for each region.
//!
//! The event is approached by levels: of a population those points are kept that come nearest to it, and chains from them
//! fill the next population. In a single population chance lets one region after the other die out. So a population that
//! falls into parts is split, and each part goes on with levels of its own.

use super::moves::Moves;
use super::runs::Runs;
use super::separate::parts;
use crate::random::Random;

/// The part of a population that is kept at each level.
const KEPT: f64 = 0.1;
/// A population is kept to so many points at least.
const FEWEST: usize = 20;
/// Further parts of a population are no regions of their own.
const MOST_REGIONS: usize = 8;
/// The smallest population of a region.
const SMALLEST: usize = 500;
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
    /// The width of the last moves, and how it changed at the last level.
    width: f64,
    change: f64,
}

/// The regions in which the event happens: goes down from plain points, whose levels are known, with populations of so
/// many points and at most so many runs. Notes the levels on the way, each with the share of the space that reaches it.
pub(super) fn explore<E>(
    plain: (Vec<Vec<f64>>, Vec<f64>),
    most_runs: u64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
    levels: &mut Vec<(f64, f64)>,
) -> Result<Vec<Population>, E> {
    let size = plain.0.len();
    let end = runs.made + most_runs;
    let mut regions = Vec::new();
    let mut open = vec![Population {
        points: plain.0,
        levels: plain.1,
        reached: f64::INFINITY,
        share: 1.0,
        width: 0.6,
        change: 1.0,
    }];
    for _ in 0..MOST_LEVELS {
        let size = (size / (open.len() + regions.len())).max(SMALLEST.min(size));
        let mut next = Vec::new();
        let mut level = (f64::NEG_INFINITY, 0.0);
        for population in &open {
            // A region is given up when the runs are used up, or its level does not change.
            if runs.made + size as u64 > end.min(runs.most) {
                continue;
            }
            let Some(deeper) = population.deeper(size, runs, random)? else {
                continue;
            };
            level = (deeper.reached.max(level.0), level.1 + deeper.share);
            let split = if open.len() + next.len() + regions.len() < MOST_REGIONS {
                parts(&deeper.points, deeper.reached, runs, random)?
            } else {
                vec![0; deeper.points.len()]
            };
            for part in deeper.split(&split) {
                if part.reached == f64::NEG_INFINITY {
                    regions.push(part);
                } else {
                    next.push(part);
                }
            }
        }
        if level.1 > 0.0 && level.0 > f64::NEG_INFINITY {
            let done: f64 = regions.iter().map(|region: &Population| region.share).sum();
            levels.push((level.0, level.1.max(done)));
        }
        open = next;
        if open.is_empty() {
            break;
        }
    }
    Ok(regions)
}

impl Population {
    /// Points that meet the event and stand for this share of the space.
    pub(super) fn at_the_event(points: Vec<Vec<f64>>, share: f64) -> Self {
        Self {
            levels: vec![f64::NEG_INFINITY; points.len()],
            points,
            reached: f64::NEG_INFINITY,
            share,
            width: 1.0,
            change: 1.0,
        }
    }

    /// The population at the next level; none where that is no other one.
    fn deeper<E>(
        &self,
        size: usize,
        runs: &mut Runs<'_, E>,
        random: &mut Random,
    ) -> Result<Option<Self>, E> {
        let count = self.points.len();
        let kept = ((KEPT * count as f64) as usize).max(FEWEST).min(count);
        let mut sorted = self.levels.clone();
        sorted.sort_by(f64::total_cmp);
        let level = sorted[kept - 1];
        if level >= self.reached {
            return Ok(None);
        }
        let inside: Vec<usize> = (0..count).filter(|&i| self.levels[i] <= level).collect();
        let share = self.share * inside.len() as f64 / count as f64;
        let all: Vec<Vec<f64>> = inside.iter().map(|&i| self.points[i].clone()).collect();
        // In a narrowing band the steps become narrower at each level by about the same factor.
        let width = self.width * self.change;
        let mut moves = Moves::along(&all, width);
        let chains = ((KEPT * size as f64) as usize).max(1);
        let chosen = random.choice(chains, inside.len());
        let mut points: Vec<Vec<f64>> = chosen.iter().map(|&k| all[k].clone()).collect();
        let mut levels: Vec<f64> = chosen.iter().map(|&k| self.levels[inside[k]]).collect();
        let chains = points.len();
        for _ in 1..size.div_ceil(chains) {
            let from = points.len() - chains;
            let tried: Vec<Vec<f64>> = points[from..]
                .iter()
                .map(|point| moves.from(point, 1.0, random))
                .collect();
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
            change: (moves.width / self.width).clamp(0.05, 1.0),
            width: moves.width,
        }))
    }

    /// The parts of a population, each point's part given.
    fn split(self, parts: &[usize]) -> Vec<Self> {
        let count = parts.iter().max().map_or(1, |last| last + 1);
        if count == 1 {
            return vec![self];
        }
        let part = |number: usize| {
            let members: Vec<usize> = (0..parts.len()).filter(|&i| parts[i] == number).collect();
            Self {
                points: members.iter().map(|&i| self.points[i].clone()).collect(),
                levels: members.iter().map(|&i| self.levels[i]).collect(),
                share: self.share * members.len() as f64 / parts.len() as f64,
                reached: self.reached,
                width: self.width,
                change: self.change,
            }
        };
        (0..count).map(part).collect()
    }
}
