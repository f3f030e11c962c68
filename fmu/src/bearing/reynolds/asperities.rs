//! Asperity contact in the film's cells, for surfaces that are not round or not aligned.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::cells::Cells;

use super::gap::Gap;
use super::settings::FilmSettings;
use crate::bearing::contact::{Surface, f_5_2};

/// Greenwood-Tripp contact, evaluated at each cell's own gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Asperities(pub Surface);

/// Film ratio beyond which asperities do not touch.
const NO_CONTACT: f64 = 7.0;

/// The slope of `F_5/2` over the film ratio.
fn f_5_2_slope(h: f64) -> f64 {
    if h >= 0.0 {
        -(1.72386 + h * (0.59168 + h * 0.039612)) * f_5_2(h)
    } else if h >= CROSSED {
        -(1.72386 + h * (0.5136052 + h * (0.0702153 + h * 0.00350764))) * f_crossed(h)
    } else {
        2.5 * f_crossed(h) / h
    }
}

/// Mean planes that have crossed by more than this are out of the fit's range.
const CROSSED: f64 = -6.0;

/// The integral `F_5/2(H)` also where the mean planes have crossed, `H < 0`: our own fit, within 0.8 % of the integral
/// down to `H = -6`, and its power law beyond.
fn f_crossed(h: f64) -> f64 {
    if h >= 0.0 {
        f_5_2(h)
    } else if h >= CROSSED {
        let rise = 1.72386 + h * (0.2568026 + h * (0.0234051 + h * 0.00087691));
        0.61663 * (-h * rise).exp()
    } else {
        f_crossed(CROSSED) * (h / CROSSED).powf(2.5)
    }
}

impl Asperities {
    /// The contact's push on the load's side, N, and its derivative over the eccentricity ratio.
    pub(super) fn push(
        &self,
        cells: &Cells,
        gap: &Gap,
        settings: &FilmSettings,
    ) -> (Vector2<f64>, Matrix2<f64>) {
        let ratio = settings.clearance / self.0.roughness;
        let mut force = Vector2::zeros();
        let mut slope = Matrix2::zeros();
        if !ratio.is_finite() {
            return (force, slope);
        }
        self.each(cells, gap, settings, |normal, area, h| {
            let scale = self.0.pressure_scale() * area;
            force += normal * (scale * f_crossed(h));
            slope -= normal * normal.transpose() * (scale * ratio * f_5_2_slope(h));
        });
        (force, slope)
    }

    /// The contact pressure integrated over the surface, N: what boundary friction acts on.
    pub(super) fn normal(&self, cells: &Cells, gap: &Gap, settings: &FilmSettings) -> f64 {
        let mut sum = 0.0;
        self.each(cells, gap, settings, |_, area, h| {
            sum += self.0.pressure_scale() * area * f_crossed(h);
        });
        sum
    }

    /// Visits every touching cell with its direction, area (m2) and film ratio.
    fn each(
        &self,
        cells: &Cells,
        gap: &Gap,
        settings: &FilmSettings,
        mut visit: impl FnMut(Vector2<f64>, f64, f64),
    ) {
        let ratio = settings.clearance / self.0.roughness;
        let developed = 0.5 * settings.diameter * settings.width;
        for (i, range) in cells.columns() {
            for cell in range {
                let h = if settings.film_roughness() > 0.0 {
                    gap.ratio[cell]
                } else {
                    gap.cell[cell] * ratio
                };
                if h < NO_CONTACT {
                    let area = cells.area[cell] * developed;
                    visit(cells.directions.mean[i], area, h);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against `F_n(H) = 1/sqrt(2 pi) int_H^inf (s-H)^n exp(-s^2/2) ds`, by numerical quadrature; and the slope against
    /// differences.
    #[test]
    fn contact_goes_on_where_the_mean_planes_cross() {
        for k in 0..=60 {
            let h = -0.1 * f64::from(k);
            let (n, width) = (20_000, 16.0);
            let ds = width / f64::from(n);
            let integrand = |k: i32| {
                let x = (f64::from(k) + 0.5) * ds;
                x.powf(2.5) * (-0.5 * (h + x).powi(2)).exp()
            };
            let integral = (0..n).map(integrand).sum::<f64>() * ds / std::f64::consts::TAU.sqrt();
            assert!((f_crossed(h) / integral - 1.0).abs() < 0.0085, "H = {h}");
        }
        for h in [-8.0, -5.0, -1.0, 0.5, 3.0] {
            let slope = (f_crossed(h + 1e-6) - f_crossed(h - 1e-6)) / 2e-6;
            assert!((f_5_2_slope(h) / slope - 1.0).abs() < 1e-6, "H = {h}");
        }
    }
}
