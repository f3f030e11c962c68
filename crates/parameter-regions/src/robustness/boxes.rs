//! The search for the largest box.
//!
//! Patient rule induction, Friedman & Fisher (1999), "Bump hunting in high-dimensional data", Statistics and Computing
//! 9, 123-143: peel a thin slice off the side whose loss raises the mean most, until the level is reached; then paste
//! slices back while the level holds. One such search goes astray where the good part is curved or in several pieces:
//! every slice looks alike. So it also starts from many good points: from a small cube about each, which grows. Where no
//! such cube is good enough, it starts from everything with the point as one that must not be peeled off.

use rayon::prelude::*;
use sampling::statistics::moments::{quantile, sorted};

use super::region::{Region, Sample, within};

/// The part that is peeled off at a time.
const PEEL: f64 = 0.03;
/// A box with fewer points of the sample is too small to be told.
const FEWEST: usize = 100;
/// Good points with searches of their own.
const KEPT: usize = 16;
/// Of so many good points those are chosen.
const CHOICE: usize = 200;

/// How many searches there are at most.
pub const SEARCHES: usize = KEPT + 1;

type Limits = Vec<[f64; 2]>;

impl Sample<'_> {
    fn mean(&self, of: &[usize]) -> f64 {
        of.iter().map(|&j| self.verdicts[j]).sum::<f64>() / of.len() as f64
    }

    fn inside(&self, limits: &Limits) -> Vec<usize> {
        let inside = |j: &usize| within(&self.points[*j], limits);
        (0..self.points.len()).filter(inside).collect()
    }
}

/// The largest box found in which the mean probability is at least the level.
pub fn largest_box(sample: &Sample, level: f64) -> Option<Region> {
    let scale = Scale::new(sample.points);
    let everything = vec![[f64::NEG_INFINITY, f64::INFINITY]; scale.columns.len()];
    let start = |seed: &Seed| {
        if seed.mean >= level { (seed.cube.clone(), None) } else { (everything.clone(), Some(seed.point)) }
    };
    let seeds = seeds(sample, &scale, level);
    let whole = std::iter::once((everything.clone(), None));
    let starts: Vec<(Limits, Option<usize>)> = whole.chain(seeds.iter().map(start)).collect();
    let peeled = |(limits, kept): &(Limits, Option<usize>)| {
        let mut limits = limits.clone();
        peel(sample, level, &mut limits, *kept)?;
        Some(pasted(sample, &scale, level, limits))
    };
    let regions: Vec<Option<Region>> = starts.par_iter().map(peeled).collect();
    // Of equally large ones the first, so that the answer does not depend on the threads.
    let larger = |best: Region, next: Region| if next.share > best.share { next } else { best };
    regions.into_iter().flatten().reduce(larger)
}

/// A box inside another one, in which the mean probability is at least the level.
pub fn tightened(sample: &Sample, level: f64, region: &Region) -> Option<Region> {
    let mut limits = region.limits.clone();
    peel(sample, level, &mut limits, None)?;
    Some(pasted(sample, &Scale::new(sample.points), level, limits))
}

fn pasted(sample: &Sample, scale: &Scale, level: f64, mut limits: Limits) -> Region {
    paste(sample, scale, level, &mut limits);
    let limits = scale.closed(&limits);
    Region::new(limits, sample)
}

/// The parameters' sorted values: a parameter is measured by the part of the sample that lies below.
struct Scale {
    columns: Vec<Vec<f64>>,
}

impl Scale {
    fn new(points: &[Vec<f64>]) -> Self {
        let d = points.first().map_or(0, Vec::len);
        let column = |k: usize| sorted(points.iter().map(|x| x[k]).collect());
        Self { columns: (0..d).map(column).collect() }
    }

    fn rank(&self, k: usize, value: f64) -> f64 {
        let column = &self.columns[k];
        column.partition_point(|v| *v < value) as f64 / column.len() as f64
    }

    /// The value at a rank, and no limit beyond the ends.
    fn limit(&self, k: usize, rank: f64) -> f64 {
        match rank {
            rank if rank <= 0.0 => f64::NEG_INFINITY,
            rank if rank >= 1.0 => f64::INFINITY,
            rank => quantile(&self.columns[k], rank),
        }
    }

    /// Sides that were never cut end where the samples do.
    fn closed(&self, limits: &Limits) -> Limits {
        let sides = limits.iter().zip(&self.columns);
        sides.map(|([l, h], column)| [l.max(column[0]), h.min(column[column.len() - 1])]).collect()
    }
}

/// A good point, and the cube about it that holds a hundred points.
struct Seed {
    point: usize,
    cube: Limits,
    /// The mean probability in the cube.
    mean: f64,
    ranks: Vec<f64>,
}

/// Where boxes start: good points far from each other, if there are any those whose neighbourhood holds the level, as the edge of a
/// good part has no room for a box.
fn seeds(sample: &Sample, scale: &Scale, level: f64) -> Vec<Seed> {
    let good: Vec<usize> = (0..sample.points.len()).filter(|&j| sample.verdicts[j] >= level).collect();
    let step = good.len().div_ceil(CHOICE).max(1);
    let good: Vec<usize> = good.into_iter().step_by(step).collect();
    let rank = |x: &Vec<f64>| -> Vec<f64> {
        let places = x.iter().enumerate();
        places.map(|(k, v)| scale.rank(k, *v)).collect()
    };
    let ranks: Vec<Vec<f64>> = sample.points.par_iter().map(rank).collect();
    let seed = |&point: &usize| seed(sample, scale, &ranks, point);
    let (deep, edge): (Vec<Seed>, Vec<Seed>) =
        (good.par_iter().map(seed).collect::<Vec<_>>()).into_iter().partition(|seed| seed.mean >= level);
    spread(if deep.is_empty() { edge } else { deep })
}

