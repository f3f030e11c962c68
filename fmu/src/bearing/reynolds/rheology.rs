//! Viscosity of the oil in the film's cells: over pressure and over shear rate.

use serde::{Deserialize, Serialize};

/// How viscosity rises with pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum PressureViscosity {
    /// Not at all.
    #[default]
    None,
    /// Barus (1893): `eta = eta0 exp(alpha p)`.
    Barus {
        /// Pressure-viscosity coefficient, 1/Pa.
        alpha: f64,
    },
    /// Roelands (1966): `eta = eta0 exp[(ln eta0 + 9.67) ((1 + p / 196.2 MPa)^z - 1)]`, at constant
    /// temperature, with `z` from the coefficient at ambient pressure.
    Roelands {
        /// Pressure-viscosity coefficient at ambient pressure, 1/Pa.
        alpha: f64,
    },
}

/// How viscosity falls with the shear rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum ShearThinning {
    /// Not at all.
    #[default]
    None,
    /// Cross (1965): `eta/eta0 = r + (1 - r) / (1 + (lambda g)^m)`.
    Cross {
        /// Viscosity at the highest shear rates over that at the lowest, 1.
        limit: f64,
        /// Time constant, s.
        time: f64,
        /// Exponent, 1.
        exponent: f64,
    },
    /// Carreau (1972): `eta/eta0 = r + (1 - r) (1 + (lambda g)^2)^((n - 1)/2)`.
    Carreau {
        /// Viscosity at the highest shear rates over that at the lowest, 1.
        limit: f64,
        /// Time constant, s.
        time: f64,
        /// Power-law exponent, 1.
        exponent: f64,
    },
}

/// The oil's viscosity laws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rheology {
    /// Over pressure.
    pub pressure: PressureViscosity,
    /// Over the shear rate.
    pub shear: ShearThinning,
}

/// The exponent of a pressure law is not taken beyond this: the laws are not meant for more.
const LARGEST_EXPONENT: f64 = 5.0;

impl Rheology {
    /// Whether the viscosity is the same everywhere.
    pub fn is_newtonian(&self) -> bool {
        *self == Self::default()
    }

    /// Viscosity over the oil's viscosity `eta0` (Pa.s) at ambient pressure and low shear, at a
    /// pressure above ambient (Pa) and a shear rate (1/s).
    pub fn ratio(&self, eta0: f64, pressure: f64, shear_rate: f64) -> f64 {
        let exponent = match self.pressure {
            PressureViscosity::None => 0.0,
            PressureViscosity::Barus { alpha } => alpha * pressure,
            PressureViscosity::Roelands { alpha } => {
                const SCALE: f64 = 1.962e8;
                let thickness = eta0.ln() + 9.67;
                let z = alpha * SCALE / thickness;
                thickness * ((1.0 + pressure.max(0.0) / SCALE).powf(z) - 1.0)
            }
        };
        let thinning = match self.shear {
            ShearThinning::None => 1.0,
            ShearThinning::Cross {
                limit,
                time,
                exponent,
            } => limit + (1.0 - limit) / (1.0 + (time * shear_rate.abs()).powf(exponent)),
            ShearThinning::Carreau {
                limit,
                time,
                exponent,
            } => {
                let rate = time * shear_rate;
                limit + (1.0 - limit) * (1.0 + rate * rate).powf(0.5 * (exponent - 1.0))
            }
        };
        exponent.clamp(-LARGEST_EXPONENT, LARGEST_EXPONENT).exp() * thinning
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roelands_has_the_coefficient_of_barus_at_low_pressure() {
        let of = |pressure| Rheology {
            pressure,
            ..Rheology::default()
        };
        let (alpha, eta0, p) = (2e-8, 0.05, 1e4);
        let barus = of(PressureViscosity::Barus { alpha }).ratio(eta0, p, 0.0);
        let roelands = of(PressureViscosity::Roelands { alpha }).ratio(eta0, p, 0.0);
        assert!(((roelands - 1.0) / (barus - 1.0) - 1.0).abs() < 1e-3);
        let high = 2e8;
        assert!(
            of(PressureViscosity::Roelands { alpha }).ratio(eta0, high, 0.0)
                < of(PressureViscosity::Barus { alpha }).ratio(eta0, high, 0.0)
        );
    }

    #[test]
    fn thinning_stays_between_its_limits() {
        for shear in [
            ShearThinning::Cross {
                limit: 0.4,
                time: 1e-6,
                exponent: 0.8,
            },
            ShearThinning::Carreau {
                limit: 0.4,
                time: 1e-6,
                exponent: 0.5,
            },
        ] {
            let law = Rheology {
                shear,
                ..Rheology::default()
            };
            assert!((law.ratio(0.05, 0.0, 1.0) - 1.0).abs() < 1e-4);
            assert!((law.ratio(0.05, 0.0, 1e12) - 0.4).abs() < 1e-2);
            assert!(law.ratio(0.05, 0.0, 1e6) < law.ratio(0.05, 0.0, 1e5));
        }
    }
}
