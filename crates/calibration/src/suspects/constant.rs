//! Constants of the model with another value.

use nalgebra::DVector;

use super::{
    super::{problem::NoPrediction, remembered::Remembered},
    inquiry::{Candidate, Constant, Inquiry, Suspect, Suspicion},
    linear::Linear,
};

impl Inquiry<'_> {
    /// Constants, each by the run with another value.
    pub(super) fn of_constants(&self, linear: &Linear) -> Vec<Candidate<'_>> {
        let predicted = &self.optimum.minimum.misfit.predicted;
        self.constants
            .iter()
            .filter_map(|constant| {
                let (other, moved) = &constant.moved;
                let [here, there] = [constant.value, *other].map(|value| constant.free.place(value));
                let column = predicted
                    .iter()
                    .flatten()
                    .zip(moved.iter().flatten())
                    .map(|(old, new)| (new - old) / (there - here));
                let column = DVector::from_iterator(linear.accuracies.len(), column).component_div(&linear.accuracies);
                let (fall, size) = linear.score(&column, None)?;
                Some(Candidate { fall, fit: Box::new(move || self.constant(constant, here + size)) })
            })
            .collect()
    }

    fn constant(&self, constant: &Constant, place: f64) -> Result<Suspect, NoPrediction> {
        let free = &constant.free;
        let last = self.problem.free.len();
        let mut problem = self.problem.clone();
        problem.free.push(free.clone());
        let mut start = self.optimum.minimum.places.clone();
        start.insert(last, place.clamp(0.02, 0.98));
        let model = Remembered::new(&*constant.model, []);
        let minimum = self.minimised(&problem, &model, start)?;
        let value = free.value(minimum.places[last]);
        let departure = match constant.usual {
            0.0 => 2.0,
            usual => ((value - constant.value) / usual).abs(),
        };
        Ok(Suspect {
            value,
            unit: free.unit.clone(),
            allowed: (constant.fault == Suspicion::Constant).then_some([constant.value; 2]),
            departure,
            ..self.suspect(constant.fault.clone(), &free.name, &problem, &minimum)
        })
    }
}
