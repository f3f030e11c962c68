//! Limits that a run passes, which `status.validity` and the log tell.

use fmu_export::model::{Experiment, Log, Model};
use plain_bearing_stand::stand::Stand;

/// What was logged in the category.
#[derive(Default)]
struct Said(Vec<String>);

impl Log for Said {
    fn log(&mut self, category: &'static str, message: std::fmt::Arguments<'_>) {
        if category == "validity" {
            self.0.push(message.to_string());
        }
    }
}

/// The bits and what was logged after 0.2 s in steps of 0.05 s.
fn run(choose: impl Fn(&mut Stand)) -> (i32, Vec<String>) {
    let mut stand = Stand::default();
    choose(&mut stand);
    let mut said = Said::default();
    stand.initialise(&Experiment::default(), &mut said).unwrap();
    for k in 0..4 {
        stand.advance(f64::from(k) * 0.05, 0.05, &mut said).unwrap();
    }
    (stand.validity(), said.0)
}

/// Sets a stand up.
type Choose = fn(&mut Stand);

/// Each limit alone, told once; the rig passes none.
#[test]
fn each_limit_is_told_once() {
    assert_eq!(run(|_| ()), (0, Vec::new()));
    let limits: [(Choose, i32, &str); 6] = [
        (
            // Reynolds number 880 kg/m3 * 400 rad/s * 12.5 mm * 0.4 mm / 1 mPa.s = 1,760 beyond 41.3 * sqrt(31) = 231.
            |stand| {
                stand.inputs.speed.value = 400.0;
                stand.bearing.radial_clearance = 4e-4;
                stand.oil.viscosity_scale = 0.05;
            },
            1,
            "Reynolds number",
        ),
        (
            |stand| {
                stand.thermal.isothermal = true;
                stand.thermal.initial_bearing = 590.0;
            },
            2,
            "oil's data",
        ),
        (
            |stand| {
                stand.load.lever_ratio = 0.0;
                stand.inputs.external_force.value = 15_000.0;
                stand.bearing.surface.roughness = 0.0;
                stand.thermal.isothermal = true;
            },
            4,
            "bearing.pressureLimit",
        ),
        (|stand| stand.inputs.speed.value = 5000.0 * std::f64::consts::TAU / 60.0, 8, "the lever would have to pull"),
        (
            // Soft asperities under 32 MPa.
            |stand| {
                stand.load.lever_ratio = 0.0;
                stand.inputs.external_force.value = 15_000.0;
                stand.bearing.surface.composite_modulus = 1e9;
                stand.thermal.isothermal = true;
            },
            16,
            "beyond the surfaces' own height",
        ),
        (
            // 0.3 um in 0.4 mm.
            |stand| {
                stand.load.lever_ratio = 0.0;
                stand.inputs.external_force.value = 500.0;
                stand.inputs.speed.value = 1.0;
                stand.bearing.radial_clearance = 4e-4;
                stand.bearing.surface.roughness = 3e-7;
                stand.thermal.isothermal = true;
            },
            16,
            "finer than the mobility film's table",
        ),
    ];
    for (choose, bit, words) in limits {
        let (bits, said) = run(choose);
        assert_ne!(bits & bit, 0, "{words}: {bits}");
        let told = said.iter().filter(|text| text.contains(words));
        assert_eq!(told.count(), 1, "{said:?}");
    }
}

/// A lever that has lifted off leaves the external force alone on the bearing, and no negative load.
#[test]
fn a_lever_that_lifts_off_does_not_pull() {
    let mut stand = Stand::default();
    stand.inputs.speed.value = 5000.0 * std::f64::consts::TAU / 60.0;
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    let mut least = f64::INFINITY;
    for k in 0..240 {
        stand.advance(f64::from(k) * 1e-4, 1e-4, &mut ()).unwrap();
        least = least.min(stand.readings().load_force);
        assert!(stand.readings().friction_coefficient >= 0.0);
    }
    assert_eq!(least, 0.0);
}

/// A thin film in a Reynolds film of few columns is told, with the number that would do; the rig's is not.
#[test]
fn a_film_thinner_than_its_columns_follow_is_told() {
    let of = |columns: i32, clearance: f64| {
        let mut stand = Stand::default();
        stand.film.model = plain_bearing_stand::bearing::FilmModel::Reynolds;
        stand.bearing.resolution.columns = columns;
        stand.bearing.radial_clearance = clearance;
        stand.bearing.surface.roughness = 0.0;
        stand.thermal.isothermal = true;
        stand.load.lever_ratio = 0.0;
        stand.inputs.external_force.value = 1000.0;
        stand.initialise(&Experiment::default(), &mut ()).unwrap();
        stand.advance(0.0, 1.0, &mut ()).unwrap();
        stand.validity()
    };
    assert_eq!([of(96, 1e-4), of(240, 1e-4), of(96, 2e-5)], [32, 0, 0]);
}
