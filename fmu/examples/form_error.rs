//! How far form error and tilt raise the friction of the Reynolds film: the table in `docs/film.md`.
//!
//!     cargo run --release -p plain-bearing-stand --example form_error

use fmu_export::model::{Experiment, Fault, Model};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::stand::Stand;
use std::path::Path;

/// Angle of the lobes against the load line, rad: one that closes the gap stands where the journal runs.
const LOBE_PHASE: f64 = 2.5;
/// Amplitude of the bush's three lobes, roughness, and displacement of the journal's end by its tilt along the load, m.
const CASES: [(f64, f64, f64); 8] = [
    (0.0, 0.0, 0.0),
    (2e-6, 0.0, 0.0),
    (4e-6, 0.0, 0.0),
    (0.0, 1e-6, 0.0),
    (4e-6, 1e-6, 0.0),
    (0.0, 1e-6, 5e-6),
    (0.0, 1e-6, 15e-6),
    (4e-6, 1e-6, 15e-6),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("| lobes, um | roughness, um | tilt, um | smallest gap, um | friction coefficient |");
    println!("|---|---|---|---|---|");
    let file = std::env::temp_dir().join("plain-bearing-form-error.csv");
    for (amplitude, roughness, tilt) in CASES {
        let lobes = (0..72).map(|i| {
            let angle = 5.0 * f64::from(i);
            format!("{angle},{},0\n", 1e6 * amplitude * (3.0 * angle.to_radians() + LOBE_PHASE).cos())
        });
        std::fs::write(&file, format!("angle,bush,journal\n{}", lobes.collect::<String>()))?;
        let stand = settled(&file, roughness, tilt)?;
        let r = stand.readings();
        println!(
            "| {:.0} | {:.1} | {:.0} | {:.2} | {:.5} |",
            1e6 * amplitude,
            1e6 * roughness,
            1e6 * tilt,
            1e6 * r.min_film_thickness,
            r.friction_coefficient
        );
    }
    Ok(std::fs::remove_file(&file)?)
}

/// The journal after four turns under a constant load of 750 N at the rig's temperature.
fn settled(profile: &Path, roughness: f64, tilt: f64) -> Result<Stand, Fault> {
    let mut stand = Stand::default();
    stand.film.model = FilmModel::Reynolds;
    stand.bearing.profile_file = profile.display().to_string();
    stand.bearing.surface.roughness = roughness;
    stand.bearing.resolution.tilt[0] = tilt;
    stand.thermal.isothermal = true;
    stand.load.eccentricity = 0.0;
    stand.load.stiffness = 0.0;
    stand.load.preload = 750.0 / stand.load.lever_ratio;
    let experiment = Experiment::default();
    stand.initialise(&experiment, &mut ())?;
    for i in 0..40 {
        stand.advance(0.02 * f64::from(i), 0.02, &mut ())?;
    }
    Ok(stand)
}
