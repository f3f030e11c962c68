//! The uncertainty of a measured mean, after the GUM (JCGM 100:2008): scatter
//! (type A, section 4.2) and sensor accuracy (type B, section 4.3) combined (section 5.1).

use serde::Serialize;

/// A measured quantity with its uncertainty budget.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct MeasuredValue {
    /// The value.
    pub value: f64,
    /// Standard uncertainty from scatter.
    pub scatter: f64,
    /// Standard uncertainty from the sensors.
    pub sensor: f64,
}

impl MeasuredValue {
    /// Combined standard uncertainty: independent contributions add as squares (equation 10).
    pub fn combined(&self) -> f64 {
        self.scatter.hypot(self.sensor)
    }

    /// Expanded uncertainty, about 95 % (coverage factor 2).
    pub fn expanded(&self) -> f64 {
        2.0 * self.combined()
    }
}

/// The standard uncertainty of a sensor that is accurate to plus or minus `bound`: any error within
/// is equally likely (section 4.3.7).
pub fn from_bound(bound: f64) -> f64 {
    bound / 3f64.sqrt()
}

/// The standard uncertainty of a product or quotient from those of its factors, each relative to
/// its value (equation 12), times the result's magnitude.
pub fn of_product(result: f64, relative: &[f64]) -> f64 {
    result.abs() * relative.iter().map(|r| r * r).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contributions_add_as_squares() {
        let m = MeasuredValue { value: 10.0, scatter: 0.3, sensor: 0.4 };
        assert!((m.combined() - 0.5).abs() < 1e-12);
        assert!((m.expanded() - 1.0).abs() < 1e-12);
        assert!((from_bound(3.0) - 3f64.sqrt()).abs() < 1e-12);
        assert!((of_product(-200.0, &[0.03, 0.04]) - 10.0).abs() < 1e-12);
    }
}
