//! Friction from standstill to full film: the Stribeck curve against a reference of this test's own, the dry journal's
//! place, and breakaway.

use fmu_export::model::{Experiment, Model};
use journal_bearing::reynolds::{pressure_flow_factor, shear_stress_factor, sliding_stress_factor};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::{Mutex, PoisonError};

const NO_FILES: Experiment<'static> = Experiment { start: 0.0, stop: None, tolerance: None, resources: None };

/// The rig at 82 degC under its mean load, 743.5 N, which is constant here.
fn rig() -> Stand {
    let mut stand = Stand::default();
    stand.load.eccentricity = 0.0;
    stand.thermal.isothermal = true;
    stand
}

/// The readings when the journal has come to rest at a shaft speed, rad/s.
fn at_rest(mut stand: Stand, speed: f64) -> Readings {
    stand.inputs.speed.value = speed;
    stand.initialise(&NO_FILES, &mut ()).unwrap();
    for i in 0..4 {
        stand.advance(0.5 * f64::from(i), 0.5, &mut ()).unwrap();
    }
    *stand.readings()
}

/// Greenwood & Tripp's contact pressure, Pa, at a gap, m: `F_5/2` by quadrature of its definition, with `s - H = x^2`.
fn contact_pressure(stand: &Stand, gap: f64) -> f64 {
    let surface = &stand.bearing.surface;
    let ratio = gap / surface.roughness;
    let (n, end) = (400, 3.0);
    let dx = end / f64::from(n);
    let integrand = |k: i32| {
        let x = (f64::from(k) + 0.5) * dx;
        2.0 * x.powi(6) * (-0.5 * (ratio + x * x).powi(2)).exp()
    };
    let integral = (0..n).map(integrand).sum::<f64>() * dx / TAU.sqrt();
    let scale = 16.0 * 2f64.sqrt() * PI / 15.0 * surface.asperity_density.powi(2);
    scale * surface.asperity_slope.sqrt() * surface.composite_modulus * integral
}

/// The contact's resultant force and the pressure's integral, N, at an eccentricity ratio.
fn contact(stand: &Stand, e: f64) -> [f64; 2] {
    let bearing = &stand.bearing;
    let n = 720;
    let area = PI * bearing.diameter * bearing.width / f64::from(n);
    let mut sums = [0.0; 2];
    for k in 0..n {
        let cos = (TAU * f64::from(k) / f64::from(n)).cos();
        let p = contact_pressure(stand, bearing.radial_clearance * (1.0 - e * cos));
        sums[0] += p * cos * area;
        sums[1] += p * area;
    }
    sums
}

/// The film between the asperities at a gap over the roughness: mean gap (Patir & Cheng 1978) by quadrature of its definition,
/// third power of the gap of the flow, and resistance to sliding, of a journal whose factors fade between five and seven
/// roughnesses.
fn rough_film(ratio: f64) -> [f64; 3] {
    let n = 400;
    let dx = 8.0 / f64::from(n);
    let open = |k: i32| {
        let x = (f64::from(k) + 0.5) * dx;
        x * (-0.5 * (x - ratio).powi(2)).exp()
    };
    let mean = if ratio > 7.0 { ratio } else { (0..2 * n).map(open).sum::<f64>() * dx / TAU.sqrt() };
    let t = ((ratio - 5.0) / 2.0).clamp(0.0, 1.0);
    let counts = 1.0 - t * t * (3.0 - 2.0 * t);
    let flow = 1.0 - counts * (1.0 - pressure_flow_factor(ratio));
    let stress = sliding_stress_factor(ratio) + shear_stress_factor(ratio);
    let resistance = (1.0 + counts * (stress - 1.0)) / ratio;
    [mean, flow * ratio.powi(3), resistance]
}

const COLUMNS: usize = 360;
const ROWS: usize = 24;

/// A steady film at `6 eta omega (R/c)^2 = 1` in finite differences over theta, from the widest gap, and over half the width
/// from the middle, with `p >= 0` by projected over-relaxation (Cryer 1971, SIAM J. Control 9, 385-392).
struct Film {
    pressure: Vec<[f64; ROWS + 1]>,
}

impl Film {
    fn new() -> Self {
        let pressure = vec![[0.0; ROWS + 1]; COLUMNS];
        Self { pressure }
    }

