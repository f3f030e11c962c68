//! Parameters beyond their ranges.

use super::{
    super::problem::{Free, NoPrediction, Spacing},
    inquiry::{Candidate, Inquiry, Suspect, Suspicion},
    linear::Linear,
};

impl Inquiry<'_> {
    /// Parameters that are at a bound, or far from where they were expected, and would go on.
    pub(super) fn ranges(&self, linear: &Linear) -> Vec<Candidate<'_>> {
        const FAR: f64 = 2.0;
        let free = self.problem.free.iter().enumerate().zip(&self.optimum.minimum.places);
        free.filter_map(|((k, free), &place)| {
            let known = free.prior_place().map(|(centre, deviation)| (place - centre) / deviation);
            let (fall, size) = linear.score(&linear.slopes.column(k).into_owned(), Some(k))?;
            let outward = (place <= 0.0 && size < 0.0) || (place >= 1.0 && size > 0.0);
            let far = known.is_some_and(|known| known.abs() > FAR && known * size > 0.0);
            let fall = fall + known.map_or(0.0, |known| known.powi(2));
            (outward || far).then(|| Candidate { fall, fit: Box::new(move || self.beyond(k, place + size)) })
        })
        .collect()
    }

    /// A parameter with a wider range and without a prior.
    fn beyond(&self, k: usize, place: f64) -> Result<Suspect, NoPrediction> {
        let old = &self.problem.free[k];
        // The others are at their bounds here, and leave these once it moves: so it may go much farther than the slopes say.
        let ends = [4.0 * place.min(0.0) - 5.0, 4.0 * place.max(1.0) + 2.0].map(|place| wide(old, place));
        let mut free = Free { prior: None, ..old.clone() };
        [free.min, free.max] = [ends[0].max(self.reach[k][0]), ends[1].min(self.reach[k][1])];
        // What is positive stays so.
        if old.min > 0.0 {
            free.min = free.min.max(0.05 * old.min);
        }
        let mut problem = self.problem.clone();
        let mut start = self.optimum.minimum.places.clone();
        start[k] = free.place(old.value(start[k]));
        problem.free[k] = free;
        let minimum = self.minimised(&problem, self.model, start)?;
        let value = problem.free[k].value(minimum.places[k]);
        let outside = match old.prior_place() {
            Some((centre, deviation)) => ((old.place(value) - centre) / (2.0 * deviation)).abs(),
            None => 2.0 * (old.place(value) - old.place(value).clamp(0.0, 1.0)).abs(),
        };
        let allowed = match old.prior {
            Some(prior) if old.scale == Spacing::Linear => {
                [-2.0, 2.0].map(|side| (prior.centre + side * prior.spread).clamp(old.min, old.max))
            }
            _ => [old.min, old.max],
        };
        Ok(Suspect {
            value,
            unit: old.unit.clone(),
            allowed: Some(allowed),
            departure: outside,
            ..self.suspect(Suspicion::Range, &old.name, &problem, &minimum)
        })
    }
}

/// A value at a place that may be outside of the bounds.
fn wide(free: &Free, place: f64) -> f64 {
    match free.scale {
        Spacing::Linear => free.min + place * (free.max - free.min),
        Spacing::Log => free.min * (free.max / free.min).powf(place),
    }
}
