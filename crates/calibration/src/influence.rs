//! Single measured values: whether one is far off; and what a parameter's uncertainty consists of.
//!
//! Around the optimum the problem is linear. With the shared errors as unknowns, the values' errors are independent, and with
//! the rows `a` of their derivatives over their accuracies `A = sum a a' + prior` is the inverse of the covariance. A value's
//! leverage is `h = a' A^-1 a`; its residual over `sqrt(1 - h)` has variance 1 (Cook & Weisberg 1982, "Residuals and influence in
//! regression", chapter 2). The variance of an unknown is the sum over all values, shared errors and priors of what each
//! contributes: `(A^-1 a)^2` for a value.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::{
    errors::Errors,
    optima::Optimum,
    problem::{Problem, SharedKind},
};

/// Values that are measured together: those of a curve, or of a quantity in all cases.
#[derive(Clone, Debug)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// The case and the quantity of each value.
    pub values: Vec<[usize; 2]>,
}

/// The value with the largest studentised residual.
#[derive(Clone, Debug, Serialize)]
pub struct Farthest {
    /// The case.
    pub case: String,
    /// The quantity.
    pub quantity: String,
    /// The residual over its own standard deviation, which is the smaller the more the value draws the fit to itself.
    pub studentised: f64,
    /// How much the value draws the fit to itself: 0 not at all, 1 altogether.
    pub leverage: f64,
    /// The probability that the largest of all is as large by chance, at most (Bonferroni).
    pub probability: f64,
}

/// What a parameter's variance consists of.
#[derive(Serialize)]
pub struct Influence {
    /// The parameter.
    pub parameter: String,
    /// What its variance consists of, the largest part first.
    pub budget: Vec<Part>,
}

/// A part of a parameter's variance.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// Where it comes from: `noise of torque`, `a zero error of torque`, `prior`.
    pub from: String,
    /// The part of the variance.
    pub share: f64,
}

/// The linear problem at an optimum. An unknown at a bound is known.
struct Rows<'a> {
    problem: &'a Problem,
    /// The unknowns that are not at a bound, then the shared errors.
    open: Vec<usize>,
    /// The factor of `A`.
    factor: Cholesky<f64, Dyn>,
    errors: Errors,
    optimum: &'a Optimum,
}

impl<'a> Rows<'a> {
    fn new(problem: &'a Problem, optimum: &'a Optimum) -> Option<Self> {
        let errors = Errors::new(problem);
        let (full, open) = optimum.precision(&errors);
        let factor = Cholesky::new(full.select_rows(&open).select_columns(&open))?;
        Some(Self { problem, open, factor, errors, optimum })
    }

    /// `A^-1 a` of a value with its leverage.
    fn pull(&self, case: usize, quantity: usize) -> (DVector<f64>, f64) {
        let n = self.problem.unknowns();
        let value = case * self.problem.quantities.len() + quantity;
        let slopes = self.optimum.posterior.slopes[0].row(value);
        let effects = self.errors.effects(case, quantity);
        let row = DVector::from_iterator(
            self.open.len(),
            self.open.iter().map(|&k| if k < n { slopes[k] } else { effects[k - n] }),
        );
        let pull = self.factor.solve(&row);
        let leverage = pull.dot(&row).clamp(0.0, 1.0);
        (pull, leverage)
    }

    /// A value's residual as a normal number, in accuracies.
    fn residual(&self, case: usize, quantity: usize) -> f64 {
        let problem = self.problem;
        let residual = self.optimum.minimum.misfit.residuals[case * problem.quantities.len() + quantity];
        problem
            .not_normal
            .iter()
            .find(|value| (value.case, value.quantity) == (case, quantity))
            .map_or(residual, |value| value.law.score(residual * problem.cases[case].measured[quantity].accuracy))
    }

