//! Known parameters are recovered from synthetic measurements, within the stated uncertainty.

use std::cell::{Cell, RefCell};

use statrs::distribution::{ContinuousCDF, Normal};

use super::{
    local::Minimum,
    objective::Objective,
    optima::Optimum,
    posterior::{Direction, Posterior, UNDETERMINED},
    problem::{Case, Interval, NoPrediction, Prediction, Problem, Query, Simulate, Spacing, UncertainValue},
    search::{SearchError, search},
    testing::{effort, free, named, starts},
};

/// Independent standard normal numbers by the splitmix64 sequence (Steele, Lea, Flood 2014).
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) as f64 + 0.5) / 2.0_f64.powi(64)
    }

    fn normal(&mut self) -> f64 {
        Normal::standard().inverse_cdf(self.uniform())
    }
}

/// A journal bearing in miniature: the friction of a film that warms itself, over a clearance that
/// each case knows to an interval only.
fn bearing(case: usize, p: &[f64], latent: &[f64]) -> Result<Vec<f64>, String> {
    let [scale, conductance, thinning] = [p[0], p[1], p[2]];
    let speed = 1.0 + 0.2 * case as f64;
    let clearance = latent[0];
    // Heat balance of the film by fixed-point iteration.
    let mut rise = 0.0;
    for _ in 0..60 {
        let heat = scale * speed * speed / clearance * (-thinning * rise).exp();
        rise = 0.5 * (rise + heat / conductance);
    }
    let heat = rise * conductance;
    Ok(vec![heat, rise, 1000.0 * clearance * speed])
}

const TRUTH: [f64; 3] = [4.0, 2.0, 0.08];
const ACCURACY: [f64; 3] = [0.05, 0.03, 30.0];

fn synthetic(seed: u64) -> (Problem, Vec<f64>) {
    let mut noise = Noise(seed);
    let mut problem = Problem {
        free: vec![
            free("scale", Spacing::Log, 0.1, 100.0),
            free("conductance", Spacing::Log, 0.1, 100.0),
            free("thinning", Spacing::Linear, 0.0, 0.3),
        ],
        latents: vec![named("clearance")],
        quantities: ["heat", "rise", "gap"].map(named).to_vec(),
        ..Problem::default()
    };
    for case in 0..8 {
        let clearance = 0.5 + noise.uniform();
        let printed = (clearance / 0.2).round() * 0.2;
        let exact = bearing(case, &TRUTH, &[clearance]).expect("it never fails");
        let measured = exact
            .iter()
            .zip(ACCURACY)
            .map(|(value, accuracy)| UncertainValue { value: value + accuracy * noise.normal(), accuracy });
        problem.cases.push(Case {
            label: case.to_string(),
            latents: vec![Interval { min: printed - 0.1, max: printed + 0.1 }],
            measured: measured.collect(),
        });
    }
    let truth = problem.free.iter().zip(TRUTH).map(|(free, value)| free.place(value)).collect();
    (problem, truth)
}

fn identify(objective: &Objective) -> (Minimum, Posterior) {
    let starts = starts(objective.problem.free.len(), 32);
    let (mut optima, _) = search(objective, &starts, &effort(4, 60), &|_| ()).unwrap();
    assert_eq!(optima.len(), 1, "there is one minimum");
    let only = optima.remove(0);
    (only.minimum, only.posterior)
}

/// The directions of which the data tell little.
fn undetermined(posterior: &Posterior) -> Vec<&Direction> {
    let directions = posterior.directions.iter();
    directions.filter(|direction| direction.left > UNDETERMINED).collect()
}