    /// Solves for the pressures at an eccentricity ratio. `slenderness` is D/B, `roughness` that over the clearance.
    fn solve(&mut self, e: f64, slenderness: f64, roughness: f64) {
        const RELAXATION: f64 = 1.9;
        let step = TAU / COLUMNS as f64;
        let across = (slenderness * step * ROWS as f64).powi(2);
        let film = |i: f64| rough_film((1.0 - e * (i * step - PI).cos()) / roughness);
        let edges: Vec<_> = (0..=2 * COLUMNS)
            .map(|k| film(0.5 * k as f64 - 0.5))
            .map(|[mean, flow, _]| [mean * roughness, flow * roughness.powi(3)])
            .collect();
        for _ in 0..5000 {
            let (mut change, mut most) = (0.0_f64, 0.0_f64);
            for i in 0..COLUMNS {
                let around = [2 * i, 2 * i + 1, 2 * i + 2].map(|k| edges[k]);
                let [before, here, after] = around.map(|[_, flow]| flow);
                let wedge = step * (around[2][0] - around[0][0]);
                let neighbours = [(i + COLUMNS - 1) % COLUMNS, (i + 1) % COLUMNS];
                for j in 0..ROWS {
                    let p = &self.pressure;
                    let inner = p[i][if j == 0 { 1 } else { j - 1 }];
                    let along = before * p[neighbours[0]][j] + after * p[neighbours[1]][j];
                    let sum = along + here * across * (inner + p[i][j + 1]) - wedge;
                    let gauss = sum / (before + after + 2.0 * here * across);
                    let old = p[i][j];
                    let new = (old + RELAXATION * (gauss - old)).max(0.0);
                    change = change.max((new - old).abs());
                    most = most.max(new);
                    self.pressure[i][j] = new;
                }
            }
            if change < 1e-8 * most {
                return;
            }
        }
        panic!("the reference's film has not converged at {e}");
    }

    /// Integrals over the film, as shares of its area: of `p cos`, `p sin` and `h dp/dtheta`. The pressure bears where the
    /// surfaces do not touch, and the mean gap opens with the distance there only.
    fn integrals(&self, e: f64, roughness: f64) -> [f64; 3] {
        let step = TAU / COLUMNS as f64;
        let mut sums = [0.0; 3];
        for (i, column) in self.pressure.iter().enumerate() {
            let theta = i as f64 * step - PI;
            let mean = |p: &[f64; ROWS + 1]| (0.5 * (p[0] + p[ROWS]) + p[1..ROWS].iter().sum::<f64>()) / ROWS as f64;
            let [before, after] = [COLUMNS - 1, 1].map(|d| mean(&self.pressure[(i + d) % COLUMNS]));
            let ratio = (1.0 - e * theta.cos()) / roughness;
            let [here, there] = [ratio - 1e-4, ratio + 1e-4].map(|ratio| rough_film(ratio)[0]);
            let bears = (there - here) / 2e-4;
            sums[0] += bears * mean(column) * theta.cos() * step;
            sums[1] += bears * mean(column) * theta.sin() * step;
            sums[2] += 0.5 * (here + there) * roughness * 0.5 * (after - before);
        }
        sums
    }
}

/// [`solved`], once for both films.
fn reference(stand: &Stand, resting: &Readings, speed: f64) -> [f64; 2] {
    let Readings { load_force: load, film_viscosity: viscosity, eccentricity_ratio: near, .. } = *resting;
    static SOLVED: Mutex<BTreeMap<[u64; 3], [f64; 2]>> = Mutex::new(BTreeMap::new());
    let mut all = SOLVED.lock().unwrap_or_else(PoisonError::into_inner);
    let key = [load, viscosity, speed].map(f64::to_bits);
    *all.entry(key).or_insert_with(|| solved(stand, [load, viscosity, speed], near))
}

