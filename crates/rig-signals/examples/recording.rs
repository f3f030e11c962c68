//! From a recording to criteria: a noisy minute of a bearing rig, its torque recorded 16 ms late.

use std::f64::consts::TAU;

use rig_signals::signal::SignalError;
use rig_signals::smooth::Smoothing;
use rig_signals::{Accuracy, Bearing, Channel, Drop, RigRecording, criteria, synchronise};

const TURN: f64 = 0.2;
const LATE: f64 = 0.016;

fn channel(name: &str, unit: &str, accuracy: Accuracy, values: Vec<f64>) -> Channel {
    Channel {
        name: name.into(),
        variable: format!("sensor.{name}"),
        unit: unit.into(),
        time: (0..values.len()).map(|k| k as f64 * 2e-3).collect(),
        values,
        clock: 0,
        lost: Vec::new(),
        drop: Drop::default(),
        accuracy,
        group: None,
    }
}

fn main() -> Result<(), SignalError> {
    let time: Vec<f64> = (0..30_000).map(|k| k as f64 * 2e-3).collect();
    let load = |t: f64| 750.0 + 50.0 * (TAU * t / TURN).sin();
    // Noise that repeats: the same on every machine.
    let noise = |k: usize| ((k * 7_919) % 1_000) as f64 / 500.0 - 1.0;
    let rows = |value: &dyn Fn(f64) -> f64, scatter: f64| {
        let row = |(k, &t): (usize, &f64)| value(t) + scatter * noise(k);
        time.iter().enumerate().map(row).collect()
    };
    let bearing = Bearing {
        load: channel("loadForce", "N", Accuracy::Relative(0.005), rows(&load, 3.0)),
        torque: channel("frictionTorque", "N.m", Accuracy::Absolute(0.005), rows(&|t| 4e-4 * load(t - LATE), 2e-3)),
        speed: channel("speed", "rad/s", Accuracy::Absolute(0.0), rows(&|_| TAU / TURN, 0.0)),
        diameter: 0.025,
        smoothing: Smoothing::None,
        longest_delay: 0.05,
    };
    let recording =
        RigRecording { bearing: Some(bearing), others: Vec::new(), window: None, start: None, confidence: 0.99 };
    let answer = synchronise(&recording)?;
    println!("{}", criteria::to_toml(&answer));
    Ok(())
}