    /// The probability of a residual as large, of one value.
    fn chance(&self, studentised: f64, quantity: usize) -> f64 {
        let estimate = self.problem.estimates.iter().find(|estimate| estimate.quantities.contains(&quantity));
        let freedom = estimate.map_or(f64::INFINITY, |estimate| estimate.freedom);
        let tail = match StudentsT::new(0.0, 1.0, freedom) {
            Ok(law) if freedom.is_finite() => law.sf(studentised.abs()),
            _ => Normal::standard().sf(studentised.abs()),
        };
        2.0 * tail
    }
}

/// Looks at single values at an optimum; `groups` are those that have their noise from one sensor.
pub fn of_values(problem: &Problem, optimum: &Optimum, groups: &[Group]) -> (Option<Farthest>, Vec<Influence>) {
    /// Of a value that the fit goes through, whatever it is, the residual tells nothing.
    const THROUGH: f64 = 1.0 - 1e-6;
    let Some(rows) = Rows::new(problem, optimum) else { return (None, Vec::new()) };
    let all: Vec<_> = (0..problem.cases.len())
        .flat_map(|case| (0..problem.quantities.len()).map(move |q| (case, q)))
        .map(|(case, quantity)| (case, quantity, rows.pull(case, quantity)))
        .collect();
    let named =
        |case: usize, quantity: usize| (problem.cases[case].label.clone(), problem.quantities[quantity].name.clone());
    let studentised =
        all.iter().filter(|(.., (_, leverage))| *leverage < THROUGH).map(|(case, quantity, (_, leverage))| {
            let studentised = rows.residual(*case, *quantity) / (1.0 - leverage).sqrt();
            (rows.chance(studentised, *quantity), *case, *quantity, studentised, *leverage)
        });
    let count = all.len() as f64;
    let farthest =
        studentised.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(chance, number, quantity, studentised, leverage)| {
            let (case, quantity) = named(number, quantity);
            Farthest { case, quantity, studentised, leverage, probability: (count * chance).min(1.0) }
        });
    let covariance = rows.factor.inverse();
    let influence = (0..problem.free.len())
        .filter_map(|k| Some((k, rows.open.iter().position(|&open| open == k)?)))
        .map(|(k, place)| {
            let budget = budget(&rows, &covariance, place, (groups, &all));
            Influence { parameter: problem.free[k].name.clone(), budget }
        })
        .collect();
    (farthest, influence)
}

/// Each measured value with its pull and its leverage.
type Pulls = [(usize, usize, (DVector<f64>, f64))];

/// What the variance of an unknown consists of.
fn budget(rows: &Rows, covariance: &DMatrix<f64>, place: usize, (groups, all): (&[Group], &Pulls)) -> Vec<Part> {
    let (problem, variance) = (rows.problem, covariance[(place, place)]);
    let own = groups.iter().flat_map(|group| {
        let own = all.iter().filter(|(case, quantity, _)| group.values.contains(&[*case, *quantity]));
        let sums = own.fold([0.0; 3], |sums, (case, quantity, (pull, _))| {
            let mixed = problem.mixed.iter().find(|value| (value.case, value.quantity) == (*case, *quantity));
            let [zero, gain] = mixed.map_or([0.0; 2], |value| value.parts);
            let parts = [1.0 - zero - gain, zero, gain];
            std::array::from_fn(|k| sums[k] + parts[k] * pull[place].powi(2))
        });
        let words = ["noise", SharedKind::Offset.words(), SharedKind::Gain.words()];
        words.into_iter().zip(sums).map(|(words, sum)| (format!("{words} of {}", group.name), sum))
    });
    let n = problem.unknowns();
    let mut parts: Vec<(String, f64)> = own.filter(|(_, sum)| *sum > 0.0).collect();
    for source in 0..problem.sources.len() {
        let mut channels = problem.channels.iter();
        let channel = channels.find(|channel| channel.sources.iter().any(|(number, _)| *number == source));
        let from = channel.map_or_else(
            || "errors that values share".to_owned(),
            |channel| format!("{} of {}", channel.kind.words(), channel.name),
        );
        let behind = rows.open.iter().position(|&open| open == n + source);
        // Before the measurement it had the variance 1.
        let part = behind.map_or(0.0, |behind| covariance[(place, behind)].powi(2));
        match parts.iter_mut().find(|(name, _)| *name == from) {
            Some((_, sum)) => *sum += part,
            None => parts.push((from, part)),
        }
    }
    // What is left of the sum is that of the priors.
    let told: f64 = parts.iter().map(|(_, part)| part).sum();
    parts.push(("what was known before".to_owned(), (variance - told).max(0.0)));
    let mut parts: Vec<Part> = parts.into_iter().map(|(from, part)| Part { from, share: part / variance }).collect();
    parts.sort_by(|a, b| b.share.total_cmp(&a.share));
    parts
}

