use plain_bearing_stand::bearing::{Expansion, ThermalClearance};

const RADII: [f64; 2] = [0.0125, 0.01248];

/// A bush of bronze in a housing of steel.
fn bronze() -> Expansion {
    Expansion { bush: 18e-6, bush_modulus: 110e9, ..Expansion::default() }
}

fn growth(thermal_clearance: ThermalClearance, set: impl FnOnce(&mut Expansion)) -> f64 {
    let mut expansion = Expansion { thermal_clearance, ..bronze() };
    set(&mut expansion);
    expansion.growth(RADII, [353.15, 363.15])
}

use ThermalClearance::{ConstrainedBush, FreeBush, Off};

/// 60 K on the bore's 12.5 mm at 18e-6/K are 13.5 um, 70 K on the shaft's 12.48 mm at 11.5e-6/K are 10.0464 um.
#[test]
fn a_free_bush_and_its_shaft_grow_with_their_temperatures() {
    assert_eq!(growth(Off, |_| ()), 0.0);
    assert!((growth(FreeBush, |_| ()) - (13.5e-6 - 10.0464e-6)).abs() < 1e-15);
}

/// Parts of one material at one temperature stay similar: the clearance grows like every other length.
#[test]
fn one_material_at_one_temperature_keeps_its_shape() {
    for fit in [FreeBush, ConstrainedBush] {
        let expansion =
            Expansion { thermal_clearance: fit, bush: 20e-6, shaft: 20e-6, housing: 20e-6, ..Expansion::default() };
        let grown = expansion.growth(RADII, [393.15, 393.15]);
        assert!((grown - 20e-6 * 20e-6 * 100.0).abs() < 1e-15, "{grown}");
    }
}

#[test]
fn a_housing_that_expands_alike_or_is_soft_leaves_the_bush_free() {
    let free = growth(FreeBush, |_| ());
    let alike = growth(ConstrainedBush, |e| e.housing = e.bush);
    assert!((alike - free).abs() < 1e-18, "{alike} {free}");
    let soft = growth(ConstrainedBush, |e| e.housing_modulus = 1e-9 * e.bush_modulus);
    assert!((soft - free).abs() < 1e-8 * free, "{soft} {free}");
}

/// A rigid housing sets the outer radius b. The bush's free growth exceeds the housing's by the strain `d`, and an outer
/// displacement of `-b*d` moves the bore by `-a*d*2b^2/(b^2 + a^2 - nu*(b^2 - a^2))`.
#[test]
fn a_rigid_housing_sets_the_outer_radius() {
    let rigid = growth(ConstrainedBush, |e| e.housing_modulus = 1e9 * e.bush_modulus);
    let (a2, b2) = (12.5_f64.powi(2), 15_f64.powi(2));
    let inwards = 6.5e-6 * 60.0 * 2.0 * b2 / (b2 + a2 - 0.3 * (b2 - a2));
    let expected = 0.0125 * (18e-6 * 60.0 - inwards) - 10.0464e-6;
    assert!((rigid - expected).abs() < 1e-13, "{rigid} {expected}");
    // A thin bush has the bore of its housing.
    let thin = growth(ConstrainedBush, |e| {
        e.wall = 1e-8;
        e.housing_modulus = 1e9 * e.bush_modulus;
    });
    let of_the_housing = 0.0125 * 11.5e-6 * 60.0 - 10.0464e-6;
    assert!((thin - of_the_housing).abs() < 1e-10, "{thin}");
}

/// Radii, stresses and displacements of both cylinders in numbers: an own solution of the three conditions (free bore, equal
/// pressures, equal displacements) for the four constants of `u = A*r + B/r` in bush and housing.
#[test]
fn the_pressure_joins_bush_and_housing() {
    let held = growth(ConstrainedBush, |_| ());
    let e = bronze();
    let (a, b, nu) = (0.0125_f64, 0.015_f64, 0.3);
    // Bush: sigma_r = E/(1-nu) A - E/(1+nu) B/r^2 beyond the thermal strain; zero at a.
    let of_b = |r: f64| e.bush_modulus * ((1.0 / a.powi(2) - 1.0 / r.powi(2)) / (1.0 + nu));
    // A = B (1-nu)/(1+nu)/a^2 from the free bore, and the housing u = C/r with sigma_r = -E/(1+nu) C/r^2.
    let slope = (1.0 - nu) / (1.0 + nu) / a.powi(2);
    // Equal stress at b: of_b(b)*B = -E_h/(1+nu)*C/b^2; equal displacement: (slope*b + 1/b)*B + d*b = C/b.
    let d = (e.bush - e.housing) * 60.0;
    let c_over_b = -of_b(b) * b.powi(2) * (1.0 + nu) / e.housing_modulus;
    let constant = d * b / (c_over_b / b - (slope * b + 1.0 / b));
    let expected = constant * (slope * a + 1.0 / a) + a * e.bush * 60.0 - 10.0464e-6;
    assert!((held - expected).abs() < 1e-14, "{held} {expected}");
}
