//! The oil: viscosity, density and heat capacity over temperature, and the laws over pressure and shear rate.

pub mod measured;

use fmu_export::model::{Experiment, Fault};
use journal_bearing::rheology::Rheology;
use serde::{Deserialize, Serialize};

/// The oil's parameters: two points of its viscosity and one of its density.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Oil {
    /// Kinematic viscosity at 40 °C, m²/s.
    pub kinematic_viscosity_40: f64,
    /// Kinematic viscosity at 100 °C, m²/s.
    pub kinematic_viscosity_100: f64,
    /// Density at 15 °C, kg/m³.
    pub density_15: f64,
    /// Factor on the viscosity of the oil law, 1. At one it is the real oil.
    pub viscosity_scale: f64,
    /// A csv file of measured properties, which replace the two viscosities and the density; empty for none.
    pub properties_file: String,
    /// The laws of viscosity and density over pressure and shear rate (Reynolds film only).
    pub thickening: Rheology,
}

impl Default for Oil {
    /// SAE 15W-40, typical.
    fn default() -> Self {
        Self {
            kinematic_viscosity_40: 105e-6,
            kinematic_viscosity_100: 14.2e-6,
            density_15: 880.0,
            viscosity_scale: 1.0,
            properties_file: String::new(),
            thickening: Rheology {
                pressure_coefficient: 2e-8,
                shear_time: 1e-7,
                shear_exponent: 0.7,
                shear_limit: 0.5,
                ..Rheology::default()
            },
        }
    }
}

const CELSIUS_0: f64 = 273.15;
/// ASTM D341 adds this to the kinematic viscosity, mm²/s.
const D341_SHIFT: f64 = 0.7;
/// Its law holds from this kinematic viscosity, mm²/s.
const D341_LEAST: f64 = 2.0;
/// And up to this one.
const D341_MOST: f64 = 2e7;

/// Coefficients of the oil's laws over temperature.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Properties {
    /// `ln(nu + 0.7) = d341_factor * T^-d341_exponent`, nu in mm²/s and T in K.
    d341_factor: f64,
    d341_exponent: f64,
    /// Density at 15 °C, kg/m³.
    pub density_15: f64,
    /// Thermal expansion coefficient at 15 °C, 1/K.
    expansion: f64,
    /// Factor on the viscosity, 1; may change while running.
    pub viscosity_scale: f64,
    /// Temperatures of the first and the last measured row, K; without a file the viscosity law's own limit holds alone.
    measured: Option<[f64; 2]>,
    /// The temperatures between which the viscosity law holds, K.
    range: [f64; 2],
}

impl Oil {
    /// The oil of the parameters: of the properties file if there is one, else of the two viscosities and the density.
    pub fn properties(&self, experiment: &Experiment) -> Result<Properties, Fault> {
        if self.properties_file.is_empty() {
            return Ok(self.through_two_points());
        }
        let rows = measured::read(&experiment.file(&self.properties_file))?;
        Ok(self.fitted(&rows))
    }

    /// ASTM D341-20, eq. 1, through the viscosities at 40 and 100 °C: `log10(log10(nu + 0.7)) = A - B*log10(T)`.
    pub fn through_two_points(&self) -> Properties {
        let at_40 = (self.kinematic_viscosity_40 * 1e6 + D341_SHIFT).ln();
        let at_100 = (self.kinematic_viscosity_100 * 1e6 + D341_SHIFT).ln();
        let (t_40, t_100) = (CELSIUS_0 + 40.0, CELSIUS_0 + 100.0);
        let exponent = (at_40 / at_100).ln() / (t_100 / t_40).ln();
        let factor = at_40 * t_40.powf(exponent);
        Properties {
            d341_factor: factor,
            d341_exponent: exponent,
            range: range(factor, exponent),
            density_15: self.density_15,
            expansion: expansion(self.density_15),
            viscosity_scale: self.viscosity_scale,
            measured: None,
        }
    }

    /// The same laws fitted to measured rows by least squares: `ln(ln(nu + 0.7))` over `ln(T)`, and the logarithm of the
    /// density over the temperature.
    pub fn fitted(&self, rows: &[measured::Row]) -> Properties {
        let (factor, slope) = measured::line(rows.iter().map(|row| {
            let doubled = (row.kinematic_viscosity + D341_SHIFT).ln().ln();
            ((row.temperature + CELSIUS_0).ln(), doubled)
        }));
        // The density law is linear in its coefficient except for a small square term: a few passes converge.
        let (mut density_15, mut expansion) = (0.0, 0.0);
        for _ in 0..6 {
            let (level, slope) = measured::line(rows.iter().map(|row| {
                let rise = row.temperature - 15.0;
                (rise, row.density.ln() + 0.8 * (expansion * rise).powi(2))
            }));
            (density_15, expansion) = (level.exp(), -slope);
        }
        let (factor, exponent) = (factor.exp(), -slope);
        Properties {
            d341_factor: factor,
            d341_exponent: exponent,
            range: range(factor, exponent),
            density_15,
            expansion,
            viscosity_scale: self.viscosity_scale,
            measured: Some(rows.iter().fold([f64::INFINITY, 0.0], |[low, high], row| {
                let temperature = row.temperature + CELSIUS_0;
                [low.min(temperature), high.max(temperature)]
            })),
        }
    }
}

/// Thermal expansion coefficient at 15 °C, 1/K: ASTM D1250-80 (API MPMS 11.1), lubricating oils.
fn expansion(density_15: f64) -> f64 {
    0.6278 / density_15
}

