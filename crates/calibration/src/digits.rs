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
        let decimals = (significant - 1).max(0) as usize;
        return format!("{number:.decimals$e}");
    }
    let places = (significant - 1 - magnitude).max(0) as usize;
    let text = format!("{number:.places$}");
    match places {
        0 => text,
        _ => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
    }
}

/// The digits that tell the ends of an interval apart by a hundredth of its width, and six at least.
pub fn enough([low, high]: [f64; 2]) -> i32 {
    let part = low.abs().max(high.abs()) / (high - low);
    let more = if part.is_finite() && part > 1.0 { part.log10().ceil() as i32 + 2 } else { 0 };
    more.clamp(6, 15)
}

/// The number, or 0 where it differs from 0 by less than a millionth of what matters.
pub fn cleared(number: f64, matters: f64) -> f64 {
    const NOTHING: f64 = 1e-6;
    if number.abs() < NOTHING * matters { 0.0 } else { number }
}

/// A unit as it stands behind a number: nothing for a number without one.
pub(crate) fn shown(unit: &Option<String>) -> &str {
    unit.as_deref().filter(|unit| *unit != "1").unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_numbers_have_the_digits_asked_for() {
        assert_eq!([rounded(1e-7, 2), rounded(1.2345e9, 3)], ["1.0e-7", "1.23e9"]);
    }
}
