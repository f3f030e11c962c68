//! The straightest way to the event from many places, one after the other (Rechenberg 1973, "Evolutionsstrategie").
//!
//! Of a population at a level those parts of the event die out that are small there, however large they are at the event
//! itself: all searches lose them alike. A walk that only ever goes down stays in the valley where it begins, and walks begin
//! in the valleys as often as these hold plain points.

use super::runs::Runs;
use crate::random::Random;

/// Runs of each walk at most.
const MOST_STEPS: usize = 100;
/// Steps so narrow lead nowhere.
const NARROWEST: f64 = 1e-4;
/// Steps become wider by this factor where one leads down, and narrower by its fourth root where none does: one of five does
/// where their width is best.
const WIDER: f64 = 1.5;

/// A walk.
struct Walk {
    point: Vec<f64>,
    level: f64,
    width: f64,
}

/// Points of the event that walks from these points, with their levels, come to.
pub(super) fn descend<E>(
    starts: impl Iterator<Item = (Vec<f64>, f64)>,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
) -> Result<Vec<Vec<f64>>, E> {
    let walk = |(point, level)| Walk { point, level, width: 0.5 };
    let mut walks: Vec<Walk> = starts.map(walk).collect();
    let mut arrived = Vec::new();
    for _ in 0..MOST_STEPS {
        let next = |walk: &Walk| -> Vec<f64> {
            let kept = (1.0 - walk.width * walk.width).sqrt();
            let moved = |x: &f64| kept * x + walk.width * random.normal();
            walk.point.iter().map(moved).collect()
        };
        let tried: Vec<Vec<f64>> = walks.iter().map(next).collect();
        let levels = runs.levels(&tried)?;
        for (walk, (point, level)) in walks.iter_mut().zip(tried.into_iter().zip(levels)) {
            if level < walk.level {
                (walk.point, walk.level) = (point, level);
                walk.width = (walk.width * WIDER).min(0.9);
            } else {
                walk.width *= WIDER.powf(-0.25);
            }
        }
        let ended = |walk: &mut Walk| walk.level == f64::NEG_INFINITY || walk.width < NARROWEST;
        let ended = walks.extract_if(.., ended);
        arrived.extend(ended.filter(|w| w.level == f64::NEG_INFINITY).map(|w| w.point));
        if walks.is_empty() {
            break;
        }
    }
    Ok(arrived)
}
