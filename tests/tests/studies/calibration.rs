//! Recomputes both calibrations from the shipped studies: the residuals that docs/evidence/calibration.md states.

#![allow(clippy::unwrap_used)]

use calibration::local::{Limits, Minimum, minimise};
use calibration::objective::{Differences, Objective};
use fmu_export::model::{Experiment, Model};
use orchestrator::identify::bind::Bound;
use plain_bearing_stand::stand::Stand;
use stand_tests::{StandModel, file, get, package, stand};
use study::Identification;
use study::Study;
use study::judge::Judge;
use study::plan::Plan;

fn study(name: &str) -> Study {
    Study::read(&file(&format!("studies/{name}.toml"))).unwrap()
}

fn settings(study: &Study) -> Identification {
    study.identify.clone().unwrap()
}

/// The places of the free parameters at the values that a stand has.
fn places(bound: &Bound, stand: &Stand) -> Vec<f64> {
    let pairs = bound.problem.free.iter().zip(&bound.inputs);
    pairs
        .map(|(free, conversion)| {
            let value = conversion.inverse().value(get(stand, &free.name));
            let place = free.place(value);
            assert!((0.0..=1.0).contains(&place), "{} = {value} is out of bounds", free.name);
            place
        })
        .collect()
}

/// Table 3 with the constants of `paper-table3.toml`: only each row's clearance is found.
fn table3(look: impl FnOnce(&Bound, &Objective<'_>, Minimum)) {
    let package = package();
    let description = package.description();
    let calibration = study("calibration-table3");
    let bound = Bound::new(&calibration, &settings(&calibration), description).unwrap();
    let model = StandModel::new(&bound, description);
    let objective = Objective::new(&bound.problem, &model, 1e-3);
    let task = Plan::new(&study("paper-table3"), description).unwrap().cases.remove(0).task;
    let mut start = places(&bound, &stand(&task, description));
    start.resize(bound.problem.unknowns(), 0.5);
    let held: Vec<usize> = (0..bound.problem.free.len()).collect();
    let limits = Limits { iterations: 30, decrease: 1e-6 };
    let minimum = minimise(&objective, start, &held, Differences::Forward, &limits).unwrap();
    look(&bound, &objective, minimum);
}

#[test]
fn all_rows_of_table_3_are_reproduced() {
    table3(|bound, _, minimum| {
        let names: Vec<&str> = bound.problem.quantities.iter().map(|q| q.name.as_str()).collect();
        assert_eq!(names, ["F_N", "P_fr", "T_oil", "T_bearing"]);
        assert_eq!(bound.problem.cases.len(), 12);
        for (case, predicted) in bound.problem.cases.iter().zip(&minimum.misfit.predicted) {
            let misfit = |q: usize| (predicted[q] - case.measured[q].value).abs();
            let row = &case.label;
            assert!(misfit(0) < 0.3, "row {row}: F_N {}", predicted[0]);
            assert!(misfit(1) < 0.02 * case.measured[1].value, "row {row}: P_fr {}", predicted[1]);
            assert!(misfit(2) < 0.02, "row {row}: T_oil {}", predicted[2]);
            assert!(misfit(3) < 0.08, "row {row}: T_bearing {}", predicted[3]);
        }
    });
}

#[test]
fn the_verdicts_on_table_3_are_the_papers() {
    const NAMED: [&str; 10] = ["3", "11", "24", "25", "37", "40", "42", "46", "48", "49"];
    let package = package();
    let study = study("paper-table3");
    let judge = Judge::new(&study, Some(package.description())).unwrap();
    let order: Vec<&str> = judge.criteria.iter().map(|criterion| criterion.name.as_str()).collect();
    assert_eq!(order, ["T_oil", "T_bearing", "F_N", "P_fr"]);
    let is_near = |bearing: f64| (bearing - 82.0).abs() <= 0.75;
    table3(|bound, _, minimum| {
        let verdicts: Vec<(&str, bool, bool)> = bound
            .problem
            .cases
            .iter()
            .zip(&minimum.misfit.predicted)
            .map(|(case, predicted)| {
                let [force, power, oil, bearing] = predicted[..] else { panic!("four quantities") };
                let values = [oil, bearing, force, power];
                let passed = judge.verdict(Some(&values)).passed;
                let absolute = is_near(bearing) && passed[0] && passed[2] && passed[3];
                (case.label.as_str(), passed.iter().all(|passed| *passed), absolute)
            })
            .collect();
        let absolute: Vec<&str> = verdicts.iter().filter(|v| v.2).map(|v| v.0).collect();
        let printed: Vec<&str> = verdicts.iter().filter(|v| v.1).map(|v| v.0).collect();
        assert_eq!(absolute, NAMED, "within 0.75 degC");
        assert_eq!(printed, NAMED[1..], "within 0.75 %: point 3 fails");
    });
}

#[test]
fn the_shipped_constants_are_the_calibrations_optimum() {
    table3(|_, objective, minimum| {
        let limits = Limits { iterations: 4, decrease: 1e-6 };
        let before = minimum.misfit.cost();
        let after = minimise(objective, minimum.places, &[], Differences::Forward, &limits).unwrap();
        let gain = before - after.misfit.cost();
        // Rounding to four digits costs a little; a step towards anything better would gain more.
        assert!(gain < 0.01 * before, "{before} falls by {gain}");
    });
}

#[test]
fn the_rigs_start_values_are_the_measured_steady_state() {
    let package = package();
    let description = package.description();
    let calibration = study("calibration-rig");
    let bound = Bound::new(&calibration, &settings(&calibration), description).unwrap();
    let model = StandModel::new(&bound, description);
    let objective = Objective::new(&bound.problem, &model, 1e-3);
    let misfit = objective.misfit(&places(&bound, &Stand::default())).unwrap();
    let names: Vec<&str> = bound.problem.quantities.iter().map(|q| q.name.as_str()).collect();
    assert_eq!(names, ["T_oil", "T_bearing", "F_N", "M", "P_fr", "mu"]);
    // A quarter of Table 2's accuracy each; mu within the stated +-0.002.
    let allowed = [0.125, 0.154, 13.1, 0.0055, 0.75, 0.002];
    let measured = &bound.problem.cases[0].measured;
    for (((name, value), measured), allowed) in names.iter().zip(&misfit.predicted[0]).zip(measured).zip(allowed) {
        assert!((value - measured.value).abs() < allowed, "{name} = {value}");
    }
}

#[test]
fn the_rig_stays_at_its_steady_state_for_1000_seconds() {
    let mut stand = Stand::default();
    let experiment = Experiment::default();
    stand.initialise(&experiment, &mut ()).unwrap();
    for part in 0..20 {
        stand.advance(50.0 * f64::from(part), 50.0, &mut ()).unwrap();
        let readings = stand.readings();
        assert!((readings.oil_temperature - 321.15).abs() < 0.1, "{readings:?}");
        assert!((readings.bearing_temperature - 355.15).abs() < 0.1, "{readings:?}");
    }
}