fn seed(sample: &Sample, scale: &Scale, ranks: &[Vec<f64>], point: usize) -> Seed {
    let of_point = &ranks[point];
    let distance = |other: &Vec<f64>| {
        let sides = of_point.iter().zip(other).map(|(a, b)| (a - b).abs());
        sides.fold(0.0, f64::max)
    };
    let mut near: Vec<(f64, usize)> = ranks.iter().map(distance).zip(0..).collect();
    let most = FEWEST.min(near.len()).saturating_sub(1);
    near.select_nth_unstable_by(most, |a, b| a.0.total_cmp(&b.0));
    let radius = near[most].0;
    let inside: Vec<usize> = near[..=most].iter().map(|(_, j)| *j).collect();
    let side = |(k, rank): (usize, &f64)| [rank - radius, rank + radius].map(|rank| scale.limit(k, rank));
    Seed {
        point,
        cube: of_point.iter().enumerate().map(side).collect(),
        mean: sample.mean(&inside),
        ranks: of_point.clone(),
    }
}

/// Some that are far from each other: each next one is the farthest from those before (Gonzalez 1985, Theoretical
/// Computer Science 38, 293-306).
fn spread(mut seeds: Vec<Seed>) -> Vec<Seed> {
    let mut nearest = vec![f64::INFINITY; seeds.len()];
    let mut chosen: Vec<Seed> = Vec::new();
    while chosen.len() < KEPT && !seeds.is_empty() {
        // Of several the first.
        let places = (0..seeds.len()).rev();
        let farthest = places.max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
        let farthest = farthest.expect("a seed is left");
        nearest.swap_remove(farthest);
        let next = seeds.swap_remove(farthest);
        for (nearest, seed) in nearest.iter_mut().zip(&seeds) {
            let pairs = seed.ranks.iter().zip(&next.ranks);
            let distance: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
            *nearest = nearest.min(distance);
        }
        chosen.push(next);
    }
    chosen
}

/// Peels slices off until the level is reached; `None` where too few points are left before that.
fn peel(sample: &Sample, level: f64, limits: &mut Limits, kept: Option<usize>) -> Option<()> {
    let mut inside = sample.inside(limits);
    while sample.mean(&inside) < level {
        if inside.len() < FEWEST {
            return None;
        }
        let (_, k, side, cut) = thinnest(sample, &inside, kept)?;
        limits[k][side] = cut;
        inside.retain(|&j| beyond(sample.points[j][k], side, cut));
    }
    (!inside.is_empty()).then_some(())
}

fn beyond(value: f64, side: usize, cut: f64) -> bool {
    if side == 0 { value >= cut } else { value <= cut }
}

/// The slice whose loss raises the mean most: the mean then, the parameter, the side, and the new limit.
fn thinnest(sample: &Sample, inside: &[usize], kept: Option<usize>) -> Option<(f64, usize, usize, f64)> {
    let mut best: Option<(f64, usize, usize, f64)> = None;
    for k in 0..sample.points.first().map_or(0, Vec::len) {
        let column = sorted(inside.iter().map(|&j| sample.points[j][k]).collect());
        for (side, q) in [(0, PEEL), (1, 1.0 - PEEL)] {
            let Some(cut) = cut(&column, side, q) else {
                continue;
            };
            if kept.is_some_and(|kept| !beyond(sample.points[kept][k], side, cut)) {
                continue;
            }
            let (mut count, mut sum) = (0, 0.0);
            for &j in inside {
                if beyond(sample.points[j][k], side, cut) {
                    count += 1;
                    sum += sample.verdicts[j];
                }
            }
            let score = sum / f64::from(count.max(1));
            if (count as usize) < inside.len() && best.is_none_or(|best| score > best.0) {
                best = Some((score, k, side, cut));
            }
        }
    }
    best
}

/// The new limit where a slice is peeled off; `None` where all values are the same. A value that makes up more than the
/// slice, as a row of a sample may, goes as a whole.
fn cut(column: &[f64], side: usize, q: f64) -> Option<f64> {
    let (first, last) = (*column.first()?, *column.last()?);
    let cut = quantile(column, q);
    match side {
        0 if cut <= first => column.iter().copied().find(|value| *value > first),
        1 if cut >= last => column.iter().rev().copied().find(|value| *value < last),
        _ => Some(cut),
    }
}

/// Moves each limit out by a small step in turn, as long as the level holds.
fn paste(sample: &Sample, scale: &Scale, level: f64, limits: &mut Limits) {
    const STEP: f64 = 0.005;
    let mut open: Vec<(usize, usize)> = (0..limits.len()).flat_map(|k| [(k, 0), (k, 1)]).collect();
    while !open.is_empty() {
        open.retain(|&(k, side)| {
            let now = limits[k][side];
            if !now.is_finite() {
                return false;
            }
            limits[k][side] = match side {
                0 => scale.limit(k, scale.rank(k, now) - STEP),
                // Beyond all values that are as large, of which a sample may have many.
                _ => scale.limit(k, scale.rank(k, now.next_up()) + STEP),
            };
            let inside = sample.inside(limits);
            let moved = limits[k][side] != now;
            let holds = moved && !inside.is_empty() && sample.mean(&inside) >= level;
            if !holds {
                limits[k][side] = now;
            }
            holds
        });
    }
}
