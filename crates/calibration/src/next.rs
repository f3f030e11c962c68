//! The measurement that would narrow a parameter most.
//!
//! Around the most probable values the posterior is nearly normal, and another measurement adds its squares to the curvature,
//! whatever value it shows: `C = (H + J'J)^-1` with the derivatives `J` of the values that are measured again, over their accuracies
//! (Chaloner & Verdinelli 1995, Bayesian Experimental Design: A Review, Statistical Science 10, section 2). Shared errors are
//! unknowns with a prior here: a repetition with the same sensor has the same ones.

use nalgebra::{Cholesky, DMatrix};
use serde::Serialize;

use super::{
    digits::{rounded, shown},
    errors::Errors,
    optima::Optimum,
    problem::{Problem, Spacing},
    sample::Sample,
};

/// A calibration leaves this part of a shared error's uncertainty.
const CALIBRATED: f64 = 0.1;

/// A measurement that narrows less is not worth a line.
const WORTH: f64 = 0.98;

/// Where no measurement is worth a line.
pub const NOTHING: &str =
    "Repeating or calibrating what was measured gains less than 2 %: measure another quantity or operating point.";

/// Lines for people.
const SHOWN: usize = 5;

/// Values that are measured together: those of a curve, or of a quantity in all cases.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// The case and the quantity of each value.
    pub values: Vec<[usize; 2]>,
}

/// What would narrow the parameters.
#[derive(Clone, Debug, Serialize)]
pub struct NextOutcome {
    /// The parameter by which the measurements are ranked.
    pub parameter: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// How it is measured out.
    pub scale: Spacing,
    /// Its standard deviation now: a difference, or on a logarithmic scale a factor.
    pub deviation: f64,
    /// The measurements, the best first.
    pub measurements: Vec<Measurement>,
}

/// A measurement and what it would leave.
#[derive(Clone, Debug, Serialize)]
pub struct Measurement {
    /// The work to do.
    pub work: String,
    /// The standard deviation that is expected of the parameter then.
    pub deviation: f64,
    /// The part of its standard deviation that would be left, of each free parameter in their order.
    pub left: Vec<f64>,
}

impl NextOutcome {
    /// What would narrow the parameter with this number, at an optimum. What is known now comes from a sample of the posterior
    /// where there is one.
    pub fn new(
        problem: &Problem,
        (optimum, sample): (&Optimum, Option<&Sample>),
        groups: &[Group],
        parameter: usize,
    ) -> Self {
        let posterior = &optimum.posterior;
        let (precision, now) = sample
            .map(|sample| covariance(sample, problem.unknowns()))
            .and_then(|covariance| Some((Cholesky::new(covariance.clone())?.inverse(), covariance)))
            .unwrap_or_else(|| (posterior.precision.clone(), posterior.covariance.clone()));
        let deviation = |unknown: usize| now[(unknown, unknown)].sqrt();
        let errors = Errors::new(problem);
        let [slopes, along] = &posterior.slopes;
        let (n, sources) = (problem.unknowns(), errors.sources());
        let full = errors.with_sources(&precision, along);
        let free = &problem.free[parameter];
        let measurement = |work, more: DMatrix<f64>| {
            let covariance = Cholesky::new(&full + more)?.inverse();
            let left = (0..problem.free.len()).map(|k| covariance[(k, k)].sqrt() / deviation(k)).collect::<Vec<f64>>();
            Some(Measurement { work, deviation: free.spread(deviation(parameter) * left[parameter]), left })
        };
        let again = groups.iter().filter_map(|group| {
            let mut rows = DMatrix::zeros(group.values.len(), n + sources);
            for (mut row, &[case, quantity]) in rows.row_iter_mut().zip(&group.values) {
                let value = case * problem.quantities.len() + quantity;
                row.columns_mut(0, n).copy_from(&slopes.row(value));
                let effects = errors.effects(case, quantity).transpose();
                row.columns_mut(n, sources).copy_from(&effects);
            }
            measurement(format!("measure {} again", group.name), rows.tr_mul(&rows))
        });
        let calibrated = problem.channels.iter().filter_map(|channel| {
            let mut more = DMatrix::zeros(n + sources, n + sources);
            for &(source, _) in &channel.sources {
                more[(n + source, n + source)] = CALIBRATED.powi(-2) - 1.0;
            }
            let limit = rounded(100.0 * CALIBRATED, 2);
            measurement(
                format!("calibrate {}: {} to {limit} % of its stated limits", channel.name, channel.kind.words()),
                more,
            )
        });
        let mut measurements: Vec<Measurement> = again.chain(calibrated).collect();
        measurements.sort_by(|a, b| a.left[parameter].total_cmp(&b.left[parameter]));
        Self {
            parameter: free.name.clone(),
            unit: free.unit.clone(),
            scale: free.scale,
            deviation: free.spread(deviation(parameter)),
            measurements,
        }
    }

    /// The measurements that narrow the parameter noticeably.
    pub fn worthwhile(&self) -> impl Iterator<Item = &Measurement> {
        self.measurements
            .iter()
            .filter(|measurement| match self.scale {
                Spacing::Linear => measurement.deviation < WORTH * self.deviation,
                Spacing::Log => measurement.deviation.ln() < WORTH * self.deviation.ln(),
            })
            .take(SHOWN)
    }

    /// A standard deviation for people.
    pub fn words(&self, deviation: f64) -> String {
        match self.scale {
            Spacing::Linear => format!("{} {}", rounded(deviation, 2), shown(&self.unit)).trim_end().to_owned(),
            Spacing::Log => format!("{} %", rounded(100.0 * (deviation - 1.0), 2)),
        }
    }
}

