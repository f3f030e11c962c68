//! Faults planted one at a time in the records of a decay.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::StandardNormal;

use super::super::{
    fit::FitVerdict,
    influence::Group,
    problem::{Channel, Effect, Prior, SharedKind, Source, Spacing, UncertainValue},
    rounds::{Searched, Task, searched},
    testing::{effort, free, problem, starts},
};
use super::*;

const ROWS: usize = 40;

/// Two sensors on a mass on a spring that is released: its place and its force, by stiffness, damping and mass.
fn model(p: &[f64]) -> Vec<f64> {
    let (stiffness, damping, mass, start) = (p[0], p[1], p[2], p.get(3).copied().unwrap_or(1.0));
    let decay = damping / (2.0 * mass);
    let swing = (stiffness / mass - decay * decay).max(1e-9).sqrt();
    let place = |k: usize| {
        let t = 0.1 * k as f64;
        start * (-decay * t).exp() * ((swing * t).cos() + decay / swing * (swing * t).sin())
    };
    (0..ROWS).map(place).chain((0..ROWS).map(|k| stiffness * place(k) + 3.0)).collect()
}

/// How a record differs from the model's.
#[derive(Clone, Copy)]
enum Planted {
    Nothing,
    Parameter(usize, f64),
    Offset(f64),
    Gain(f64),
    Delay(f64),
    Sign,
    Thousand,
    Start(f64),
    Structure,
}

fn record(planted: Planted, seed: u64) -> (Vec<Suspect>, FitVerdict) {
    let mut random = StdRng::seed_from_u64(seed);
    let mut truth = [4.0, 0.4, 1.0, 1.0];
    for (k, width) in [(0, 0.1), (1, 0.1), (2, 0.02)] {
        truth[k] *= 1.0 + 0.5 * width * random.random_range(-1.0..1.0);
    }
    match planted {
        Planted::Parameter(k, part) => truth[k] *= 1.0 + part,
        Planted::Start(part) => truth[3] *= 1.0 + part,
        _ => {}
    }
    let accuracy = |k: usize| if k < ROWS { 0.01 } else { 0.04 };
    let mut values = model(&truth);
    if let Planted::Delay(late) = planted {
        for k in (1..ROWS).rev() {
            values[k] -= late * (values[k] - values[k - 1]) / 0.1;
        }
    }
    for (k, value) in values.iter_mut().enumerate() {
        if k < ROWS {
            match planted {
                Planted::Gain(part) => *value *= 1.0 + part,
                Planted::Sign => *value = -*value,
                Planted::Thousand => *value *= 1e3,
                Planted::Structure => *value += 0.2 * (k as f64 * 1.7).sin(),
                _ => {}
            }
        }
        *value += accuracy(k) * random.sample::<f64, _>(StandardNormal);
        if let (Planted::Offset(size), true) = (planted, k >= ROWS) {
            *value += size;
        }
    }
    let measured = values.iter().enumerate().map(|(k, &value)| UncertainValue { value, accuracy: accuracy(k) });
    let unknown = [("stiffness", 4.0, 0.1), ("damping", 0.4, 0.1), ("mass", 1.0, 0.02)];
    let unknown = unknown.map(|(name, at, part)| free(name, Spacing::Linear, at * (1.0 - part), at * (1.0 + part)));
    let mut problem = problem(unknown.to_vec(), vec![measured.collect()]);
    for (name, rows, limit) in [("place", 0..ROWS, 0.01), ("force", ROWS..2 * ROWS, 0.04)] {
        let effect = |quantity| Effect { case: 0, quantity, change: 0.5 * limit, part: None };
        problem.channels.push(Channel {
            name: name.to_owned(),
            kind: SharedKind::Offset,
            unit: None,
            limit,
            sources: vec![(problem.sources.len(), 0.5 * limit)],
        });
        problem.sources.push(Source { effects: rows.map(effect).collect(), rectangular: false });
    }
    let simulate = |_: usize, p: &[f64], _: &[f64]| Ok(model(p));
    let starts = starts(3, 16);
    let task = Task { problem: &problem, difference: 1e-4, starts: &starts, effort: effort(3, 40) };
    let Searched { problem, optima, progress } = searched(&task, &simulate, &|_| ()).unwrap();
    let mut outcome = super::super::outcome::IdentificationOutcome::new(&problem, &optima, &progress);
    let times: Vec<f64> = (0..ROWS).map(|k| 0.1 * k as f64).collect();
    let sensor = |name: &str, from: usize| Sensor {
        group: Group { name: name.to_owned(), values: (from..from + ROWS).map(|k| [0, k]).collect() },
        criteria: vec![name.to_owned()],
        unit: None,
        times: vec![times.clone()],
        confusions: [(-1.0, "sign"), (1e3, "milli"), (1e-3, "kilo")]
            .map(|(factor, words)| Confusion { factor, offset: 0.0, rows: 0, words: words.to_owned() })
            .to_vec(),
    };
    let sensors = [sensor("place", 0), sensor("force", ROWS)];
    outcome.look_along(&sensors.clone().map(|sensor| sensor.group), &problem.estimates);
    let values = |start: f64| {
        let mut values = problem.free_values(&optima[0].minimum.places);
        values.push(start);
        values
    };
    let inquiry = Inquiry {
        problem: &problem,
        difference: 1e-4,
        starts: &starts,
        optimum: &optima[0],
        model: &simulate,
        sensors: &sensors,
        reach: &[[0.0, f64::INFINITY]; 3],
        constants: &[Constant {
            fault: Suspicion::Constant,
            usual: 0.05,
            free: free("start", Spacing::Linear, 0.5, 1.5),
            value: 1.0,
            moved: (1.02, vec![model(&values(1.02))]),
            model: Box::new(simulate),
        }],
    };
    let suspects = if outcome.fit() == FitVerdict::Misses { inquiry.suspects().unwrap() } else { Vec::new() };
    (suspects, outcome.fit())
}

