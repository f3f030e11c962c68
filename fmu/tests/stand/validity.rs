//! Limits that a run passes, which `status.validity` and the log tell.

use fmu_export::model::{Continuous, Experiment, Log, Model};
use journal_bearing::rheology::PressureLaw;
use plain_bearing_stand::bearing::{Feeding, FilmModel};
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
    let limits: [(Choose, i32, &str); 12] = [
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
        (
            // Asperities alone: under 45 kN the film bears next to nothing.
            |stand| {
                stand.inputs.external_force.value = 45_000.0;
                stand.thermal.isothermal = true;
                stand.bearing.pressure_limit = 1.2e8;
            },
            4,
            "of asperities",
        ),
        (
            // SAE 15W-40 at -72 degC: beyond 2e7 mm2/s.
            |stand| {
                stand.thermal.isothermal = true;
                stand.thermal.initial_oil = 201.15;
                stand.thermal.initial_bearing = 201.15;
                stand.inputs.speed.value = 1e-6;
            },
            2,
            "ends at 2e1 m2/s",
        ),
        (|stand| stand.bearing.width = 0.25, 64, "diameters wide"),
        (
            |stand| {
                stand.film.model = FilmModel::Reynolds;
                stand.bearing.resolution.rows = 1;
            },
            64,
            "row of cells",
        ),
        (
            |stand| {
                stand.film.model = FilmModel::Reynolds;
                stand.bearing.supply.feed = Feeding::AxialGrooves;
                stand.bearing.supply.angle = 0.3;
            },
            64,
            "where a feed is",
        ),
        (|stand| stand.bearing.radial_clearance = 1e-5, 128, "touch all around"),
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
        stand.film.model = FilmModel::Reynolds;
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

/// The pressure law ends at e^5; the film's largest pressure under this load is beyond it.
#[test]
fn the_end_of_a_pressure_law_is_told() {
    let of = |coefficient: f64| {
        run(|stand| {
            stand.film.model = FilmModel::Reynolds;
            stand.oil.thickening.pressure_law = PressureLaw::Barus;
            stand.oil.thickening.pressure_coefficient = coefficient;
            stand.bearing.surface.roughness = 0.0;
            stand.thermal.isothermal = true;
        })
        .0 & 64
    };
    assert_eq!([of(2e-8), of(1e-6)], [0, 64]);
}

/// A feed away from the contact sets no bit.
#[test]
fn a_feed_away_from_the_contact_sets_no_bit() {
    let (bits, said) = run(|stand| {
        stand.film.model = FilmModel::Reynolds;
        stand.bearing.supply.feed = Feeding::AxialGrooves;
    });
    assert_eq!(bits & 64, 0, "{said:?}");
}

/// A load that swings within each turn, and a limit that only its peaks pass.
fn swinging(stand: &mut Stand) {
    stand.load.eccentricity = 1e-3;
    stand.load.phase += std::f64::consts::PI;
    stand.bearing.surface.roughness = 0.0;
    stand.bearing.pressure_limit = limit();
}

/// Midway between the pressure after whole turns and the largest one within 0.6 s, Pa, by short steps.
fn limit() -> f64 {
    static LIMIT: std::sync::LazyLock<f64> = std::sync::LazyLock::new(|| {
        let mut stand = Stand::default();
        stand.load.eccentricity = 1e-3;
        stand.load.phase += std::f64::consts::PI;
        stand.bearing.surface.roughness = 0.0;
        stand.initialise(&Experiment::default(), &mut ()).unwrap();
        let peak = (0..600).fold(0.0, |peak: f64, k| {
            stand.advance(f64::from(k) * 1e-3, 1e-3, &mut ()).unwrap();
            peak.max(stand.readings().max_film_pressure)
        });
        0.5 * (peak + stand.readings().max_film_pressure)
    });
    *LIMIT
}

/// One history by steps of 0.2 ms to 60 s, with and without leaps, both films.
#[test]
fn the_bits_do_not_depend_on_the_communication_step() {
    let run = |step: f64, multirate: bool, model: FilmModel, span: f64| {
        let mut stand = Stand::default();
        swinging(&mut stand);
        (stand.solver.multirate, stand.film.model) = (multirate, model);
        stand.initialise(&Experiment::default(), &mut ()).unwrap();
        for k in 0..(span / step).round() as i32 {
            stand.advance(f64::from(k) * step, step, &mut ()).unwrap();
        }
        (stand.validity(), stand.readings().max_film_pressure)
    };
    let (expected, last) = run(0.2, false, FilmModel::Mobility, 0.6);
    assert!(expected & 4 != 0 && last < limit(), "{expected} {last}: a limit passed only between communication points");
    for (step, span) in [(2e-4, 0.6), (2e-3, 0.6), (0.6, 0.6), (4.0, 60.0), (60.0, 60.0)] {
        for multirate in [true, false] {
            if span < 1.0 || multirate {
                assert_eq!(run(step, multirate, FilmModel::Mobility, span).0, expected, "{step} {multirate}");
            }
        }
    }
    let expected = run(2e-3, false, FilmModel::Reynolds, 0.4).0;
    assert_ne!(expected & 4, 0);
    assert_eq!(run(0.4, false, FilmModel::Reynolds, 0.4).0, expected);
    assert_eq!(run(8.0, true, FilmModel::Reynolds, 8.0).0, expected);
}

/// In Model Exchange the host's completed steps show the same, and ask for the event mode where a bit is new.
#[test]
fn completed_steps_tell_limits_in_model_exchange() {
    let complete = Stand::COMPLETE.expect("the stand wants to know of completed steps");
    let mut stand = Stand::default();
    swinging(&mut stand);
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    assert_eq!(stand.validity(), 0);
    let mut y: Vec<f64> = Stand::states().iter().map(|state| (state.get)(&stand)).collect();
    let (mut rates, mut said, mut events) = (vec![0.0; y.len()], Said::default(), 0);
    let h = 1e-5;
    for k in 1..60_000 {
        Continuous::rates(&stand, &mut rates).unwrap();
        y.iter_mut().zip(&rates).for_each(|(y, rate)| *y += h * rate);
        stand.set_time(f64::from(k) * h);
        for (state, value) in Stand::states().iter().zip(&y) {
            (state.set)(&mut stand, *value);
        }
        events += i32::from(complete(&mut stand, &mut said));
    }
    let (bits, told) = {
        let mut other = Stand::default();
        swinging(&mut other);
        let mut said = Said::default();
        other.initialise(&Experiment::default(), &mut ()).unwrap();
        other.advance(0.0, 0.6, &mut said).unwrap();
        (other.validity(), said.0.len())
    };
    assert_ne!(bits & 4, 0);
    assert_eq!((stand.validity(), said.0.len()), (bits, told));
    assert!(events >= 1 && events <= told as i32);
}
