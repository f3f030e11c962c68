use plain_bearing_stand::thermal::{Heat, Temperatures, Thermal};

#[test]
fn energy_is_conserved() {
    let thermal = Thermal { bush_ambient: 0.1, shaft_ambient: 0.05, ..Thermal::default() };
    let t = Temperatures { film: 360.0, bush: 355.0, shaft: 354.0, oil: 321.0 };
    let heat = Heat {
        viscous: 2.0,
        boundary: 12.0,
        side_flow: 0.13,
        fed: 0.05,
        fed_temperature: 310.0,
        bath: 517.0,
        ambient: 295.0,
        clearance: 1.4e-5,
    };
    let r = thermal.rates(&t, &heat);
    let stored = r.film * thermal.film_capacity
        + r.bush * thermal.bush_capacity
        + r.shaft * thermal.shaft_capacity
        + r.oil * heat.bath;
    let lost = 0.1 * (t.bush - 295.0) + 0.05 * (t.shaft - 295.0) + thermal.oil_ambient * (t.oil - 295.0);
    let spilt = 0.05 * (t.oil - 310.0);
    assert!((stored + lost + spilt - heat.viscous - heat.boundary).abs() < 1e-10);
}