/// The covariance of the first unknowns' places in a sample.
fn covariance(sample: &Sample, unknowns: usize) -> DMatrix<f64> {
    let count = sample.particles.len() as f64;
    let columns: Vec<Vec<f64>> = (0..unknowns)
        .map(|unknown| {
            let places: Vec<f64> = sample.particles.iter().map(|particle| particle.places[unknown]).collect();
            let mean = places.iter().sum::<f64>() / count;
            places.into_iter().map(|place| place - mean).collect::<Vec<f64>>()
        })
        .collect();
    DMatrix::from_fn(unknowns, unknowns, |a, b| {
        let products = columns[a].iter().zip(&columns[b]).map(|(a, b)| a * b);
        products.sum::<f64>() / (count - 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::super::local::minimise;
    use super::super::objective::{Differences, Objective};
    use super::super::problem::{Channel, Effect, SharedKind, Source};
    use super::super::testing::{limits, one_case};
    use super::*;
    use nalgebra::DVector;

    /// A straight line through four values, of which three share a zero error: against the generalised least squares of the data with
    /// what is measured again in addition, whose covariance is written out.
    #[test]
    fn the_expected_deviation_is_that_of_all_data_together() {
        let accuracies = [0.1, 0.2, 0.1, 0.3];
        let design = [[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [0.0, 1.0]];
        let offset = [0.5, 0.5, 0.5, 0.0];
        let values: Vec<(f64, f64)> = accuracies.iter().map(|&a| (1.0, a)).collect();
        let mut problem = one_case(&[(-20.0, 20.0), (-20.0, 20.0)], &values);
        let effect = |quantity| Effect { part: None, case: 0, quantity, change: 0.5 };
        problem.sources.push(Source { effects: (0..3).map(effect).collect(), rectangular: false });
        problem.channels.push(Channel {
            name: "y".into(),
            kind: SharedKind::Offset,
            unit: None,
            limit: 1.0,
            sources: vec![(0, 0.5)],
        });
        let model =
            move |_: usize, p: &[f64], _: &[f64]| Ok(design.iter().map(|row| row[0] * p[0] + row[1] * p[1]).collect());
        let objective = Objective::new(&problem, &model, 1e-3);
        let start = vec![0.5, 0.5];
        let minimum = minimise(&objective, start, &[], Differences::Central, &limits(50, 1e-12)).unwrap();
        let mut optimum = Optimum::new(&objective, minimum, 1).unwrap();
        optimum.weight = 1.0;
        let group = |name: &str, values: &[usize]| Group {
            name: name.into(),
            values: values.iter().map(|&k| [0, k]).collect(),
        };
        let groups = [group("a", &[0, 1]), group("d", &[3])];
        let next = NextOutcome::new(&problem, (&optimum, None), &groups, 1);
        // Rows of the data, and by how much the zero error counts.
        let expected = |rows: &[usize], offset_part: f64| {
            let n = rows.len();
            let x = DMatrix::from_fn(n, 2, |i, j| 40.0 * design[rows[i]][j]);
            let o = DVector::from_fn(n, |i, _| offset_part * offset[rows[i]]);
            let noise = DVector::from_fn(n, |i, _| accuracies[rows[i]].powi(2));
            let covariance = DMatrix::from_diagonal(&noise) + &o * o.transpose();
            let information = x.tr_mul(&(covariance.try_inverse().unwrap() * &x));
            let prior = DMatrix::from_diagonal_element(2, 2, 12.0);
            40.0 * (information + prior).try_inverse().unwrap()[(1, 1)].sqrt()
        };
        assert!((next.deviation / expected(&[0, 1, 2, 3], 1.0) - 1.0).abs() < 1e-6);
        let of = |work: &str| {
            let mut all = next.measurements.iter();
            all.find(|m| m.work.contains(work)).unwrap().deviation
        };
        for (work, rows, part) in [
            ("measure a", &[0, 1, 2, 3, 0, 1][..], 1.0),
            ("measure d", &[0, 1, 2, 3, 3], 1.0),
            ("calibrate y", &[0, 1, 2, 3], 0.1),
        ] {
            let ratio = of(work) / expected(rows, part);
            assert!((ratio - 1.0).abs() < 1e-6, "{work}: {ratio}");
        }
        let order = next.measurements.windows(2);
        assert!(order.into_iter().all(|w| w[0].deviation <= w[1].deviation));
    }

    /// A value y = p^3 / 3 of a parameter from 0 to 2 that is measured as 0: at the optimum the model does not hang on p, so only
    /// the bounds seem to say something of it; the sample knows that p is small.
    #[test]
    fn what_is_known_now_is_what_the_sample_says() {
        let problem = one_case(&[(0.0, 2.0)], &[(0.0, 0.01)]);
        let model = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0].powi(3) / 3.0]);
        let objective = Objective::new(&problem, &model, 1e-3);
        let minimum = minimise(&objective, vec![0.5], &[], Differences::Central, &limits(200, 1e-12)).unwrap();
        let optimum = Optimum::new(&objective, minimum, 1).unwrap();
        let settings = super::super::testing::settings(2000, 3);
        let sample =
            super::super::sample::sample(&objective, std::slice::from_ref(&optimum), &settings, &|_, _| ()).unwrap();
        let groups = [Group { name: "y".into(), values: vec![[0, 0]] }];
        let of = |sample| NextOutcome::new(&problem, (&optimum, sample), &groups, 0).deviation;
        // By quadrature of exp(-(p^3 / 0.03)^2 / 2).
        let expected = 0.10275;
        assert!(of(None) > 1.5 * expected, "{}", of(None));
        let got = of(Some(&sample));
        assert!((got / expected - 1.0).abs() < 0.1, "{got}");
    }
}
