//! Whether a fit speaks for the model: by the size of the misfits, and by their order along each measured curve.

use result_document::format::significant;
use serde::Serialize;

use super::{
    influence::{Farthest, Group},
    order::Order,
    outcome::IdentificationOutcome,
    problem::Estimate,
    suspects::Suspect,
};

/// A right model misses by more with this probability, or its residuals are more in order: then the fit is in doubt.
const DOUBTFUL: f64 = 0.05;

/// How well the model fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FitVerdict {
    /// As a right model would.
    Good,
    /// With as many unknowns as measured values nothing could have shown.
    Untested,
    /// Worse than a right model would, in size or in order.
    Misses,
}

impl IdentificationOutcome {
    /// Looks at the order of the residuals of curves.
    pub fn look_along(&mut self, curves: &[Group], estimates: &[Estimate]) {
        let orders = curves.iter().filter_map(|curve| {
            let is_its = |e: &&Estimate| e.quantities.contains(&curve.values[0][1]);
            let residuals: Vec<f64> =
                curve.values.iter().map(|&[case, quantity]| self.cases[case].residuals[quantity].missed()).collect();
            Order::of(&curve.name, &residuals, estimates.iter().find(is_its))
        });
        self.orders = orders.collect();
        self.ambiguous = self.has_several() && self.fit() != FitVerdict::Misses;
    }

    /// Whether there are several optima.
    pub fn has_several(&self) -> bool {
        self.optima.len() > 1
    }

    /// How well the model fits.
    pub fn fit(&self) -> FitVerdict {
        match self.probability {
            None if !self.is_out_of_reach() => FitVerdict::Untested,
            // Far within the stated uncertainties the order of the residuals is a doubt, and no miss.
            Some(_) if self.is_too_close() || self.doubts().is_empty() => FitVerdict::Good,
            _ => FitVerdict::Misses,
        }
    }

    /// Whether a cause was found that explains all of the misfit.
    pub fn is_explained(&self) -> bool {
        self.suspects.as_ref().and_then(|suspects| suspects.first()).is_some_and(Suspect::explains)
    }

    /// Whether the misfit is smaller than the stated uncertainties allow.
    pub fn is_too_close(&self) -> bool {
        const RARE: f64 = 1e-3;
        self.probability.is_some_and(|probability| probability > 1.0 - RARE)
    }

    /// Whether the model misses values that it has enough unknowns for: a bound or its own form keeps it from them.
    fn is_out_of_reach(&self) -> bool {
        /// A single value is missed by two standard uncertainties.
        const MISSED: f64 = 4.0;
        self.cost > MISSED
    }

    /// The level of each test, where there is one of the size of the misfits, one of the value that is the farthest off and one
    /// of the order along each curve.
    fn level(&self) -> f64 {
        DOUBTFUL / (1 + usize::from(self.farthest.is_some()) + self.orders.len()) as f64
    }

    /// Whether the value that is the farthest off is farther than chance explains.
    pub fn is_farthest_doubtful(&self) -> bool {
        self.farthest.as_ref().is_some_and(|farthest| farthest.probability < self.level())
    }

    /// Whether the residuals of a curve are in order, so that its rows tell less than the intervals presume.
    pub fn is_too_narrow(&self) -> bool {
        self.orders.iter().any(|order| order.is_doubtful(self.level()))
    }

