//! A turn in implicit steps, where asperities hold the journal so stiffly that explicit ones would have to follow microseconds.

use super::TwoScales;
use crate::solver::{Budget, Failure, Rodas3, Work};
use nalgebra::{SMatrix, SVector};

/// The place, the flows' integrals and the time, s.
type Course = SVector<f64, 6>;

/// Step of the differences for the Jacobian in the place, and in seconds.
const NUDGE: f64 = 1e-8;

/// Where a turn from `start` ends, at a film viscosity, Pa.s, and a clearance, m, and the integrals of its flows. `allowed` is the
/// error allowed per step in place and heat.
pub fn turn<M: TwoScales>(
    model: &M,
    [viscosity, clearance]: [f64; 2],
    start: [f64; 2],
    allowed: [f64; 2],
    steps: usize,
    first: f64,
) -> Result<([f64; 2], [f64; 3], Work), Failure> {
    let [place, heat] = allowed;
    let integrator =
        Rodas3 { allowed: [place, place, heat, heat, f64::INFINITY, f64::INFINITY], budget: Budget::of(steps) };
    let journal = model.journal(clearance);
    let rates = |x: &Course| {
        let (velocity, flows) = journal(x[5], [x[0], x[1]], viscosity);
        let [x, y] = velocity;
        Course::new(x, y, flows.viscous, flows.boundary, flows.side_flow, 1.0)
    };
    let linear = |x: &Course| {
        let here = rates(x);
        let mut jacobian = SMatrix::<f64, 6, 6>::zeros();
        for column in [0, 1, 5] {
            let mut nudged = *x;
            nudged[column] += NUDGE;
            jacobian.set_column(column, &((rates(&nudged) - here) / (nudged[column] - x[column])));
        }
        Ok((here, jacobian))
    };
    let [x, y] = start;
    let mut course = Course::new(x, y, 0.0, 0.0, 0.0, 0.0);
    let work = integrator.integrate(|x| Ok(rates(x)), linear, &mut course, model.period(), first)?;
    let [x, y, viscous, boundary, side_flow, _] = course.into();
    Ok(([x, y], [viscous, boundary, side_flow], work))
}
