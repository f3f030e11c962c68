//! Fresh runs of the model inside the box and the ellipsoid.

use super::super::CommandError;
use super::super::batch::Batch;
use super::option;
use crate::analysis::robustness::Robustness;
use crate::analysis::table::PointTable;
use crate::design::Design;
use crate::distribution::Distribution;
use crate::study::{self, Method};

/// So many draws are looked through for points inside a small region.
const MOST_DRAWS: u64 = 4_000_000;

/// Runs `points` independent points of the study's distributions inside the box, and as many inside
/// the ellipsoid, and notes what comes out. The points have nothing to do with those of the study,
/// nor with those of the search.
pub(super) fn confirm(
    batch: &mut Batch,
    table: &PointTable,
    result: &mut Robustness,
    points: usize,
    seed: u64,
) -> Result<(), CommandError> {
    let places: Vec<usize> = (0..table.parameters.len())
        .filter(|&k| result.parameters.contains(&table.parameters[k].name))
        .collect();
    let varying = |x: &[f64]| -> Vec<f64> { places.iter().map(|&k| x[k]).collect() };
    if let Some(region) = &mut result.region {
        let chosen = draw(batch, points, seed, |x| region.contains(&varying(x)))?;
        let inner: Vec<Vec<f64>> = chosen.iter().map(|x| varying(x)).collect();
        region.fresh = Some(region.confirm(&inner, &verified(batch, &chosen)?));
    }
    if let Some(ellipsoid) = &mut result.ellipsoid {
        let chosen = draw(batch, points, seed, |x| ellipsoid.contains(&varying(x)))?;
        let inner: Vec<Vec<f64>> = chosen.iter().map(|x| varying(x)).collect();
        ellipsoid.fresh = Some(ellipsoid.confirm(&inner, &verified(batch, &chosen)?));
    }
    Ok(())
}

/// The first `points` of a sequence of independent points that lie inside.
fn draw(
    batch: &Batch,
    points: usize,
    seed: u64,
    inside: impl Fn(&[f64]) -> bool,
) -> Result<Vec<Vec<f64>>, CommandError> {
    let settings = study::Design {
        method: Method::MonteCarlo,
        points: MOST_DRAWS,
        // Far from the seeds that people give to studies.
        seed: !seed,
        replicates: 1,
    };
    let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
    let cube = Design::new(&settings, vec![unit; batch.varied().len()])
        .map_err(|message| option("confirm", &message))?;
    let draws = (0..MOST_DRAWS).map(|index| batch.parameters(&cube.point(index)));
    Ok(draws.filter(|x| inside(x)).take(points).collect())
}

fn verified(batch: &mut Batch, points: &[Vec<f64>]) -> Result<Vec<bool>, CommandError> {
    let outcomes = batch.run(points)?;
    let verdict =
        |outcome: &crate::results::Outcome| batch.judge.verdict(outcome.as_deref().ok()).verified();
    Ok(outcomes.iter().map(verdict).collect())
}
