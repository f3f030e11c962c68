//! Random bearings under random loads and speeds: every interval must be solved.

use nalgebra::Vector2;
use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{RngAlgorithm, RngSeed, TestRng, TestRunner},
};

use crate::{
    reynolds::{Cavitation, Drive, FilmSettings, ReynoldsFilm},
    rheology::{DensityLaw, Rheology},
};

/// A bearing within ordinary engineering bounds, and a few intervals of load and speed.
#[derive(Clone, Debug)]
struct Life {
    settings: FilmSettings,
    viscosity: f64,
    /// Specific load (Pa), its direction (rad), speeds of journal and bush (rad/s), duration (s).
    intervals: Vec<[f64; 5]>,
}

const CAVITATION: [Cavitation; 2] = [Cavitation::NonNegative, Cavitation::MassConserving];
const DENSITY: [DensityLaw; 2] = [DensityLaw::Constant, DensityLaw::DowsonHigginson];

/// The kind of a film: bit 0 is the cavitation condition, bit 1 the density law; constant density is four times as likely.
fn kinds() -> impl Strategy<Value = usize> {
    prop_oneof![4 => 0..2_usize, 1 => 2..4_usize]
}

/// A number of columns, and a twelfth as many rows.
fn cells(columns: usize) -> [usize; 2] {
    [columns, columns.div_ceil(12)]
}

fn rheology(kind: usize) -> Rheology {
    Rheology { density_law: DENSITY[kind / 2], ..Rheology::default() }
}

fn lives() -> impl Strategy<Value = Life> {
    let bearing = (-2.0..-0.6, 0.2..1.6, -3.7..-2.4, kinds(), 0.0..6.0);
    let speed = || prop_oneof![1 => Just(0.0), 4 => -300.0..300.0];
    let load = prop_oneof![1 => Just(0.0), 4 => (3.0..7.0).prop_map(|p| 10_f64.powf(p))];
    let interval =
        (load, -3.2..3.2, speed(), speed(), -5.0..-1.0).prop_map(|(p, a, j, b, t)| [p, a, j, b, 10_f64.powf(t)]);
    let intervals = prop::collection::vec(interval, 1..4);
    (bearing, -2.5..-0.5, intervals).prop_map(|((d, w, c, kind, side), eta, intervals)| {
        let diameter = 10_f64.powf(d);
        let settings = FilmSettings {
            cells: cells(32),
            side_pressure: if side < 2.0 { 0.0 } else { 10_f64.powf(side) },
            cavitation: CAVITATION[kind % 2],
            rheology: rheology(kind),
            ..FilmSettings::new(diameter * w, diameter, diameter * 10_f64.powf(c))
        };
        Life { settings, viscosity: 10_f64.powf(eta), intervals }
    })
}

/// Runs a life. The journal must stay inside the bush, everything be finite, mass be conserved and energy balance.
fn live(life: Life) -> Result<(), TestCaseError> {
    let area = life.settings.width * life.settings.diameter;
    let mut film = ReynoldsFilm::new(life.settings).unwrap();
    let mut load_before = Vector2::zeros();
    for [pressure, angle, journal_speed, bush_speed, duration] in life.intervals {
        let force = pressure * area;
        let load_after = Vector2::new(angle.cos(), angle.sin()) * force;
        let drive = Drive {
            load_before,
            load_after,
            journal_speed,
            bush_speed,
            viscosity: life.viscosity,
            contact_friction: 0.0,
        };
        load_before = load_after;
        let report =
            film.advance(duration, &drive, &|_| 0.0).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert!(film.eccentricity().norm() < 1.0);
        prop_assert!(report.journal_torque.is_finite() && report.bush_torque.is_finite());
        prop_assert!(report.max_pressure.is_finite() && report.heat.is_finite());
        prop_assert!(report.energy_error < 1e-3, "energy {}", report.energy_error);
        prop_assert!(report.mass_error < 1e-9, "mass {}", report.mass_error);
    }
    Ok(())
}

impl Life {
    /// Reads a life from a line of numbers.
    fn parse(line: &str) -> Self {
        let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
        let (bearing, intervals) = numbers.split_at(7);
        let (intervals, []) = intervals.as_chunks() else { panic!("five numbers an interval: {line}") };
        let kind = bearing[4] as usize;
        Self {
            settings: FilmSettings {
                cells: cells(bearing[6] as usize),
                side_pressure: bearing[3],
                cavitation: CAVITATION[kind % 2],
                rheology: rheology(kind),
                ..FilmSettings::new(bearing[0], bearing[1], bearing[2])
            },
            viscosity: bearing[5],
            intervals: intervals.to_vec(),
        }
    }

    /// Writes the life as a line of numbers.
    fn line(&self) -> String {
        let settings = &self.settings;
        let bearing = [
            settings.width,
            settings.diameter,
            settings.clearance,
            settings.side_pressure,
            f64::from(settings.cavitation == CAVITATION[1])
                + 2.0 * f64::from(settings.rheology.density_law == DENSITY[1]),
            self.viscosity,
            settings.cells[0] as f64,
        ];
        let numbers = bearing.iter().chain(self.intervals.iter().flatten());
        numbers.map(|n| format!("{n:e}")).collect::<Vec<_>>().join(" ")
    }
}

/// Lives that once failed: starved films under a load that reverses near the bush, and one at rest under a bath of 6 bar,
/// where the energy balance is all rounding.
#[test]
fn hard_lives_are_survived() {
    for (number, line) in include_str!("hard_lives.txt").lines().enumerate() {
        if let Err(failure) = live(Life::parse(line)) {
            panic!("line {}: {failure}", number + 1);
        }
    }
}

/// The same lives in every run.
#[test]
fn three_hundred_lives_are_survived() {
    let mut runner = TestRunner::new(ProptestConfig {
        cases: 300,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    runner.run(&lives(), live).unwrap_or_else(|failure| panic!("{failure}"));
}

/// Runs `LIVES_SEEDS` (10) times 10,000 lives, starting with the seed `LIVES_FIRST` (0), on `LIVES_COLUMNS` (32) columns and a
/// twelfth as many rows. `cargo test --release -p journal-bearing --lib more_lives -- --ignored --nocapture` prints lives
/// that fail as lines for `hard_lives.txt`.
#[test]
#[ignore = "takes minutes"]
fn more_lives_are_survived() {
    let asked = |name: &str, usual: u64| -> u64 { std::env::var(name).map_or(usual, |n| n.parse().expect(name)) };
    let first = asked("LIVES_FIRST", 0_u64);
    let columns = asked("LIVES_COLUMNS", 32);
    let mut lost = 0;
    for seed in first..first + asked("LIVES_SEEDS", 10) {
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&seed.to_le_bytes());
        let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
        let mut runner = TestRunner::new_with_rng(ProptestConfig::default(), rng);
        for _ in 0..10_000 {
            let mut life = lives().new_tree(&mut runner).unwrap().current();
            life.settings.cells = cells(columns as usize);
            let line = life.line();
            if let Err(failure) = live(life) {
                println!("{failure}\n{line}");
                lost += 1;
            }
        }
        println!("seed {seed} lived, {lost} lost so far");
    }
    assert_eq!(lost, 0);
}
