//! Mixed lubrication up to contact that carries all of the load.

use fmu_export::model::{Experiment, Model};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;

const FILMS: [FilmModel; 2] = [FilmModel::Mobility, FilmModel::Reynolds];

/// A bearing at a constant temperature under a constant load, N, at a speed, rpm.
fn under(load: f64, rpm: f64) -> Stand {
    let mut stand = Stand::default();
    stand.thermal.isothermal = true;
    stand.load.lever_ratio = 0.0;
    stand.inputs.external_force.value = load;
    stand.inputs.speed.value = rpm * std::f64::consts::PI / 30.0;
    stand
}

/// The readings after some seconds.
fn after(seconds: f64, mut stand: Stand) -> Readings {
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    stand.advance(0.0, seconds, &mut ()).unwrap();
    *stand.readings()
}

/// The friction coefficient between surfaces of this roughness, m, and clearance, m: of the film that takes the flow factors as
/// they are published, or of the one over the mobility map.
fn friction(film: FilmModel, [roughness, clearance]: [f64; 2], load: f64) -> f64 {
    let mut stand = under(load, 10.0);
    stand.film.model = film;
    stand.bearing.resolution.flow_factors = film == FilmModel::Reynolds;
    // As in the map, cavities have the bath's pressure.
    stand.bearing.resolution.mass_conserving = false;
    stand.bearing.surface.boundary_friction = 0.05;
    stand.bearing.surface.roughness = roughness;
    stand.bearing.radial_clearance = clearance;
    after(3.0, stand).friction_coefficient
}

/// N.
const LOADS: [f64; 8] = [5.0, 20.0, 50.0, 100.0, 1000.0, 5000.0, 15_000.0, 20_000.0];

/// Friction falls with the load in a full film, then rises to the dry limit, and does not fall again, also where the asperities
/// cannot carry the load before the mean planes meet, for pairs of roughness and clearance, m. The film of the mobility map is within
/// 2.5 % of the one with flow factors; the finest surfaces differ most, where friction is least.
fn rises_to_the_dry_limit(pairs: &[[f64; 2]], loads: &[f64]) {
    for &surfaces in pairs {
        let mut curve = Vec::new();
        for &load in loads {
            let [mobility, reynolds] = FILMS.map(|film| friction(film, surfaces, load));
            assert!((mobility / reynolds - 1.0).abs() < 0.025, "{surfaces:?} {load}: {mobility} {reynolds}");
            curve.push(mobility);
        }
        let least = curve.iter().copied().fold(f64::INFINITY, f64::min);
        let lowest = curve.iter().position(|&friction| friction == least);
        let (down, up) = curve.split_at(lowest.unwrap_or(0));
        assert!(down.is_sorted_by(|a, b| a > b) && up.is_sorted_by(|a, b| a < b), "{surfaces:?}: {curve:?}");
        // The pressure's integral around the bush is a little larger than the load.
        let last = curve[curve.len() - 1];
        assert!((0.049..0.054).contains(&last), "{surfaces:?}: {last}");
    }
}

#[test]
fn friction_rises_with_the_load_to_the_dry_limit() {
    rises_to_the_dry_limit(&[[0.5e-6, 40e-6], [3e-6, 20e-6]], &[LOADS[0], LOADS[2], LOADS[4], LOADS[7]]);
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn friction_rises_to_the_dry_limit_between_all_surfaces() {
    let clearances = |roughness: f64| [[roughness, 20e-6], [roughness, 40e-6]];
    rises_to_the_dry_limit(&[0.5e-6, 1e-6, 3e-6].map(clearances).concat(), &LOADS);
}

/// Neither a load nor a tilt of nothing makes friction jump.
#[test]
fn friction_is_continuous_in_load_and_tilt() {
    let at = |load: f64, tilt: f64| {
        let mut stand = under(load, 10.0);
        stand.film.model = FilmModel::Reynolds;
        stand.bearing.surface.roughness = 1e-6;
        stand.bearing.resolution.tilt = [tilt, 0.0];
        after(1.0, stand).friction_coefficient
    };
    let aligned = at(15_000.0, 0.0);
    for (load, tilt) in [(15_000.1, 0.0), (15_000.0, 1e-12)] {
        let apart = at(load, tilt) / aligned - 1.0;
        assert!(apart.abs() < 2e-3, "{load} {tilt}: {apart}");
    }
}

/// Between smooth surfaces nothing carries but the film, also where the journal is tilted.
#[test]
fn smooth_surfaces_do_not_touch() {
    let mut stand = under(200.0, 300.0);
    stand.film.model = FilmModel::Reynolds;
    stand.bearing.surface.roughness = 0.0;
    stand.bearing.resolution.tilt = [5e-6, 0.0];
    assert_eq!(after(0.02, stand).contact_share, 0.0);
}

/// Sander's bearing in mixed lubrication (torques as given with the public test 13 of `mboct-mbdyn-pkg`): 47.8 mm by 17.2 mm under
/// 10 MPa. The torque includes the support bearings. Assumed, and the same at all speeds: 20 um of radial clearance, oil of 26 mPa.s,
/// a roughness of 0.62 um, a boundary friction of 0.14 and 0.0004 for the support.
#[test]
fn the_torque_of_sander_s_bearing_rises_below_500_rpm() {
    for (rpm, measured) in [(3000.0, 1.06), (500.0, 0.43), (300.0, 0.58), (200.0, 1.076)] {
        let (diameter, width) = (47.8e-3, 17.2e-3);
        let mut stand = under(10e6 * diameter * width, rpm);
        stand.bearing.diameter = diameter;
        stand.bearing.width = width;
        stand.bearing.radial_clearance = 20e-6;
        stand.bearing.surface.roughness = 0.62e-6;
        stand.bearing.surface.boundary_friction = 0.14;
        stand.drive.support_friction = 4e-4;
        let viscosity = after(1e-3, stand.clone()).film_viscosity;
        stand.oil.viscosity_scale = 0.026 / viscosity;
        let torque = after(2.0, stand).friction_torque;
        println!("| {rpm} | {torque:.3} | {measured} |");
        assert!((torque / measured - 1.0).abs() < 0.1, "{rpm} rpm: {torque}");
    }
}

/// A journal that high boundary friction carries far up the bush comes to rest there, also in hardly any oil. It is watched
/// between these seconds; `choose` sets the rest.
fn settles_high(between: std::ops::Range<usize>, choose: impl Fn(&mut Stand)) {
    for film in FILMS {
        for oil in [1.0, 1e-3] {
            let mut stand = under(743.5, 1.0);
            stand.film.model = film;
            choose(&mut stand);
            stand.bearing.surface.boundary_friction = 0.8;
            stand.oil.viscosity_scale = oil;
            stand.initialise(&Experiment::default(), &mut ()).unwrap();
            let mut angles = Vec::new();
            for second in 0..between.end {
                stand.advance(second as f64, 1.0, &mut ()).unwrap();
                angles.push(stand.readings().attitude_angle.to_degrees());
            }
            let [least, most] = [f64::min, f64::max].map(|of| {
                let last = angles[between.start..].iter().copied();
                last.reduce(of).unwrap_or(f64::NAN)
            });
            assert!(most - least < 0.01, "{film:?} {oil}: {angles:?}");
            assert!((-0.8_f64.atan().to_degrees() - most).abs() < 0.5, "{most}");
        }
    }
}

#[test]
fn high_boundary_friction_settles() {
    settles_high(1..4, |stand| (stand.bearing.resolution.columns, stand.bearing.resolution.rows) = (48, 4));
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn high_boundary_friction_settles_on_many_columns() {
    settles_high(10..15, |_| ());
}
