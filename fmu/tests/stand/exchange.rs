//! Model Exchange: another solver integrates the stand's rates, and comes to what the stand's own steps give.

use fmu_export::model::{Continuous, Experiment, Fault, Kind, Model, Quantity};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::stand::Stand;

fn started(tolerance: f64) -> Stand {
    let mut stand = Stand::default();
    stand.solver.tolerance = tolerance;
    stand.drive.fluctuation_amplitude = 0.025;
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    stand
}

fn read(stand: &Stand, name: &str) -> f64 {
    let variable = Stand::variables().iter().find(|v| v.name == name).unwrap();
    match &variable.kind {
        Kind::Real(Quantity { access, .. }) => (access.get)(stand),
        _ => panic!("{name} is no Real"),
    }
}

fn rates(stand: &mut Stand, time: f64, y: &[f64]) -> Vec<f64> {
    stand.set_time(time);
    for (state, value) in Stand::states().iter().zip(y) {
        (state.set)(stand, *value);
    }
    let mut rates = vec![f64::NAN; y.len()];
    Continuous::rates(stand, &mut rates).unwrap();
    rates
}

/// The classical Runge-Kutta method with steps of fixed length.
fn integrate(stand: &mut Stand, end: f64, h: f64) {
    let steps = (end / h).round() as usize;
    let ahead = |y: &[f64], h: f64, slope: &[f64]| -> Vec<f64> {
        y.iter().zip(slope).map(|(y, slope)| y + h * slope).collect()
    };
    let mut y: Vec<f64> = Stand::states().iter().map(|state| (state.get)(stand)).collect();
    for step in 0..steps {
        let time = step as f64 * h;
        let a = rates(stand, time, &y);
        let b = rates(stand, time + h / 2.0, &ahead(&y, h / 2.0, &a));
        let c = rates(stand, time + h / 2.0, &ahead(&y, h / 2.0, &b));
        let d = rates(stand, time + h, &ahead(&y, h, &c));
        for (i, y) in y.iter_mut().enumerate() {
            *y += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        }
    }
    rates(stand, end, &y);
    stand.update().unwrap();
}

#[test]
fn another_solver_comes_to_the_same() {
    let (mut stepped, mut other) = (started(1e-12), started(1e-12));
    for step in 0..5 {
        stepped.advance(f64::from(step) * 0.1, 0.1, &mut ()).unwrap();
    }
    integrate(&mut other, 0.5, 1e-5);
    for variable in Stand::variables() {
        let real = matches!(variable.kind, Kind::Real(_));
        // The check by ISO 7902 takes the worst of the stand's own steps.
        let along_steps = variable.name.starts_with("operation.") || Stand::without().contains(&variable.name);
        if !real || along_steps {
            continue;
        }
        let (a, b) = (read(&stepped, variable.name), read(&other, variable.name));
        assert!((a - b).abs() <= 1e-6 * a.abs() + 1e-15, "{}: {a} {b}", variable.name);
    }
}

/// Rates are a function of time, states, inputs and parameters: earlier calls leave nothing behind.
#[test]
fn rates_do_not_remember() {
    let mut stand = started(1e-6);
    stand.advance(0.0, 0.1, &mut ()).unwrap();
    let y: Vec<f64> = Stand::states().iter().map(|state| (state.get)(&stand)).collect();
    let first = rates(&mut stand, 0.1, &y);
    for change in [-30.0, 0.1, 0.24, 40.0] {
        let mut away = y.clone();
        away[3] += change;
        assert_ne!(rates(&mut stand, 0.7, &away), first);
        assert_eq!(rates(&mut stand, 0.1, &y), first);
    }
}

/// The rates of the eccentricity at a place.
fn drift(stand: &mut Stand, x: f64, y: f64) -> [f64; 2] {
    let mut states: Vec<f64> = Stand::states().iter().map(|state| (state.get)(stand)).collect();
    (states[1], states[2]) = (x, y);
    let rates = rates(stand, 0.0, &states);
    [rates[1], rates[2]]
}