    /// What the intervals of the parameters are, beside each.
    pub fn interval(&self) -> &'static str {
        match self.fit() {
            _ if self.is_too_narrow() => "95 %, too narrow",
            FitVerdict::Misses => "95 % if the model were right",
            FitVerdict::Good | FitVerdict::Untested => "95 %",
        }
    }

    /// What speaks against the model, or the stated uncertainties, a sentence each.
    pub fn doubts(&self) -> Vec<String> {
        let size = match self.probability {
            None if self.is_out_of_reach() => Some(
                "The model cannot reach the measured values, although it has as many unknowns: a bound or its form keeps it from \
                 them."
                    .to_owned(),
            ),
            None => Some(
                match self.surplus {
                    0 => {
                        "As many unknowns as measured values: a fit was certain and shows nothing."
                    }
                    _ => "More unknowns than measured values: a fit was certain and shows nothing.",
                }
                .to_owned(),
            ),
            Some(p) if p < self.level() => Some(format!(
                "A right model would miss by this much in fewer than {} tests: something is probably missing, in the model or in the \
                 stated uncertainties.",
                times(p)
            )),
            Some(_) => None,
        };
        let orders = self.orders.iter().filter(|order| order.is_doubtful(self.level()));
        let (names, correlations): (Vec<&str>, Vec<String>) =
            orders.map(|order| (&*order.name, significant(order.correlation, 2))).unzip();
        let orders = (!names.is_empty()).then(|| {
            format!(
                "The residuals of {} are no noise: each is like the one before (correlation {}). The model, or the stated noise, \
                 leaves something out, and the intervals are too narrow.",
                names.join(", "),
                correlations.join(", ")
            )
        });
        let farthest = self.farthest.as_ref().filter(|_| self.is_farthest_doubtful());
        let farthest = farthest.map(|farthest| {
            let Farthest { case, quantity, studentised, leverage, probability } = farthest;
            let of_case = if self.cases.len() > 1 { format!(" in case {case}") } else { String::new() };
            format!(
                "The measured value of {quantity}{of_case} is {} of its own standard deviations off (leverage {}); by chance the largest \
                 of all is so large in fewer than {} records. Look at it: nothing was left out.",
                significant(studentised.abs(), 3),
                significant(*leverage, 2),
                times(*probability)
            )
        });
        size.into_iter().chain(farthest).chain(orders).collect()
    }
}