/// The temperatures, K, between which ASTM D341 holds with these coefficients.
fn range(factor: f64, exponent: f64) -> [f64; 2] {
    [D341_MOST, D341_LEAST].map(|viscosity| (factor / (viscosity + D341_SHIFT).ln()).powf(1.0 / exponent))
}

impl Properties {
    /// Kinematic viscosity of the real oil, m²/s, at a temperature, K (ASTM D341).
    pub fn kinematic_viscosity(&self, temperature: f64) -> f64 {
        let shifted = (self.d341_factor * temperature.powf(-self.d341_exponent)).exp();
        // Far below 2 mm²/s, where the law no longer holds, subtracting the shift would give a negative viscosity.
        (shifted - D341_SHIFT).max(0.01) * 1e-6
    }

    /// Whether the laws hold at a temperature, K.
    #[inline]
    pub fn holds(&self, temperature: f64) -> bool {
        let within = |[low, high]: [f64; 2]| low <= temperature && temperature <= high;
        within(self.range) && self.measured.is_none_or(within)
    }

    /// Why they do not: beyond the measured rows, or where the viscosity law ends.
    pub fn beyond(&self, temperature: f64) -> Option<String> {
        if self.holds(temperature) {
            return None;
        }
        if let Some([low, high]) = self.measured
            && !(low..=high).contains(&temperature)
        {
            return Some(format!("the oil was measured from {low:.2} to {high:.2} K"));
        }
        let limit = if temperature > self.range[1] { D341_LEAST } else { D341_MOST };
        Some(format!(
            "its viscosity law (ASTM D341) ends at {:e} m2/s, where it gives {:.2e}",
            1e-6 * limit,
            self.kinematic_viscosity(temperature)
        ))
    }

    /// Density, kg/m³, at a temperature, K (ASTM D1250-80: `exp(-alpha*dT*(1 + 0.8*alpha*dT))`).
    pub fn density(&self, temperature: f64) -> f64 {
        let x = self.expansion * (temperature - CELSIUS_0 - 15.0);
        self.density_15 * (-x * (1.0 + 0.8 * x)).exp()
    }

    /// Dynamic viscosity, Pa.s, at a temperature, K, with the viscosity scale.
    pub fn viscosity(&self, temperature: f64) -> f64 {
        self.viscosity_scale * self.real(temperature)
    }

    /// Dynamic viscosity, Pa.s, without the viscosity scale.
    pub(crate) fn real(&self, temperature: f64) -> f64 {
        self.kinematic_viscosity(temperature) * self.density(temperature)
    }

    /// Specific heat capacity, J/(kg.K), at a temperature, K
    /// (Cragoe 1929, NBS Miscellaneous Publication 97: `(1.685 + 0.0034*t)/sqrt(s)` in kJ/(kg.K), t in °C).
    pub fn heat_capacity(&self, temperature: f64) -> f64 {
        let specific_gravity = self.density_15 / 999.1;
        (1685.0 + 3.4 * (temperature - CELSIUS_0)) / specific_gravity.sqrt()
    }
}

/// The viscosity near a temperature: a polynomial that interpolates the oil law, to about 1e-14, and is much faster than the
/// law's powers. When the temperature leaves its range, the polynomial is built anew around it. The ranges are fixed, so
/// that the result depends on the temperature alone, not on earlier ones.
#[derive(Clone, Copy, Debug)]
pub struct Nearby {
    /// Middle of the range, K: a multiple of its width. Infinite before the first use.
    centre: f64,
    /// Newton's form of the polynomial over [`Nearby::PLACES`], for the viscosity without its scale.
    coefficients: [f64; 6],
}

impl Default for Nearby {
    fn default() -> Self {
        Self { centre: f64::INFINITY, coefficients: [0.0; 6] }
    }
}

impl Nearby {
    /// Half the width of the range, K.
    const REACH: f64 = 0.25;
    /// The nodes, relative to the reach: the zeros of the Chebyshev polynomial of degree 6.
    const PLACES: [f64; 6] = [
        -0.965_925_826_289_068_3,
        -0.707_106_781_186_547_5,
        -0.258_819_045_102_520_76,
        0.258_819_045_102_520_76,
        0.707_106_781_186_547_5,
        0.965_925_826_289_068_3,
    ];

    #[cold]
    fn about(oil: &Properties, temperature: f64) -> Self {
        let centre = 2.0 * Self::REACH * (temperature / (2.0 * Self::REACH)).round();
        let mut coefficients = Self::PLACES.map(|place| oil.real(centre + Self::REACH * place));
        for order in 1..coefficients.len() {
            for i in (order..coefficients.len()).rev() {
                let width = Self::PLACES[i] - Self::PLACES[i - order];
                coefficients[i] = (coefficients[i] - coefficients[i - 1]) / width;
            }
        }
        Self { centre, coefficients }
    }

    /// Dynamic viscosity, Pa.s, at a temperature, K, with the viscosity scale. The oil must be the same at every call,
    /// its viscosity scale apart.
    #[inline]
    pub fn viscosity(&mut self, oil: &Properties, temperature: f64) -> f64 {
        let away = temperature - self.centre;
        if away.abs() > Self::REACH || away.is_nan() {
            *self = Self::about(oil, temperature);
        }
        let x = (temperature - self.centre) * (1.0 / Self::REACH);
        let terms = self.coefficients.iter().zip(&Self::PLACES).rev();
        oil.viscosity_scale * terms.fold(0.0, |sum, (coefficient, place)| coefficient + (x - place) * sum)
    }
}