#[test]
fn known_parameters_are_recovered_within_the_stated_uncertainty() {
    let mut pulls = Vec::new();
    for seed in 0..20 {
        let (problem, truth) = synthetic(1000 + seed);
        let objective = Objective::new(&problem, &bearing, 1e-4);
        let (minimum, posterior) = identify(&objective);
        for (index, truth) in truth.iter().enumerate() {
            pulls.push((minimum.places[index] - truth) / posterior.deviation(index));
        }
        assert!(undetermined(&posterior).is_empty(), "seed {seed}");
    }
    // Sixty pulls: none beyond 3.5 standard deviations, and their mean square near one (too small a
    // value would mean that the stated uncertainty is too large).
    let mean_square = pulls.iter().map(|pull| pull * pull).sum::<f64>() / pulls.len() as f64;
    assert!(pulls.iter().all(|pull| pull.abs() < 3.5), "{pulls:?}");
    assert!((0.5..1.7).contains(&mean_square), "{mean_square}: {pulls:?}");
}

#[test]
fn two_parameters_that_only_act_together_are_reported() {
    let (mut problem, _) = synthetic(5);
    // The film's scale is split into viscosity times area: nothing measured can tell them apart.
    problem.free.push(free("area", Spacing::Log, 0.1, 10.0));
    let split = |case: usize, p: &[f64], latent: &[f64]| bearing(case, &[p[0] * p[3], p[1], p[2]], latent);
    let objective = Objective::new(&problem, &split, 1e-4);
    let (_, posterior) = identify(&objective);
    let undetermined = undetermined(&posterior);
    assert_eq!(undetermined.len(), 1, "{undetermined:?}");
    let weights = &undetermined[0].weights;
    assert!(undetermined[0].left > 0.95);
    assert!(weights[0] * weights[3] < 0.0, "one rises as the other falls: {weights:?}");
    assert!(weights[1].abs() < 0.2 && weights[2].abs() < 0.2, "{weights:?}");
    assert!(posterior.correlation(0, 3) < -0.98);
}

#[test]
fn a_parameter_without_effect_is_reported() {
    let (mut problem, _) = synthetic(6);
    problem.free.push(free("idle", Spacing::Linear, 0.0, 1.0));
    let objective = Objective::new(&problem, &bearing, 1e-4);
    let (_, posterior) = identify(&objective);
    let undetermined = undetermined(&posterior);
    assert_eq!(undetermined.len(), 1);
    assert!(undetermined[0].weights[3] > 0.999, "{undetermined:?}");
}

/// A model that stops after a number of predictions, and has those of an earlier search at hand.
struct Remembering<'a> {
    known: &'a RefCell<Vec<(Query, Prediction)>>,
    asked: Cell<usize>,
    left: Cell<usize>,
}

impl Simulate for Remembering<'_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let mut known = self.known.borrow_mut();
        let mut answers = Vec::new();
        for query in queries {
            let place = self.asked.replace(self.asked.get() + 1);
            if place == known.len() {
                let left = self.left.get().checked_sub(1);
                self.left.set(left.ok_or(NoPrediction::Stopped)?);
                let prediction = bearing(query.case, &query.free, &query.latents);
                known.push((query.clone(), prediction));
            }
            let (then, prediction) = &known[place];
            assert_eq!(then, query, "another search asks for other points");
            answers.push(prediction.clone());
        }
        Ok(answers)
    }
}

#[test]
fn a_search_asks_for_the_same_points_again_and_goes_on_where_it_stopped() {
    let (problem, _) = synthetic(7);
    let settings = effort(3, 60);
    let starts = starts(3, 8);
    let objective = Objective::new(&problem, &bearing, 1e-4);
    let (whole, _) = search(&objective, &starts, &settings, &|_| ()).unwrap();
    let known = RefCell::default();
    let mut stops = 0;
    let resumed = loop {
        let model = Remembering { known: &known, asked: Cell::new(0), left: Cell::new(150) };
        let objective = Objective::new(&problem, &model, 1e-4);
        match search(&objective, &starts, &settings, &|_| ()) {
            Ok((optima, _)) => break optima,
            Err(SearchError::Stopped) => stops += 1,
            Err(error) => panic!("{error}"),
        }
    };
    assert!(stops > 2, "{stops}");
    let places =
        |optima: &[Optimum]| -> Vec<Vec<f64>> { optima.iter().map(|optimum| optimum.minimum.places.clone()).collect() };
    assert_eq!(places(&whole), places(&resumed));
}
