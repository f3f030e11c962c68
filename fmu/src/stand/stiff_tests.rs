use fmu_export::model::{Experiment, Model};
use plain_bearing_stand::stand::{SCALES, Stand};

/// In a case that is not stiff, implicit and explicit steps give the same, also while speed and load change.
#[test]
fn implicit_and_explicit_steps_agree() {
    let mut stand = Stand::default();
    let experiment = Experiment::default();
    assert!(stand.initialise(&experiment, &mut ()).is_ok());
    assert!(stand.advance(0.0, 0.5, &mut ()).is_ok());
    stand.inputs.speed.slope = 20.0;
    stand.inputs.external_force.slope = -300.0;
    let allowed = SCALES.map(|scale| 1e-8 * scale);
    let implicit = stand.resolve_stiffly(0.3, &allowed, |_, _| ()).unwrap_or_default();
    stand.solver.tolerance = 1e-9;
    assert!(stand.advance(0.5, 0.3, &mut ()).is_ok());
    let now = stand.readings();
    let (y, x) = now.attitude_angle.sin_cos();
    let explicit = [
        now.eccentricity_ratio * x,
        now.eccentricity_ratio * y,
        now.film_temperature,
        now.bearing_temperature,
        now.shaft_temperature,
        now.oil_temperature,
        now.wear_depth,
    ];
    for i in 0..7 {
        let apart = (implicit[i] - explicit[i]).abs() / SCALES[i];
        assert!(apart < 1e-6, "{i}: {implicit:?} {explicit:?}");
    }
}
