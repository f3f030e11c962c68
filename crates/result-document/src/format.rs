//! Numbers and text for people.

use std::ops::Range;

/// A number, rounded to significant digits, without needless zeros: `0.02`, `1.5e−7`, `843.84`.
/// Numbers that are none are written as a dash.
pub fn number(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return DASH.into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞".into() } else { "−∞".into() };
    }
    if value == 0.0 {
        return "0".into();
    }
    rounded(value, digits, -4..7).replacen('-', "−", 1).replace("e-", "e−")
}

/// A number, rounded to significant digits, as programs write it: `1.5e-7`, `-843.84`.
pub fn significant(value: f64, digits: usize) -> String {
    rounded(value, digits, -5..6)
}

/// A number with an exponent of ten, unless that lies in a range.
fn rounded(value: f64, digits: usize, plain: Range<i32>) -> String {
    let digits = digits.max(1);
    // The exponent after rounding: 9.996 with three digits is 10.0.
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if plain.contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        trim(&format!("{value:.decimals$}")).to_owned()
    } else {
        format!("{}e{exponent}", trim(mantissa))
    }
}

fn trim(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// The significant digits that tell the ends of an interval apart by a hundredth of its width: 6 to 15.
pub fn digits_between([low, high]: [f64; 2]) -> usize {
    let part = low.abs().max(high.abs()) / (high - low);
    let more = if part.is_finite() && part > 1.0 { part.log10().ceil() as usize + 2 } else { 0 };
    more.clamp(6, 15)
}

/// The number, or 0 where it differs from 0 by less than a millionth of what matters.
pub fn cleared(number: f64, matters: f64) -> f64 {
    const NOTHING: f64 = 1e-6;
    if number.abs() < NOTHING * matters { 0.0 } else { number }
}

/// A unit as it stands behind a number: nothing for a number without one.
pub fn shown(unit: &Option<String>) -> &str {
    unit.as_deref().filter(|unit| *unit != "1").unwrap_or("")
}

/// A fraction as per cent with one decimal. One that would else read as 0 or 100 has as many as tell it from them; beyond 99.9999 it
/// is told as that.
pub fn percent_text(fraction: f64) -> String {
    let p = fraction * 100.0;
    if p == 0.0 || p == 100.0 {
        format!("{p:.0}")
    } else if (0.1..=99.9).contains(&p) {
        format!("{p:.1}")
    } else if p < 50.0 || p.is_nan() {
        number(p, 1)
    } else {
        significant(if p < 100.0 { p.min(99.9999) } else { p }, 6)
    }
}

/// What stands where there is nothing to say.
pub const DASH: &str = "–";

/// A name with its unit in brackets; the name alone when dimensionless.
pub fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { name.to_owned() } else { format!("{name} ({unit})") }
}

/// Text made safe inside XML and HTML, attributes included.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(number(0.02, 4), "0.02");
        assert_eq!(number(843.84, 4), "843.8");
        assert_eq!(number(-9.996, 3), "−10");
        assert_eq!(number(1.5e-7, 4), "1.5e−7");
        assert_eq!(number(321.15, 6), "321.15");
        assert_eq!(number(f64::NAN, 3), "–");
        assert_eq!(number(1_234_567.0, 3), "1234567");
    }

    #[test]
    fn per_cent_never_hides_a_rare_event() {
        assert_eq!(percent_text(0.2), "20.0");
        assert_eq!(percent_text(0.0), "0");
        assert_eq!(percent_text(0.000_02), "0.002");
        assert_eq!(percent_text(0.99999), "99.999");
        assert_eq!(percent_text(0.999_999_6), "99.9999");
        assert_eq!(percent_text(0.999_999_999_7), "99.9999");
        assert_eq!((&*percent_text(1.05), &*percent_text(0.9992)), ("105", "99.92"));
        assert_eq!(percent_text(f64::NAN), "–");
    }

    #[test]
    fn small_and_large_numbers_have_the_digits_asked_for() {
        assert_eq!([significant(1e-7, 2), significant(1.2345e9, 3)], ["1e-7", "1.23e9"]);
        assert_eq!([significant(-0.012_34, 2), significant(293.154, 5)], ["-0.012", "293.15"]);
    }
}
