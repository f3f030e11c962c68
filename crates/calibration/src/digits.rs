//! Numbers as people read them.

/// A number with six significant digits.
pub fn digits(number: f64) -> Digits {
    Digits(number, 6)
}

/// A unit as it stands behind a number: nothing for a number without one.
pub(crate) fn shown(unit: &Option<String>) -> &str {
    unit.as_deref().filter(|unit| *unit != "1").unwrap_or("")
}

/// A number, shown with the given count of significant digits.
pub struct Digits(pub(super) f64, pub(super) i32);

impl Digits {
    /// A number with so many significant digits.
    pub fn of(number: f64, significant: i32) -> Self {
        Self(number, significant)
    }
}

impl std::fmt::Display for Digits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let significant = self.1;
        let magnitude = match self.0 {
            0.0 => 0,
            number => number.abs().log10().floor() as i32,
        };
        let rounded = if (-5..6).contains(&magnitude) {
            let places = (significant - 1 - magnitude).max(0) as usize;
            format!("{:.places$}", self.0)
        } else {
            format!("{:.5e}", self.0)
        };
        let plain = match rounded.contains('.') && !rounded.contains('e') {
            true => rounded.trim_end_matches('0').trim_end_matches('.'),
            false => &rounded,
        };
        let is_signed = f.sign_plus() && self.0 >= 0.0;
        let plus = if is_signed { "+" } else { "" };
        let width = f.width().unwrap_or(0);
        write!(f, "{:>width$}", format!("{plus}{plain}"))
    }
}