/// The reference: torque, N.m, and attitude angle, rad, of the journal at rest under `load`, by false position of the
/// eccentricity ratio. Friction pushes the journal back with the contact force times the friction coefficient.
fn solved(stand: &Stand, [load, viscosity, speed]: [f64; 3], near: f64) -> [f64; 2] {
    let bearing = &stand.bearing;
    let (c, radius, width) = (bearing.radial_clearance, 0.5 * bearing.diameter, bearing.width);
    let mu = bearing.surface.boundary_friction;
    let roughness = bearing.surface.roughness / c;
    let scale = 6.0 * viscosity * speed * (radius / c).powi(2);
    let mut film = Film::new();
    let mut at = |e: f64| {
        film.solve(e, bearing.diameter / width, roughness);
        let [x, y, rise] = film.integrals(e, roughness);
        let [force, normal] = contact(stand, e);
        let carried = [scale * radius * width * x + force, scale * radius * width * y + mu * force];
        let slides = |k: i32| rough_film((1.0 - e * (TAU * f64::from(k) / 720.0).cos()) / roughness)[2];
        let slides = (0..720).map(slides).sum::<f64>() / roughness * TAU / 720.0;
        let shear = viscosity * speed * radius.powi(3) * width / c * slides;
        let torque = shear + 0.5 * scale * c * radius * width * rise + mu * normal * radius;
        (carried[0].hypot(carried[1]), [torque, -carried[1].atan2(carried[0])])
    };
    let mut logarithm = |e: f64| {
        let (carried, told) = at(e);
        ((carried / load).ln(), told)
    };
    // The stand's own place is near: that saves most of the search.
    let [mut low, mut high] = [-0.02, 0.02].map(|by| (near + by).min(0.999)).map(|e| (e, logarithm(e).0));
    assert!(low.1 < 0.0 && high.1 > 0.0, "{load} N is not borne near {near}: {low:?} {high:?}");
    let mut moved = 0.0;
    for _ in 0..30 {
        let middle = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let (miss, told) = logarithm(middle);
        if miss.abs() < 1e-5 {
            return told;
        }
        let (moves, stays) = if miss < 0.0 { (&mut low, &mut high) } else { (&mut high, &mut low) };
        *moves = (middle, miss);
        // An end that stays twice counts half, so that it moves, too (the Illinois rule).
        if moved == miss.signum() {
            stays.1 *= 0.5;
        }
        moved = miss.signum();
    }
    panic!("no place of the journal bears {load} N")
}

fn rpm(speed: f64) -> f64 {
    speed * PI / 30.0
}

#[test]
fn the_stribeck_curve_is_the_reference_s() {
    follows_the_reference(&[10.0, 300.0, 3000.0]);
}

#[test]
#[ignore = "takes a minute: scripts/test --long"]
fn the_whole_stribeck_curve_is_the_reference_s() {
    follows_the_reference(&[0.01, 1.0, 30.0, 100.0, 600.0, 1000.0, 2000.0]);
}

fn follows_the_reference(speeds: &[f64]) {
    println!("| rpm | M, N.m | reference | mu | attitude, deg | reference |");
    for &speed in speeds {
        let resting = at_rest(rig(), rpm(speed));
        let [torque, attitude] = reference(&rig(), &resting, rpm(speed));
        let [here, there] = [resting.attitude_angle, attitude].map(f64::to_degrees);
        println!(
            "| {speed} | {:.5} | {torque:.5} | {:.5} | {here:.2} | {there:.2} |",
            resting.friction_torque, resting.friction_coefficient
        );
        let apart = (resting.friction_torque / torque - 1.0).abs();
        assert!(apart < 0.01, "{speed} rpm: {resting:?}, expected {torque}");
        assert!((here - there).abs() < 0.5, "{speed} rpm: {here}, {there}");
    }
}

#[test]
fn the_reynolds_film_has_the_reference_s_friction() {
    for speed in [10.0, 300.0, 2000.0] {
        let mut stand = rig();
        stand.film.model = FilmModel::Reynolds;
        // The reference counts the whole ring as full.
        stand.bearing.resolution.mass_conserving = false;
        let resting = at_rest(stand, rpm(speed));
        let [torque, attitude] = reference(&rig(), &resting, rpm(speed));
        let apart = (resting.friction_torque / torque - 1.0).abs();
        assert!(apart < 0.01, "{speed} rpm: {resting:?}, expected {torque}");
        let ahead = (resting.attitude_angle - attitude).to_degrees();
        assert!(ahead.abs() < 0.5, "{speed} rpm: {ahead}");
    }
}