/// A host reads what it has set, and its length is `sinh(5 e)/5`.
#[test]
fn the_eccentricity_is_stretched() {
    let mut stand = of_film(FILMS[0]);
    drift(&mut stand, 0.9, -1.2);
    let place = [1, 2].map(|k: usize| (Stand::states()[k].get)(&stand));
    assert_eq!(place, [0.9, -1.2]);
    stand.update().unwrap();
    let length = (5.0 * read(&stand, "bearing.eccentricityRatio")).sinh() / 5.0;
    assert!((length - 1.5).abs() < 1e-12, "{length}");
}

/// Roughness from none to contact all around, m; clearance, m; B/D.
const FILMS: [[f64; 3]; 5] =
    [[0.0, 2e-5, 0.76], [1e-7, 2e-5, 0.76], [1e-6, 2e-5, 0.3], [5.13e-6, 2e-5, 0.76], [8e-6, 2e-5, 2.0]];

fn of_film([roughness, clearance, width]: [f64; 3]) -> Stand {
    let mut stand = Stand::default();
    stand.bearing.surface.roughness = roughness;
    stand.bearing.radial_clearance = clearance;
    stand.bearing.width = width * stand.bearing.diameter;
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    stand
}

/// Where every run starts, the rates have one derivative, from all sides and over steps of all lengths that solvers take.
#[test]
fn rates_are_differentiable_in_the_centre() {
    for film in FILMS {
        let mut stand = of_film(film);
        let here = drift(&mut stand, 0.0, 0.0);
        let along = |stand: &mut Stand, x: f64, y: f64, far: f64| {
            let there = drift(stand, x * far, y * far);
            [0, 1].map(|k| (there[k] - here[k]) / far)
        };
        let (dx, dy) = (along(&mut stand, 1.0, 0.0, 1e-6), along(&mut stand, 0.0, 1.0, 1e-6));
        let size = dx.iter().chain(&dy).fold(0.0_f64, |most, slope| most.max(slope.abs()));
        for far in [1e-8, 1e-6, 1e-4] {
            for turn in 0..16 {
                let (y, x) = (f64::from(turn) * std::f64::consts::TAU / 16.0).sin_cos();
                let slope = along(&mut stand, x, y, far);
                for k in 0..2 {
                    let apart = (slope[k] - x * dx[k] - y * dy[k]).abs();
                    // Second derivatives count by the distance, rounding by its reciprocal.
                    let allowed = (1e-5 + 20.0 * far) * size + 1e-13 * here[0].abs() / far;
                    assert!(apart < allowed, "{film:?} {far:e} {turn}: {slope:?} {dx:?} {dy:?}");
                }
            }
        }
    }
}

/// Where a solver looks far beyond the bush it gets numbers.
#[test]
fn rates_exist_far_outside() {
    for film in FILMS {
        let mut stand = of_film(film);
        // Trial steps of scipy's RK45 have come as far as the last one.
        for far in [1.0, 1.5, 42.7, 1e4, 1e60] {
            for turn in 0..8 {
                let (y, x) = (f64::from(turn) * 0.8).sin_cos();
                // `rates` fails where they are not finite.
                drift(&mut stand, x * far, y * far);
                let mut states: Vec<f64> = Stand::states().iter().map(|state| (state.get)(&stand)).collect();
                states[3..7].fill(x * far);
                rates(&mut stand, 0.0, &states);
            }
        }
    }
}

#[test]
fn what_cannot_be_integrated_is_refused() {
    let mut stand = started(1e-6);
    assert!(stand.allow().is_ok());
    let mut y: Vec<f64> = Stand::states().iter().map(|state| (state.get)(&stand)).collect();
    y[3] = f64::NAN;
    stand.set_time(0.0);
    for (state, value) in Stand::states().iter().zip(&y) {
        (state.set)(&mut stand, *value);
    }
    let refused = Continuous::rates(&stand, &mut vec![0.0; y.len()]);
    assert!(matches!(refused, Err(Fault::Failed(why)) if why.contains("film temperature NaN K")));
    let mut stand = Stand::default();
    stand.film.model = FilmModel::Reynolds;
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    let refused = stand.allow();
    assert!(matches!(refused, Err(Fault::Invalid(why)) if why.starts_with("bearing.film = Reynolds:")));
}
