//! Oil laws: viscosity over pressure and shear rate, density over pressure.
//!
//! # Examples
//! ```
//! use journal_bearing::rheology::{PressureLaw, Rheology};
//!
//! let oil = Rheology {
//!     pressure_law: PressureLaw::Barus,
//!     pressure_coefficient: 20e-9,
//!     ..Rheology::default()
//! };
//! // At 50 MPa the viscosity rises by a factor of e.
//! let ratio = oil.ratio(0.02, 50e6, 0.0);
//! assert!((ratio - 1.0_f64.exp()).abs() < 1e-12);
//! ```

use serde::{Deserialize, Serialize};

/// Law of the viscosity over pressure, with the [coefficient](Rheology::pressure_coefficient) `alpha` at ambient pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PressureLaw {
    /// Viscosity does not depend on pressure.
    #[default]
    Constant,
    /// Barus (1893): `eta = eta0 exp(alpha p)`.
    Barus,
    /// Roelands (1966): `eta = eta0 exp[(ln eta0 + 9.67) ((1 + p / 196.2 MPa)^z - 1)]`, at constant
    /// temperature, with `z` from the coefficient at ambient pressure.
    Roelands,
}

/// Law of the viscosity over the shear rate `g`, with [limit](Rheology::shear_limit) `r` and [time](Rheology::shear_time)
/// `lambda`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ShearLaw {
    /// Viscosity does not depend on the shear rate.
    #[default]
    Newtonian,
    /// Cross (1965): `eta/eta0 = r + (1 - r) / (1 + (lambda g)^m)`, with the exponent `m`.
    Cross,
    /// Carreau (1972): `eta/eta0 = r + (1 - r) (1 + (lambda g)^2)^((n - 1)/2)`, with the power-law exponent `n`.
    Carreau,
}

/// Law of the density over pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum DensityLaw {
    /// Density does not depend on pressure.
    #[default]
    Constant,
    /// Dowson & Higginson (1966, Elasto-hydrodynamic Lubrication), for mineral oils:
    /// `rho/rho0 = 1 + 0.6 p/(1 + 1.7 p)`, p in GPa.
    DowsonHigginson,
}

impl DensityLaw {
    /// Density over that at ambient pressure, 1, and its slope, 1/Pa, at a pressure above ambient, Pa.
    pub fn ratio(self, pressure: f64) -> [f64; 2] {
        match self {
            Self::Constant => [1.0, 0.0],
            Self::DowsonHigginson => {
                const RISE: f64 = 0.6e-9;
                const LIMIT: f64 = 1.7e-9;
                // The law does not hold in tension.
                let pressure = pressure.max(0.0);
                let base = 1.0 + LIMIT * pressure;
                [1.0 + RISE * pressure / base, RISE / (base * base)]
            }
        }
    }
}

/// The oil's laws over pressure and shear rate. Numbers count only with the laws that have them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rheology {
    /// Viscosity over pressure.
    pub pressure_law: PressureLaw,
    /// Pressure-viscosity coefficient at ambient pressure, 1/Pa.
    pub pressure_coefficient: f64,
    /// Viscosity over the shear rate.
    pub shear_law: ShearLaw,
    /// Time constant of the shear law, s.
    pub shear_time: f64,
    /// Exponent of the shear law, 1.
    pub shear_exponent: f64,
    /// Viscosity at the highest shear rates over that at the lowest, 1.
    pub shear_limit: f64,
    /// Density over pressure.
    pub density_law: DensityLaw,
}

/// Largest exponent of a pressure law. The laws do not hold beyond.
const LARGEST_EXPONENT: f64 = 5.0;

impl Rheology {
    /// Whether the viscosity depends on neither pressure nor shear rate.
    pub fn is_newtonian(&self) -> bool {
        self.pressure_law == PressureLaw::Constant && self.shear_law == ShearLaw::Newtonian
    }

    /// Whether a pressure above ambient, Pa, raises the viscosity beyond the end of its law.
    pub fn ends_below(&self, eta0: f64, pressure: f64) -> bool {
        self.exponent(eta0, pressure)[0] > LARGEST_EXPONENT
    }

