//! Asperity contact in the film's cells, for surfaces that are not round or not aligned.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::cells::Cells;
use super::gap::Gap;
use super::settings::FilmSettings;
use crate::contact::{NO_CONTACT, Surface, f_5_2};

/// Greenwood-Tripp contact, evaluated at each cell's own gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Asperities(pub Surface);

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
            let (pressure, steepness) = f_5_2(h);
            force += normal * (scale * pressure);
            slope -= normal * normal.transpose() * (scale * ratio * steepness);
        });
        (force, slope)
    }

    /// The contact pressure integrated over the surface, N: what boundary friction acts on.
    pub(super) fn normal(&self, cells: &Cells, gap: &Gap, settings: &FilmSettings) -> f64 {
        let mut sum = 0.0;
        self.each(cells, gap, settings, |_, area, h| {
            sum += self.0.pressure_scale() * area * f_5_2(h).0;
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
