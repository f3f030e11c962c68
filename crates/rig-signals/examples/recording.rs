//! From a recording to criteria: a noisy minute of a bearing rig, its torque recorded 16 ms late.

use std::f64::consts::TAU;

use rig_signals::signal::SignalError;
use rig_signals::smooth::Smoothing;
use rig_signals::{Accuracy, Channel, RigRecording, criteria, synchronise};

const TURN: f64 = 0.2;
const LATE: f64 = 0.016;

fn channel(name: &str, unit: &str, accuracy: Accuracy, values: Vec<f64>) -> Channel {
    Channel {
        name: name.into(),
        variable: format!("sensor.{name}"),
        unit: unit.into(),
        values,
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
    let recording = RigRecording {
        load: channel(
            "loadForce",
            "N",
            Accuracy::Relative(0.005),
            rows(&load, 3.0),
        ),
        torque: channel(
            "frictionTorque",
            "N.m",
            Accuracy::Absolute(0.005),
            rows(&|t| 4e-4 * load(t - LATE), 2e-3),
        ),
        speed: channel(
            "speed",
            "rad/s",
            Accuracy::Absolute(0.0),
            rows(&|_| TAU / TURN, 0.0),
        ),
        power: None,
        others: Vec::new(),
        diameter: 0.025,
        window: None,
        smoothing: Smoothing::None,
        longest_delay: 0.05,
        confidence: 0.99,
        time: time.clone(),
    };
    let answer = synchronise(&recording)?;
    println!("{}", criteria::to_toml(&answer, true));
    Ok(())
}