/// The planted fault is named first.
#[test]
fn the_culprit_is_named_first() {
    let cases = [
        (Planted::Parameter(0, 0.3), Suspicion::Range, "stiffness"),
        (Planted::Parameter(1, 0.4), Suspicion::Range, "damping"),
        (Planted::Parameter(2, 0.13), Suspicion::Range, "mass"),
        (Planted::Offset(0.3), Suspicion::Offset, "force"),
        (Planted::Gain(0.1), Suspicion::Gain, "place"),
        (Planted::Delay(0.05), Suspicion::Delay, "place"),
        (Planted::Sign, Suspicion::Unit("sign".to_owned()), "place"),
        (Planted::Thousand, Suspicion::Unit("kilo".to_owned()), "place"),
        (Planted::Start(0.15), Suspicion::Constant, "start"),
    ];
    let mut wrong = Vec::new();
    for (planted, fault, name) in cases {
        for seed in 0..4 {
            let (suspects, _) = record(planted, seed);
            let first = suspects.first().map(|suspect| (suspect.fault.clone(), suspect.name.clone()));
            if first != Some((fault.clone(), name.to_owned())) {
                let told: Vec<String> = suspects
                    .iter()
                    .map(|s| {
                        format!(
                            "{:?} {} {:.3} dep {:.2} cost {:.1?} p {:?}",
                            s.fault, s.name, s.value, s.departure, s.cost, s.probability
                        )
                    })
                    .collect();
                wrong.push(format!("{fault:?} {name} seed {seed}:\n  {}", told.join("\n  ")));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn nobody_is_named_without_a_fault() {
    let named = (0..40).filter(|seed| !record(Planted::Nothing, *seed).0.is_empty()).count();
    assert!(named <= 2, "{named}");
}

/// A wave that nothing in the model makes.
#[test]
fn what_nothing_explains_is_not_put_on_somebody() {
    let (suspects, fit) = record(Planted::Structure, 1);
    assert_eq!(fit, FitVerdict::Misses);
    assert!(suspects.iter().all(|suspect| !suspect.explains()), "{suspects:?}");
}

/// The parameter's value is found with its fault, and how far it is from what was allowed.
#[test]
fn a_parameter_beyond_its_range_is_told_with_its_value() {
    let (suspects, _) = record(Planted::Parameter(2, 0.13), 7);
    let mass = &suspects[0];
    assert_eq!(mass.name, "mass");
    assert!((mass.value - 1.13).abs() < 0.03 && mass.explains(), "{mass:?}");
    assert!(mass.departure > 3.0, "{mass:?}");
}

/// A normal parameter that is far from its mean is told, too.
#[test]
fn a_prior_is_no_bound() {
    let mut free = free("a", Spacing::Linear, -10.0, 10.0);
    free.prior = Some(Prior { centre: 0.0, spread: 0.1 });
    let values = [2.0, 2.01, 1.99, 2.0, 2.0].map(|value| UncertainValue { value, accuracy: 0.02 });
    let problem = problem(vec![free], vec![values.to_vec()]);
    let model = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0]; 5]);
    let starts = starts(1, 4);
    let task = Task { problem: &problem, difference: 1e-4, starts: &starts, effort: effort(2, 40) };
    let Searched { problem, optima, .. } = searched(&task, &model, &|_| ()).unwrap();
    let inquiry = Inquiry {
        problem: &problem,
        difference: 1e-4,
        starts: &starts,
        optimum: &optima[0],
        model: &model,
        sensors: &[],
        reach: &[[f64::NEG_INFINITY, f64::INFINITY]],
        constants: &[],
    };
    let suspects = inquiry.suspects().unwrap();
    assert_eq!(suspects[0].fault, Suspicion::Range);
    assert!((suspects[0].value - 2.0).abs() < 0.02 && suspects[0].departure > 5.0, "{suspects:?}");
}

/// Where the signal is rough, no slope tells by how much it is late.
#[test]
fn a_recording_that_is_late_by_a_row_is_told() {
    const PATTERN: [f64; 12] = [0.0, 1.0, -0.7, 0.2, 1.5, -1.1, 0.4, -0.3, 0.9, -1.4, 0.6, -0.2];
    let model = |_: usize, p: &[f64], _: &[f64]| Ok(PATTERN.map(|part| p[0] * part).to_vec());
    for (rows, late) in [(1, 0.1), (2, 0.2), (-1, -0.1)] {
        let at = |k: usize| PATTERN[k.saturating_add_signed(-rows).min(PATTERN.len() - 1)];
        let values = (0..PATTERN.len()).map(|k| UncertainValue { value: 1.3 * at(k), accuracy: 0.01 });
        let problem = problem(vec![free("a", Spacing::Linear, 0.5, 1.5)], vec![values.collect()]);
        let starts = starts(1, 16);
        let task = Task { problem: &problem, difference: 1e-4, starts: &starts, effort: effort(2, 40) };
        let Searched { problem, optima, .. } = searched(&task, &model, &|_| ()).unwrap();
        let confusion = |rows| Confusion { factor: 1.0, offset: 0.0, rows, words: String::new() };
        let sensor = Sensor {
            group: Group { name: "force".to_owned(), values: (0..PATTERN.len()).map(|k| [0, k]).collect() },
            criteria: vec!["force".to_owned()],
            unit: None,
            times: vec![(0..PATTERN.len()).map(|k| 0.1 * k as f64).collect()],
            confusions: [-2, -1, 1, 2].map(confusion).to_vec(),
        };
        let inquiry = Inquiry {
            problem: &problem,
            difference: 1e-4,
            starts: &starts,
            optimum: &optima[0],
            model: &model,
            sensors: &[sensor],
            reach: &[[0.0, f64::INFINITY]],
            constants: &[],
        };
        let suspects = inquiry.suspects().unwrap();
        let first = suspects.first().unwrap();
        assert_eq!((&first.fault, &first.unit), (&Suspicion::Delay, &Some("s".to_owned())), "{suspects:?}");
        assert!((first.value - late).abs() < 1e-9, "{suspects:?}");
    }
}