/// A dry journal climbs the bush against its rotation until the load lies on the edge of the cone of friction.
#[test]
fn a_dry_journal_climbs_to_the_angle_of_friction() {
    for (film, friction, speed) in [
        (FilmModel::Mobility, 0.05, 0.1),
        (FilmModel::Mobility, 0.3, -0.1),
        (FilmModel::Reynolds, 0.05, 0.1),
        (FilmModel::Reynolds, 0.3, -0.1),
    ] {
        let mut stand = rig();
        stand.film.model = film;
        stand.oil.viscosity_scale = 1e-3;
        stand.bearing.surface.boundary_friction = friction;
        // Oil that the bath presses in carries some of the load where the cavities are under vacuum.
        stand.bearing.resolution.side_pressure = 0.0;
        let resting = at_rest(stand, speed);
        let climb = -friction.atan().copysign(speed);
        let apart = (resting.attitude_angle - climb).to_degrees();
        assert!(apart.abs() < 0.01, "{film:?} {friction}: {apart} deg");
        let pressed = 1.0 / 1f64.hypot(friction);
        assert!((resting.contact_share - pressed).abs() < 1e-4, "{resting:?}");
    }
}

/// The breakaway torque is `mu R` times the contact pressure's integral: 1.07 `mu F R` at the start values, `mu F R` when
/// the contact is narrow.
#[test]
fn breakaway_is_the_limit_for_a_speed_towards_zero() {
    let slowly = 1e-3;
    // Smooth surfaces meet only in thin oil.
    for (roughness, narrow, oil) in [(5.13e-6, 1.07, 1.0), (5e-8, 1.0, 1e-3)] {
        let mut stand = rig();
        stand.bearing.surface.roughness = roughness;
        stand.oil.viscosity_scale = oil;
        let resting = at_rest(stand.clone(), slowly);
        let [_, normal] = contact(&stand, resting.eccentricity_ratio);
        let level = stand.bearing.surface.boundary_friction * stand.bearing.radius();
        assert!((resting.friction_torque / (level * normal) - 1.0).abs() < 2e-3, "{resting:?}");
        let ratio = resting.friction_torque / (level * resting.load_force);
        assert!((ratio - narrow).abs() < 0.005, "{roughness}: {ratio}");
    }
    // A peak at breakaway, which is gone at full speed.
    let peak = |ratio: f64, speed: f64| {
        let mut stand = rig();
        stand.bearing.surface.breakaway_ratio = ratio;
        at_rest(stand, speed).friction_torque
    };
    // The contact carries what friction leaves of the load.
    let expected = 1.5 * 1f64.hypot(0.05) / 1f64.hypot(0.075);
    let ratio = peak(1.5, slowly) / peak(1.0, slowly);
    assert!((ratio / expected - 1.0).abs() < 1e-3, "{ratio} {expected}");
    assert_eq!(peak(1.5, rpm(300.0)), peak(1.0, rpm(300.0)));
}

/// A speed that passes through zero turns the friction round; standstill is no obstacle.
#[test]
fn friction_changes_its_sign_with_the_speed() {
    for &film in FilmModel::ALL {
        let mut stand = rig();
        stand.film.model = film;
        stand.inputs.speed.value = 1.0;
        stand.initialise(&NO_FILES, &mut ()).unwrap();
        stand.advance(0.0, 0.5, &mut ()).unwrap();
        stand.inputs.speed.slope = -2.0;
        stand.advance(0.5, 1.0, &mut ()).unwrap();
        let turned = *stand.readings();
        let straight = at_rest(rig(), -1.0);
        assert!((turned.friction_torque / straight.friction_torque - 1.0).abs() < 0.01);
        assert!(turned.friction_torque < 0.0 && turned.attitude_angle > 0.0, "{turned:?}");
    }
}

#[test]
fn the_torque_sensor_reads_the_support_bearings() {
    let without = at_rest(rig(), rpm(300.0));
    let mut stand = rig();
    stand.drive.support_friction = 0.0015;
    let with = at_rest(stand, rpm(300.0));
    let support = 0.0015 * with.load_force * 0.0125;
    assert!((with.friction_torque - without.friction_torque - support).abs() < 1e-12);
    assert_eq!(with.contact_torque, without.contact_torque);
    let back = {
        let mut stand = rig();
        stand.drive.support_friction = 0.0015;
        at_rest(stand, rpm(-300.0))
    };
    assert!((back.friction_torque + with.friction_torque).abs() < 1e-9);
}