#[cfg(test)]
mod tests {
    use super::super::fit::FitVerdict;
    use super::super::objective::Objective;
    use super::super::outcome::IdentificationOutcome;
    use super::super::problem::{Channel, Effect, Mixed, Source, Spacing, UncertainValue};
    use super::super::search::search;
    use super::super::testing::{effort, free, problem, said, starts};
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    const TIMES: [f64; 12] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0];

    /// A line through values with the standard uncertainty 1, with or without an offset that all share.
    fn line(values: &[f64], offset: f64) -> IdentificationOutcome {
        let rows = values.iter().map(|&value| UncertainValue { value, accuracy: 1.0 }).collect();
        let unknown = vec![free("a", Spacing::Linear, -100.0, 100.0), free("b", Spacing::Linear, -100.0, 100.0)];
        let mut problem = problem(unknown, vec![rows]);
        if offset > 0.0 {
            let effect = |quantity| Effect { case: 0, quantity, change: offset, part: None };
            problem.sources = vec![Source { effects: (0..values.len()).map(effect).collect(), rectangular: false }];
            problem.channels = vec![Channel {
                name: "y".to_owned(),
                kind: SharedKind::Offset,
                unit: None,
                limit: 2.0 * offset,
                sources: vec![(0, offset)],
            }];
        }
        let model = |_: usize, p: &[f64], _: &[f64]| {
            Ok(TIMES.iter().take(values.len()).map(|t| p[0] + p[1] * t).collect::<Vec<f64>>())
        };
        let objective = Objective::new(&problem, &model, 1e-4);
        let (optima, progress) = search(&objective, &starts(2, 4), &effort(2, 40), &|_| ()).unwrap();
        let mut outcome = IdentificationOutcome::new(&problem, &optima, &progress);
        let group = Group { name: "y".to_owned(), values: (0..values.len()).map(|k| [0, k]).collect() };
        (outcome.farthest, outcome.influence) = of_values(&problem, &optima[0], std::slice::from_ref(&group));
        outcome.look_along(&[group], &problem.estimates);
        outcome
    }

    fn noise(random: &mut StdRng) -> Vec<f64> {
        TIMES.iter().map(|t| 1.0 + 0.5 * t + random.sample::<f64, _>(StandardNormal)).collect()
    }

    /// numpy: leverage and studentised residual of the first of twelve values 5 off, and how far the line's ends move without it.
    #[test]
    fn a_value_that_is_off_is_told_with_its_leverage() {
        let mut values: Vec<f64> = TIMES.iter().map(|t| 1.0 + 0.5 * t).collect();
        values[0] += 5.0;
        let outcome = line(&values, 0.0);
        let told = outcome.farthest.as_ref().unwrap();
        assert_eq!(told.quantity, "y0");
        assert!((told.leverage - 0.294_872).abs() < 1e-4, "{told:?}");
        assert!((told.studentised + 5.0 * (1.0_f64 - 0.294_872).sqrt()).abs() < 1e-3, "{told:?}");
        assert_eq!(outcome.fit(), FitVerdict::Misses);
        let text = said(&outcome);
        assert!(text.contains("y0") && text.contains("nothing was left out"), "{text}");
    }

    /// An offset of u = 2 that all values share is nearly all of the line's height. numpy, by another way than the program's: with
    /// C = 1 + u^2 of all pairs and the precision L = 12 / 200^2 of the bounds, P = (J' C^-1 J + L)^-1 and K = P J' C^-1, the
    /// variances are those of K K', u^2 (K 1)^2 and P L P.
    #[test]
    fn the_budget_adds_up_and_names_its_sources() {
        let values: Vec<f64> = TIMES.iter().map(|t| 1.0 + 0.5 * t).collect();
        let outcome = line(&values, 2.0);
        let expected = [[0.068_568_17, 0.930_144_92, 0.001_286_91], [0.999_934_52, 0.000_000_08, 0.000_065_40]];
        for (influence, expected) in outcome.influence.iter().zip(expected) {
            let budget = &influence.budget;
            let sources = ["noise of y", "a zero error of y", "what was known before"];
            for (from, expected) in sources.into_iter().zip(expected) {
                let share = budget.iter().find(|part| part.from == from).unwrap().share;
                assert!((share - expected).abs() < 1e-4, "{from}: {share}, expected {expected}");
            }
            assert!((budget.iter().map(|part| part.share).sum::<f64>() - 1.0).abs() < 1e-9, "{budget:?}");
        }
    }

    /// A value whose own error has a zero error of 0.3, a gain error of 0.2 and noise of 0.4, all but for what the bounds tell.
    #[test]
    fn the_error_of_a_single_value_is_told_by_its_parts() {
        let square: f64 = 0.09 + 0.04 + 0.16;
        let row = vec![UncertainValue { value: 1.0, accuracy: square.sqrt() }];
        let mut problem = problem(vec![free("a", Spacing::Linear, -100.0, 100.0)], vec![row]);
        problem.mixed = vec![Mixed { case: 0, quantity: 0, parts: [0.09 / square, 0.04 / square] }];
        let model = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0]]);
        let objective = Objective::new(&problem, &model, 1e-4);
        let (optima, _) = search(&objective, &starts(1, 4), &effort(2, 40), &|_| ()).unwrap();
        let group = Group { name: "y".to_owned(), values: vec![[0, 0]] };
        let (_, influence) = of_values(&problem, &optima[0], &[group]);
        let told: Vec<&str> = influence[0].budget.iter().map(|part| &*part.from).collect();
        assert_eq!(told, ["noise of y", "a zero error of y", "a gain error of y", "what was known before"]);
        for (part, own) in influence[0].budget.iter().zip([0.16, 0.09, 0.04]) {
            assert!((part.share - own / square).abs() < 1e-4, "{part:?}");
        }
    }

    fn found(place: usize, records: u64) -> u64 {
        let mut random = StdRng::seed_from_u64(11 + place as u64);
        let told = (0..records).filter(|_| {
            let mut values = noise(&mut random);
            values[place] += 5.0;
            let outcome = line(&values, 0.0);
            let farthest = outcome.farthest.as_ref().unwrap();
            outcome.is_farthest_doubtful() && farthest.quantity == format!("y{place}")
        });
        told.count() as u64
    }

    #[test]
    fn an_outlier_at_an_edge_is_told() {
        assert!(found(0, 40) >= 30);
    }

    #[test]
    #[ignore = "takes a minute; run by scripts/test --long"]
    fn an_outlier_is_told_wherever_it_is() {
        let all: Vec<u64> = (0..12).map(|place| found(place, 200)).collect();
        println!("{all:?} of 200");
        assert!(all.iter().all(|&found| found >= 150), "{all:?}");
    }

    /// Of 200 right records, few are doubted for any reason.
    #[test]
    fn clean_records_are_hardly_ever_doubted() {
        let mut random = StdRng::seed_from_u64(5);
        let doubted = (0..200).filter(|_| line(&noise(&mut random), 0.0).fit() != FitVerdict::Good).count();
        println!("{doubted} of 200 clean records doubted");
        assert!(doubted <= 10, "{doubted}");
    }
}
