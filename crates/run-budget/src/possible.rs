//! What the outputs may be at points: values of functions that the surrogate draws.

use crate::limit::{Event, Limit};
use crate::output::{Functions, Output};
use crate::surrogate::Surrogate;
use nalgebra::DMatrix;

/// Noise of so small a part of an output's deviation changes no sign.
const NO_NOISE: f64 = 1e-4;

/// Functions that the outputs of a model may be, drawn once to be asked at many points.
pub struct Drawn<'a> {
    surrogate: &'a Surrogate,
    outputs: Vec<Functions<'a>>,
    success: Option<Functions<'a>>,
}

impl<'a> Drawn<'a> {
    /// `each` functions of each member of an output's sample.
    pub fn new(surrogate: &'a Surrogate, each: usize) -> Self {
        let outputs = (0..surrogate.outputs.len()).map(|output| surrogate.functions(output, each)).collect();
        Self { surrogate, outputs, success: surrogate.success(each) }
    }

    /// Their values, with noise or without it.
    pub fn at(&self, points: &[Vec<f64>], noise: bool) -> Possible {
        let Self { surrogate, outputs, success } = self;
        let standard = surrogate.standard(points);
        let of = |(output, functions): (usize, &Functions<'_>)| {
            let mut values = functions.at(&standard);
            let mut random = surrogate.random(4000 + output as u32);
            let least = if noise { NO_NOISE * surrogate.spread(output) } else { f64::INFINITY };
            for (mut column, error) in values.column_iter_mut().zip(functions.noise()).filter(|(_, e)| *e > least) {
                column.iter_mut().for_each(|v| *v += error * random.normal());
            }
            values
        };
        Possible {
            values: outputs.iter().enumerate().map(of).collect(),
            success: success.as_ref().map(|functions| functions.at(&standard)),
            spreads: surrogate.outputs.iter().map(|output| output.unit).collect(),
            points: points.len(),
        }
    }
}

/// Values at points of functions that the model may be: a row a point, a column a function.
#[derive(Clone, Debug)]
pub struct Possible {
    /// By output.
    pub values: Vec<DMatrix<f64>>,
    /// Where it is negative a run would fail.
    pub success: Option<DMatrix<f64>>,
    spreads: Vec<f64>,
    pub points: usize,
}

impl Possible {
    /// Of functions that are asked only here, with noise; see [`Drawn`].
    pub fn new(surrogate: &Surrogate, points: &[Vec<f64>], each: usize) -> Self {
        Drawn::new(surrogate, each).at(points, true)
    }

    /// The most probable functions alone.
    pub fn likely(surrogate: &Surrogate, points: &[Vec<f64>]) -> Self {
        let standard = surrogate.standard(points);
        let of = |output: &Output| DMatrix::from_vec(points.len(), 1, output.means(&standard));
        Self {
            values: surrogate.outputs.iter().map(of).collect(),
            success: surrogate.success.as_ref().map(of),
            spreads: surrogate.outputs.iter().map(|output| output.unit).collect(),
            points: points.len(),
        }
    }

    /// The least margin over all limits, in deviations of the outputs, and below 0 where a run would fail.
    pub fn margins(&self, limits: &[Limit]) -> DMatrix<f64> {
        let mut least = self.success.clone();
        for limit in limits {
            let margins = self.values[limit.output].map(|v| limit.margin(v) / self.spreads[limit.output]);
            least = Some(match least {
                None => margins,
                Some(before) => before.zip_map(&margins, f64::min),
            });
        }
        least.unwrap_or_else(|| DMatrix::repeat(self.points, 1, 1.0))
    }

    /// Below 0 where an event happens.
    pub fn event(&self, event: Event, limits: &[Limit]) -> DMatrix<f64> {
        match (event, &self.success) {
            (Event::Kept, _) => -self.margins(limits),
            (Event::Failed, Some(success)) => success.clone(),
            (Event::Failed, None) => DMatrix::repeat(self.points, 1, 1.0),
            (Event::Missed, None) => self.margins(limits),
            (Event::Missed, Some(success)) => {
                let ended = Self { success: None, ..self.clone() };
                ended.margins(limits).zip_map(success, |margin, success| margin.max(-success))
            }
        }
    }
}
