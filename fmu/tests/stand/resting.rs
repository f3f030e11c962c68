//! Stiffness and damping of the stand's films.

use fmu_export::model::{Experiment, Log, Model};
use nalgebra::Vector2;
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::stand::Stand;

/// The isothermal stand under a constant load, N, after some seconds.
fn settled(load: f64, choose: impl Fn(&mut Stand)) -> Stand {
    let mut stand = Stand::default();
    stand.thermal.isothermal = true;
    stand.load.lever_ratio = 0.0;
    stand.inputs.external_force.value = load;
    choose(&mut stand);
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    stand.advance(0.0, 10.0, &mut ()).unwrap();
    stand
}

/// Where the journal is, m.
fn place(stand: &Stand) -> Vector2<f64> {
    let readings = stand.readings();
    let (sin, cos) = readings.attitude_angle.sin_cos();
    Vector2::new(cos, sin) * (readings.eccentricity_ratio * readings.hot_radial_clearance)
}

/// In a smooth bearing and in one whose asperities carry most of the load: a larger load moves the journal as the stiffness
/// says, and both films agree; the Reynolds film without conserved mass, as the mobility map has none.
#[test]
fn both_films_have_the_same_coefficients() {
    for (load, roughness) in [(200.0, 0.0), (700.0, 0.0), (2000.0, 3e-6)] {
        let of = |film: FilmModel, load: f64| {
            settled(load, |stand| {
                stand.film.model = film;
                stand.bearing.surface.roughness = roughness;
                stand.bearing.resolution.mass_conserving = false;
                // The narrowest place between rough surfaces takes more columns than a smooth film.
                if roughness > 0.0 {
                    (stand.bearing.resolution.columns, stand.bearing.resolution.rows) = (192, 16);
                }
            })
        };
        let [mobility, reynolds] = [FilmModel::Mobility, FilmModel::Reynolds].map(|film| {
            let all = of(film, load).resting().coefficients;
            let [more, less] = [1.001, 0.999].map(|part| place(&of(film, part * load)));
            let push = all.stiffness * (more - less) / (0.002 * load);
            assert!((push - Vector2::x()).norm() < 1e-3, "{film:?} at {load} N: {push}");
            all
        });
        for (one, other, bound) in
            [(mobility.stiffness, reynolds.stiffness, 0.01), (mobility.damping, reynolds.damping, 0.02)]
        {
            assert!((one - other).norm() < bound * other.norm(), "{load} N: {one} {other}");
        }
    }
}

/// What was logged.
#[derive(Default)]
struct Said(Vec<String>);

impl Log for Said {
    fn log(&mut self, _: &'static str, message: std::fmt::Arguments<'_>) {
        self.0.push(message.to_string());
    }
}

/// The rig's load swings, so that its journal does not rest: the log says so once.
#[test]
fn a_journal_that_moves_has_none() {
    let mut stand = Stand::default();
    let mut said = Said::default();
    stand.initialise(&Experiment::default(), &mut said).unwrap();
    for k in 0..10 {
        stand.advance(f64::from(k) * 0.01, 0.01, &mut said).unwrap();
        assert_eq!(stand.resting().threshold, 0.0);
        assert_eq!(stand.resting().coefficients.stiffness.norm(), 0.0);
    }
    let told = said.0.iter().filter(|text| text.contains("does not rest"));
    assert_eq!(told.count(), 1);
}
