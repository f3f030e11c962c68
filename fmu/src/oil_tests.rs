use fmu_export::model::Experiment;
use plain_bearing_stand::oil::{Nearby, Oil, measured};

#[test]
fn the_law_passes_through_its_points() {
    let oil = Oil::default().through_two_points();
    assert!((oil.kinematic_viscosity(313.15) / 105e-6 - 1.0).abs() < 1e-12);
    assert!((oil.kinematic_viscosity(373.15) / 14.2e-6 - 1.0).abs() < 1e-12);
    assert!((oil.density(288.15) - 880.0).abs() < 1e-12);
}

/// Independent values for this oil by ASTM D341: 63, 18.9 and 7.5 mPa.s, within their printed digits.
#[test]
fn sae_15w40_at_the_rigs_temperatures() {
    let oil = Oil::default().through_two_points();
    for (celsius, expected, digit) in [(48.0, 63e-3, 1e-3), (82.0, 18.9e-3, 0.2e-3), (120.0, 7.5e-3, 0.1e-3)] {
        let viscosity = oil.viscosity(celsius + 273.15);
        assert!((viscosity - expected).abs() <= digit, "{celsius} degC: {viscosity}");
    }
}

#[test]
fn the_polynomial_follows_the_law() {
    let oil = Oil::default().through_two_points();
    for celsius in [-10.0, 20.0, 48.0, 120.0] {
        let mut nearby = Nearby::default();
        for away in [-0.25, -0.15, 0.0, 0.06, 0.25, 30.0] {
            let temperature = celsius + 273.15 + away;
            let ratio = nearby.viscosity(&oil, temperature) / oil.viscosity(temperature);
            assert!((ratio - 1.0).abs() < 1e-13, "{celsius} {away}: {ratio:e}");
        }
    }
}

#[test]
fn the_heat_capacity_is_that_of_mineral_oil() {
    let oil = Oil::default().through_two_points();
    assert!((oil.heat_capacity(321.15) - 2000.0).abs() < 50.0);
}

#[test]
fn measured_rows_of_a_law_give_the_law_back() {
    let law = Oil::default().through_two_points();
    let rows: Vec<_> = [20.0, 40.0, 70.0, 100.0, 130.0]
        .map(|temperature| measured::Row {
            temperature,
            kinematic_viscosity: law.kinematic_viscosity(temperature + 273.15) * 1e6,
            density: law.density(temperature + 273.15),
        })
        .to_vec();
    let fit = Oil::default().fitted(&rows);
    for celsius in [30.0, 82.0, 120.0] {
        let ratio = fit.viscosity(celsius + 273.15) / law.viscosity(celsius + 273.15);
        assert!((ratio - 1.0).abs() < 1e-6, "{celsius}: {ratio}");
    }
}

/// SAE J300 (2021), Table 1: limits of the kinematic viscosity at 100 °C for each grade.
#[test]
fn shipped_grades_are_inside_sae_j300() {
    let resources = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription/resources");
    let experiment = Experiment { start: 0.0, stop: None, tolerance: None, resources: Some(&resources) };
    for (file, least, below) in [
        ("sae-0w-20.csv", 6.9, 9.3),
        ("sae-5w-30.csv", 9.3, 12.5),
        ("sae-10w-40.csv", 12.5, 16.3),
        ("sae-15w-40.csv", 12.5, 16.3),
        ("sae-20w-50.csv", 16.3, 21.9),
    ] {
        let oil = Oil { properties_file: file.into(), ..Oil::default() };
        let at_100 = oil.properties(&experiment).unwrap().kinematic_viscosity(373.15) * 1e6;
        assert!((least..below).contains(&at_100), "{file}: {at_100}");
    }
}