/// A small probability as a count: 1 of 100, of 1,000 or of a million.
fn times(probability: f64) -> String {
    match probability {
        p if p < 1e-6 => "1 of a million".to_owned(),
        p if p < 1e-3 => "1 of 1,000".to_owned(),
        p => format!("{} of 100", (100.0 * p).floor() + 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::{Spacing, UncertainValue};
    use super::super::search::search;
    use super::super::testing::{effort, free, measured, problem, said, starts};
    use super::super::{objective::Objective, text};
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    fn fitted(values: Vec<UncertainValue>, model: &dyn Fn(f64, usize) -> f64) -> IdentificationOutcome {
        let count = values.len();
        let problem = problem(vec![free("p", Spacing::Linear, -10.0, 10.0)], vec![values]);
        let model = |_: usize, p: &[f64], _: &[f64]| Ok((0..count).map(|k| model(p[0], k)).collect());
        let objective = Objective::new(&problem, &model, 1e-4);
        let (optima, progress) = search(&objective, &starts(1, 4), &effort(2, 40), &|_| ()).unwrap();
        let mut outcome = IdentificationOutcome::new(&problem, &optima, &progress);
        let curve = Group { name: "curve".into(), values: (0..count).map(|k| [0, k]).collect() };
        outcome.look_along(&[curve], &problem.estimates);
        outcome
    }

    /// Two values 3.72 standard uncertainties apart: chi-square 6.92 with one degree of freedom, p = 0.0085.
    #[test]
    fn a_misfit_of_one_in_a_hundred_is_none_of_a_right_model() {
        let outcome = fitted(measured(&[0.0, 3.72], 1.0), &|p, _| p);
        assert!((outcome.probability.unwrap() - 0.0085).abs() < 1e-4);
        assert_eq!(outcome.fit(), FitVerdict::Misses);
        let text = said(&outcome);
        assert!(text.contains("A right model would miss by this much in fewer than 1 of 100 tests"), "{text}");
        let outcome = fitted(measured(&[0.0, 2.0], 1.0), &|p, _| p);
        assert_eq!(outcome.fit(), FitVerdict::Good);
    }

    #[test]
    fn a_fit_that_was_certain_shows_nothing() {
        let outcome = fitted(measured(&[1.0], 1.0), &|p, _| p);
        assert_eq!(outcome.fit(), FitVerdict::Untested);
        let text = said(&outcome);
        assert!(text.contains("As many unknowns as measured values: a fit was certain and shows nothing."), "{text}");
    }

    #[test]
    fn a_misfit_that_is_impossibly_small_is_a_warning() {
        let words = "fits so well in fewer than 1 of 1,000 tests";
        for (size, told) in [(1e-3, true), (1.0, false)] {
            let values: Vec<f64> = (0..20).map(|k| size * f64::from(k % 2)).collect();
            let text = said(&fitted(measured(&values, 0.5), &|p, _| p));
            assert_eq!(text.contains(words), told, "{text}");
        }
    }

    /// Of many valleys each search ends in another one, and none may be the lowest.
    #[test]
    fn an_unsure_search_asks_for_starts_before_it_blames_the_model() {
        let outcome = fitted(measured(&[9.0, 9.0], 0.01), &|p, _| (7.0 * p).sin() + 0.3 * p);
        let text = said(&outcome);
        assert!(outcome.search.lowest() == 1 && outcome.search.minima.len() > 1, "{:?}", outcome.search.minima);
        let places = ["give more `starts`", "A right model would miss"].map(|words| text.find(words));
        assert!(places[0].is_some() && places[0] < places[1], "{text}");
    }

    /// A square reaches no negative number.
    #[test]
    fn what_the_model_cannot_reach_is_no_certain_fit() {
        let outcome = fitted(measured(&[-5.0], 1.0), &|p, _| p * p);
        assert_eq!(outcome.fit(), FitVerdict::Misses);
        let text = said(&outcome);
        assert!(text.starts_with("The model cannot reach the measured values"), "{text}");
    }

    /// A wave of height 1 has several crests, all of them far below 49.
    #[test]
    fn of_several_optima_that_miss_none_is_said_to_fit() {
        let outcome = fitted(measured(&[49.0], 1.0), &|p, _| p.sin());
        assert!(outcome.has_several() && !outcome.ambiguous && outcome.fit() == FitVerdict::Misses);
        let section = text::fixed_section("s.toml", 0, &outcome, &[]);
        assert!(section.contains(": all miss the measured values."), "{section}");
        let text = said(&outcome);
        assert!(text.starts_with("The model cannot reach the measured values"), "{text}");
        assert!(text.contains("None of the "), "{text}");
        assert!(!text.contains("fit the measured values"), "{text}");
    }

    /// Noise alone is in order in about 5 % of the records; a wave of its size always is, though the sum of squares is as it
    /// should be.
    #[test]
    fn waves_in_the_residuals_are_a_doubt() {
        let mut random = StdRng::seed_from_u64(3);
        let mut doubted = 0;
        for _ in 0..200 {
            let noise: Vec<f64> = (0..100).map(|_| random.sample(StandardNormal)).collect();
            let outcome = fitted(measured(&noise, 1.0), &|p, _| p);
            let order = &outcome.orders[0];
            doubted += usize::from(order.probability < DOUBTFUL);
        }
        assert!((3..=20).contains(&doubted), "{doubted}");
        let wave = |k: usize| (0.2 * k as f64).sin() + 0.7 * random.sample::<f64, _>(StandardNormal);
        let values: Vec<f64> = (0..100).map(wave).collect();
        let outcome = fitted(measured(&values, 1.0), &|p, _| p);
        assert!(outcome.probability.unwrap() > 0.05);
        assert_eq!(outcome.fit(), FitVerdict::Misses);
        let text = said(&outcome);
        assert!(text.contains("The residuals of curve are no noise"), "{text}");
        // A wave of a thousandth of the stated noise is told, and misses nothing.
        let values: Vec<f64> = (0..100).map(|k| 1e-3 * (0.2 * f64::from(k)).sin()).collect();
        let outcome = fitted(measured(&values, 1.0), &|p, _| p);
        assert_eq!(outcome.fit(), FitVerdict::Good);
        let text = said(&outcome);
        assert!(text.contains("The residuals of curve are no noise") && text.contains("fits so well"), "{text}");
    }
}
