//! Points in the unit cube.

use crate::design::{Design, Method, Sampling};
use crate::distribution::Distribution;

/// Points that belong to independently scrambled Sobol nets in turn.
pub(super) fn points(
    dimensions: usize,
    points: u64,
    seed: u64,
    replicates: u64,
) -> Result<Vec<Vec<f64>>, String> {
    let sampling = Sampling {
        method: Method::Sobol,
        points,
        seed,
        replicates,
    };
    let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
    let design = Design::new(&sampling, vec![unit; dimensions])?;
    Ok((0..points).map(|index| design.point(index)).collect())
}