    /// The logarithm of the viscosity's rise by pressure, 1, and its slope, 1/Pa.
    fn exponent(&self, eta0: f64, pressure: f64) -> [f64; 2] {
        let alpha = self.pressure_coefficient;
        match self.pressure_law {
            PressureLaw::Constant => [0.0; 2],
            PressureLaw::Barus => [alpha * pressure, alpha],
            PressureLaw::Roelands => {
                const SCALE: f64 = 1.962e8;
                let thickness = eta0.ln() + 9.67;
                let z = alpha * SCALE / thickness;
                let base = 1.0 + pressure.max(0.0) / SCALE;
                let rise = base.powf(z);
                [thickness * (rise - 1.0), alpha * rise / base]
            }
        }
    }

    /// Slope of the viscosity's logarithm over pressure, 1/Pa.
    pub(super) fn thickening(&self, eta0: f64, pressure: f64) -> f64 {
        let [exponent, slope] = self.exponent(eta0, pressure);
        if exponent.abs() < LARGEST_EXPONENT { slope } else { 0.0 }
    }

    /// Viscosity over `eta0`, 1, at a pressure above ambient (Pa) and a shear rate (1/s). `eta0` (Pa.s) is the viscosity at
    /// ambient pressure and low shear.
    pub fn ratio(&self, eta0: f64, pressure: f64, shear_rate: f64) -> f64 {
        let [exponent, _] = self.exponent(eta0, pressure);
        let (limit, time, power) = (self.shear_limit, self.shear_time, self.shear_exponent);
        let thinning = match self.shear_law {
            ShearLaw::Newtonian => 1.0,
            ShearLaw::Cross => limit + (1.0 - limit) / (1.0 + (time * shear_rate.abs()).powf(power)),
            ShearLaw::Carreau => {
                let rate = time * shear_rate;
                limit + (1.0 - limit) * (1.0 + rate * rate).powf(0.5 * (power - 1.0))
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
        let of = |pressure_law| Rheology { pressure_law, pressure_coefficient: 2e-8, ..Rheology::default() };
        let (eta0, p) = (0.05, 1e4);
        let barus = of(PressureLaw::Barus).ratio(eta0, p, 0.0);
        let roelands = of(PressureLaw::Roelands).ratio(eta0, p, 0.0);
        assert!(((roelands - 1.0) / (barus - 1.0) - 1.0).abs() < 1e-3);
        let high = 2e8;
        assert!(of(PressureLaw::Roelands).ratio(eta0, high, 0.0) < of(PressureLaw::Barus).ratio(eta0, high, 0.0));
    }

    #[test]
    fn thickening_is_the_slope_of_the_logarithm() {
        for pressure_law in [PressureLaw::Barus, PressureLaw::Roelands] {
            let law = Rheology { pressure_law, pressure_coefficient: 2e-8, ..Rheology::default() };
            let (p, d) = (1e8, 1e3);
            let rise = law.ratio(0.05, p + d, 0.0) / law.ratio(0.05, p - d, 0.0);
            let slope = law.thickening(0.05, p);
            assert!((rise.ln() / (2.0 * d) / slope - 1.0).abs() < 1e-5, "{law:?}");
        }
    }

    /// Dowson & Higginson's law has its published limits, and its slope is the derivative.
    #[test]
    fn density_rises_as_published() {
        let law = DensityLaw::DowsonHigginson;
        assert_eq!(law.ratio(0.0), [1.0, 0.6e-9]);
        assert!((law.ratio(1e9)[0] - (1.0 + 0.6 / 2.7)).abs() < 1e-12);
        assert!((law.ratio(1e15)[0] - (1.0 + 0.6 / 1.7)).abs() < 1e-5);
        let (p, d) = (3e8, 1e3);
        let slope = (law.ratio(p + d)[0] - law.ratio(p - d)[0]) / (2.0 * d);
        assert!((slope / law.ratio(p)[1] - 1.0).abs() < 1e-6);
        assert_eq!(DensityLaw::Constant.ratio(1e9), [1.0, 0.0]);
    }

    #[test]
    fn thinning_stays_between_its_limits() {
        for (shear_law, shear_exponent) in [(ShearLaw::Cross, 0.8), (ShearLaw::Carreau, 0.5)] {
            let law = Rheology { shear_law, shear_limit: 0.4, shear_time: 1e-6, shear_exponent, ..Rheology::default() };
            assert!((law.ratio(0.05, 0.0, 1.0) - 1.0).abs() < 1e-4);
            assert!((law.ratio(0.05, 0.0, 1e12) - 0.4).abs() < 1e-2);
            assert!(law.ratio(0.05, 0.0, 1e6) < law.ratio(0.05, 0.0, 1e5));
        }
    }
}
