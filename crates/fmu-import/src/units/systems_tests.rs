//! Thirty unit systems of FMUs: usual, unusual, contradictory, incomplete ones, with offsets, with and without rad. What is
//! expected is the arithmetic of FMI 2.0.4, 2.2.2, by hand: base = factor value + offset, display = factor value + offset.

use super::*;

const TURN: f64 = std::f64::consts::TAU;

/// A unit, its base units as kg, m, s, A, K, mol, cd, rad with factor and offset, and its display units.
type Own = (&'static str, Option<([i32; 8], f64, f64)>, &'static [(&'static str, f64, f64)]);

const METRE: [i32; 8] = [0, 1, 0, 0, 0, 0, 0, 0];
const SECOND: [i32; 8] = [0, 0, 1, 0, 0, 0, 0, 0];
const PER_SECOND: [i32; 8] = [0, 0, -1, 0, 0, 0, 0, 0];
const TURNING: [i32; 8] = [0, 0, -1, 0, 0, 0, 0, 1];
const RAD: [i32; 8] = [0, 0, 0, 0, 0, 0, 0, 1];
const KILOGRAM: [i32; 8] = [1, 0, 0, 0, 0, 0, 0, 0];
const KELVIN: [i32; 8] = [0, 0, 0, 0, 1, 0, 0, 0];
const JOULE: [i32; 8] = [1, 2, -2, 0, 0, 0, 0, 0];
const PASCAL: [i32; 8] = [1, -1, -2, 0, 0, 0, 0, 0];
const NONE: [i32; 8] = [0; 8];

fn units(own: &[Own]) -> Units {
    let unit = |&(name, base, display): &Own| {
        let base =
            base.map(|(exponents, factor, offset)| BaseUnit { exponents, to_base: Conversion { factor, offset } });
        let shown = |&(name, factor, offset): &(&str, f64, f64)| DisplayUnit {
            name: name.to_owned(),
            from_unit: Conversion { factor, offset },
        };
        (name.to_owned(), Unit { base, display: display.iter().map(shown).collect() })
    };
    Units(own.iter().map(unit).collect())
}

/// What a value becomes; `None` is refused.
fn check(own: &[Own], from: &str, to: Option<&str>, value: f64, expected: Option<f64>) {
    let got = units(own).conversion(from, to).ok().map(|way| way.value(value));
    let close = match (got, expected) {
        (Some(got), Some(expected)) => (got - expected).abs() <= 1e-12 * expected.abs().max(1.0),
        (got, expected) => got == expected,
    };
    assert!(close, "{value} {from} in {to:?} of {own:?}: {got:?}, expected {expected:?}");
}

#[test]
fn usual_systems() {
    let metre: &[Own] = &[("m", Some((METRE, 1.0, 0.0)), &[("mm", 1e3, 0.0)])];
    check(metre, "mm", Some("m"), 5.0, Some(5e-3));
    check(metre, "um", Some("m"), 5.0, Some(5e-6));
    let kelvin: &[Own] = &[("K", Some((KELVIN, 1.0, 0.0)), &[("degC", 1.0, -273.15)])];
    check(kelvin, "°C", Some("K"), 20.0, Some(293.15));
    check(kelvin, "degF", Some("K"), 212.0, Some(373.15));
    let turning: &[Own] = &[("rad/s", Some((TURNING, 1.0, 0.0)), &[])];
    check(turning, "rpm", Some("rad/s"), 60.0, Some(TURN));
    check(turning, "Hz", Some("rad/s"), 1.0, None);
    check(turning, "1/s", Some("rad/s"), 1.0, None);
    check(turning, "rev/s", Some("rad/s"), 1.0, Some(TURN));
    check(&[("Pa", Some((PASCAL, 1.0, 0.0)), &[])], "bar", Some("Pa"), 1.5, Some(1.5e5));
}

#[test]
fn what_the_fmu_defines_is_never_overridden() {
    let speeds: &[Own] = &[("1/s", Some((PER_SECOND, 1.0, 0.0)), &[]), ("rad/s", Some((TURNING, 1.0, 0.0)), &[])];
    check(speeds, "1/s", Some("rad/s"), 1.0, None);
    check(speeds, "rad/s", Some("1/s"), 1.0, None);
    check(speeds, "rpm", Some("1/s"), 60.0, Some(1.0));
    check(speeds, "rpm", Some("rad/s"), 60.0, Some(TURN));
    let height: &[Own] = &[("h", Some((METRE, 1.0, 0.0)), &[])];
    check(height, "s", Some("h"), 60.0, None);
    check(height, "mm", Some("h"), 60.0, Some(0.06));
    let gravity: &[Own] = &[("g", Some(([0, 1, -2, 0, 0, 0, 0, 0], 9.81, 0.0)), &[])];
    check(gravity, "kg", Some("g"), 1.0, None);
    check(gravity, "m/s2", Some("g"), 9.81, Some(1.0));
    // The FMU's day has ten hours.
    let day: &[Own] = &[("s", Some((SECOND, 1.0, 0.0)), &[]), ("d", Some((SECOND, 36_000.0, 0.0)), &[])];
    check(day, "d", Some("s"), 2.0, Some(72_000.0));
    // The FMU's minute is an arc, shown of rad; it is no time.
    let arc: &[Own] = &[("rad", Some((RAD, 1.0, 0.0)), &[("min", 3437.75, 0.0)]), ("s", Some((SECOND, 1.0, 0.0)), &[])];
    check(arc, "min", Some("s"), 1.0, None);
    check(arc, "min", Some("rad"), 3437.75, Some(1.0));
    check(&[("%", Some((METRE, 1.0, 0.0)), &[])], "%", None, 5.0, None);
}

#[test]
fn complete_base_units_convert_to_and_from_si() {
    let cel: &[Own] = &[("cel", Some((KELVIN, 1.0, 273.15)), &[])];
    check(cel, "degC", Some("cel"), 20.0, Some(20.0));
    check(cel, "K", Some("cel"), 293.15, Some(20.0));
    check(&[("t", Some((KILOGRAM, 1000.0, 0.0)), &[])], "kg", Some("t"), 500.0, Some(0.5));
    let kcal: &[Own] = &[("kcal", Some((JOULE, 4184.0, 0.0)), &[])];
    check(kcal, "J", Some("kcal"), 4184.0, Some(1.0));
    check(kcal, "kcal", Some("J"), 1.0, Some(4184.0));
    check(&[("furlong", Some((METRE, 201.168, 0.0)), &[])], "furlong", Some("km/h"), 1.0, None);
    check(&[("furlong", Some((METRE, 201.168, 0.0)), &[])], "furlong", Some("m"), 1.0, Some(201.168));
    let rankine: &[Own] = &[("R", Some((KELVIN, 5.0 / 9.0, 0.0)), &[])];
    check(rankine, "degC", Some("R"), 0.0, Some(491.67));
    let gauge: &[Own] = &[("barg", Some((PASCAL, 1e5, 101_325.0)), &[])];
    check(gauge, "Pa", Some("barg"), 201_325.0, Some(1.0));
}

#[test]
fn angles_without_rad() {
    // rad left out: the name says what it is.
    let bare: &[Own] = &[("rad/s", Some((PER_SECOND, 1.0, 0.0)), &[])];
    check(bare, "rpm", Some("rad/s"), 60.0, Some(TURN));
    check(&[("rpm", Some((PER_SECOND, TURN / 60.0, 0.0)), &[])], "rad/s", Some("rpm"), TURN, Some(60.0));
    check(&[("rpm", Some((PER_SECOND, 1.0 / 60.0, 0.0)), &[])], "Hz", Some("rpm"), 1.0, Some(60.0));
    // The name says nothing: 2 pi stays open.
    check(&[("omega", Some((PER_SECOND, 1.0, 0.0)), &[])], "rpm", Some("omega"), 60.0, None);
    check(&[("omega", Some((TURNING, 1.0, 0.0)), &[])], "rad/s", Some("omega"), 2.0, Some(2.0));
    check(&[("deg", Some((NONE, TURN / 360.0, 0.0)), &[])], "rad", Some("deg"), TURN, Some(360.0));
}

#[test]
fn no_unit_and_per_cent() {
    check(&[], "%", None, 5.0, Some(0.05));
    check(&[("%", Some((NONE, 0.01, 0.0)), &[])], "%", None, 5.0, Some(0.05));
    check(&[("%", Some((NONE, 0.01, 0.0)), &[])], "1", Some("%"), 0.05, Some(5.0));
    check(&[("ppm", Some((NONE, 1e-6, 0.0)), &[])], "ppm", None, 7.0, Some(7e-6));
    check(&[], "m", None, 5.0, None);
}

/// An FMU may define `1` or `-` as anything: that is the unit of variables that name it, never of those without a unit.
#[test]
fn a_defined_unit_named_like_a_number_is_not_no_unit() {
    for name in ["1", "-"] {
        let hundredth: &[Own] = &[(name, Some((NONE, 0.01, 0.0)), &[])];
        check(hundredth, "%", None, 5.0, Some(0.05));
        check(hundredth, "%", Some(""), 5.0, Some(0.05));
        check(hundredth, "%", Some(name), 5.0, Some(5.0));
        check(hundredth, name, Some(name), 5.0, Some(5.0));
        // Written behind a value it is what the FMU says.
        check(hundredth, name, None, 5.0, Some(0.05));
        let metre: &[Own] = &[(name, Some((METRE, 1e-3, 0.0)), &[])];
        check(metre, "%", None, 5.0, Some(0.05));
        check(metre, "m", None, 5.0, None);
        check(metre, "m", Some(name), 5.0, Some(5e3));
        check(metre, "%", Some(name), 5.0, None);
        check(metre, name, None, 5.0, None);
        let number: &[Own] = &[(name, Some((NONE, 1.0, 0.0)), &[])];
        check(number, "%", Some(name), 5.0, Some(0.05));
        check(number, name, None, 5.0, Some(5.0));
        // A factor of 0 converts nothing.
        check(&[(name, Some((NONE, 0.0, 0.0)), &[])], "%", Some(name), 5.0, None);
        check(&[(name, Some((NONE, 0.0, 0.0)), &[])], "%", None, 5.0, Some(0.05));
    }
    let both: &[Own] = &[("1", Some((METRE, 1.0, 0.0)), &[]), ("%", Some((METRE, 0.01, 0.0)), &[])];
    let error = units(both).conversion("kg", None).unwrap_err().to_string();
    assert!(error.contains("the value is in no unit; use a number alone"), "{error}");
}

#[test]
fn incomplete_systems_take_the_usual_meaning() {
    check(&[("N.m", None, &[])], "N.mm", Some("N.m"), 5.0, Some(5e-3));
    check(&[], "kN", Some("N"), 2.0, Some(2e3));
    check(&[("K", None, &[("degC", 1.0, -273.15)])], "degF", Some("K"), 32.0, Some(273.15));
    check(&[("K", None, &[("degC", 1.0, -273.15)])], "degC", Some("K"), 20.0, Some(293.15));
    check(&[("foo", None, &[])], "m", Some("foo"), 1.0, None);
    // A factor of 0 converts nothing, and the usual meaning does not take its place.
    check(&[("m", Some((METRE, 0.0, 0.0)), &[])], "mm", Some("m"), 1.0, None);
    check(&[("m", Some((METRE, 1.0, 0.0)), &[("mm", 0.0, 0.0)])], "mm", Some("m"), 1.0, None);
}
