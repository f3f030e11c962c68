//! Times that are the same but for rounding.

/// Whether two times, s, differ by rounding only.
pub fn are_near(one: f64, other: f64) -> bool {
    (one - other).abs() <= 4.0 * f64::EPSILON * other.abs()
}
