//! Asperity contact cell by cell, for journals that are tilted or not round (Greenwood & Tripp 1970).

use nalgebra::{Matrix2, Vector2};

use super::geometry::Geometry;
use crate::contact::{NO_CONTACT, Surface, f_5_2};

/// The contact's force on the load's side, N, and its derivative over the eccentricity ratio.
pub fn push(surface: &Surface, geometry: &Geometry) -> (Vector2<f64>, Matrix2<f64>) {
    let ratio = geometry.settings.clearance / surface.roughness;
    let mut force = Vector2::zeros();
    let mut slope = Matrix2::zeros();
    if !ratio.is_finite() {
        return (force, slope);
    }
    each(surface, geometry, |normal, area, h| {
        let scale = surface.pressure_scale() * area;
        let (pressure, steepness) = f_5_2(h);
        force += normal * (scale * pressure);
        slope -= normal * normal.transpose() * (scale * ratio * steepness);
    });
    (force, slope)
}

/// The contact pressure integrated over the surface, N: the normal force of boundary friction.
pub fn normal(surface: &Surface, geometry: &Geometry) -> f64 {
    let mut sum = 0.0;
    each(surface, geometry, |_, area, h| {
        sum += surface.pressure_scale() * area * f_5_2(h).0;
    });
    sum
}

/// Visits every touching cell with its direction, area (m2) and film ratio.
fn each(surface: &Surface, geometry: &Geometry, mut visit: impl FnMut(Vector2<f64>, f64, f64)) {
    let (settings, cells, gap) = (&geometry.settings, &geometry.cells, &geometry.gap);
    let ratio = settings.clearance / surface.roughness;
    let developed = 0.5 * settings.diameter * settings.width;
    for (i, range) in cells.columns() {
        for cell in range {
            let h = if gap.rough { gap.film_ratio(cell) } else { gap.cell[cell] * ratio };
            if h < NO_CONTACT {
                let area = cells.area[cell] * developed;
                visit(cells.directions.mean[i], area, h);
            }
        }
    }
}
