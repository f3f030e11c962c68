//! Numbers as people read them.

/// A number with six significant digits.
pub fn digits(number: f64) -> String {
    rounded(number, 6)
}

/// A number with the given count of significant digits.
pub fn rounded(number: f64, significant: i32) -> String {
    let magnitude = match number {
        0.0 => 0,
        number => number.abs().log10().floor() as i32,
    };
    if !(-5..6).contains(&magnitude) {
        return format!("{number:.5e}");
    }
    let places = (significant - 1 - magnitude).max(0) as usize;
    let text = format!("{number:.places$}");
    match places {
        0 => text,
        _ => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
    }
}

/// A unit as it stands behind a number: nothing for a number without one.
pub(crate) fn shown(unit: &Option<String>) -> &str {
    unit.as_deref().filter(|unit| *unit != "1").unwrap_or("")
}
