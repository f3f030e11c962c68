//! The mobility about the centre, where the load's direction from the eccentricity has no meaning.
//!
//! The table is made over that direction, so interpolated values differ a little from one direction to another even at the
//! centre, where they cannot: there the film has no derivative over the eccentricity. A linear law has. The free boundary of a
//! concentric film is where the squeeze changes its sign, so the quantities have a derivative at the centre, and by symmetry the
//! lead goes with the eccentricity's component across the load, all others with that along it.

use super::table::{CHANNELS, LEAD, Node, VALUE};

/// The eccentricity ratio at which the table alone holds.
pub const RADIUS: f64 = 0.01;

/// Index of a node's slope over `u`.
const OVER_U: usize = 1;

/// The quantities at the centre, and their slopes over the eccentricity ratio: along the load, of the lead across it.
#[derive(Clone, Copy, Debug)]
pub struct Centre {
    values: [f64; CHANNELS],
    slopes: [f64; CHANNELS],
}

impl Centre {
    /// The law from the table's row at the centre, whose slopes are per node spacing, with so many spacings per unit of `u`. At
    /// the centre, `u` rises as the eccentricity ratio.
    pub fn new(row: &[Node], per_u: f64) -> Self {
        let (along, across, against) = (&row[0], &row[row.len() / 2], &row[row.len() - 1]);
        let angle = super::coordinates::Point { u: 0.0, s: (row.len() / 2) as f64 / (row.len() - 1) as f64 }.angle();
        let mut values = std::array::from_fn(|channel| 0.5 * (along[VALUE][channel] + against[VALUE][channel]));
        let mut slopes: [f64; CHANNELS] =
            std::array::from_fn(|channel| 0.5 * (along[OVER_U][channel] - against[OVER_U][channel]) * per_u);
        values[LEAD] = 0.0;
        slopes[LEAD] = across[OVER_U][LEAD] * per_u / angle.sin();
        Self { values, slopes }
    }

    /// The quantities at an eccentricity ratio below [`RADIUS`]: this law at the centre, the table's values at the rim, between
    /// them a blend with continuous slopes. The table's part goes with the square of the ratio.
    #[inline]
    pub fn blend(&self, mut table: [f64; CHANNELS], e: f64, cos: f64, sin: f64) -> [f64; CHANNELS] {
        let share = e / RADIUS;
        let weight = share * share * (3.0 - 2.0 * share);
        for (channel, value) in table.iter_mut().enumerate() {
            // The lead is stored without the sign of the angle from eccentricity to load.
            let place = if channel == LEAD { e * sin.abs() } else { e * cos };
            let law = self.values[channel] + self.slopes[channel] * place;
            *value = law + weight * (*value - law);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::super::coordinates::Point;
    use super::super::{MobilityMap, MobilitySlice, SliceFamily, exact};
    use super::*;
    use nalgebra::{Matrix2, Vector2};

    const WIDTHS: [f64; 4] = [0.2, 0.5, 0.76, 1.5];
    const DEGREES: [f64; 7] = [0.0, 25.0, 60.0, 90.0, -120.0, 155.0, 180.0];

    fn slice(width: f64) -> MobilitySlice {
        SliceFamily::new(&MobilityMap::built_in().unwrap()).slice(width)
    }

    fn polar(e: f64, degrees: f64) -> Vector2<f64> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vector2::new(e * cos, e * sin)
    }

    /// A differentiable law has one matrix of slopes, whatever the direction and the length of the increment.
    #[test]
    fn the_centre_has_one_derivative() {
        for width in WIDTHS {
            let slice = slice(width);
            let at = |eps: Vector2<f64>| slice.mobility_vector(eps, Vector2::x());
            let centre = at(Vector2::zeros());
            for step in [1e-12, 1e-9, 1e-6, 1e-4] {
                let slope = |along: Vector2<f64>| (at(along * 1e-5) - at(along * -1e-5)) / 2e-5;
                let jacobian = Matrix2::from_columns(&[slope(Vector2::x()), slope(Vector2::y())]);
                for degrees in DEGREES {
                    let eps = polar(step, degrees);
                    let error = (at(eps) - centre - jacobian * eps).norm() / centre.norm();
                    assert!(error < 0.02 * step + 1e-14, "B/D {width}, {step:e} at {degrees}: {error:e}");
                }
            }
        }
    }

    /// By how much the blend differs from the table's own values, where it counts.
    #[test]
    fn the_law_meets_the_table() {
        for width in WIDTHS {
            let slice = slice(width);
            let mut most = [0.0_f64; CHANNELS];
            for e in [1e-9, 0.002, 0.005, 0.008, 0.999 * RADIUS] {
                for degrees in DEGREES {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    let [blend, table] = [
                        slice.look_up(polar(e, -degrees), e, Vector2::x()),
                        slice.look_up_at(Point::new(1.0 - e, cos, sin), Vector2::x(), sin),
                    ]
                    .map(|of| {
                        let mobility = of.mobility();
                        let lead = mobility.y.atan2(mobility.x);
                        [mobility.norm().ln(), lead, of.max_pressure().ln(), of.side_flow().ln()]
                    });
                    for channel in 0..CHANNELS {
                        most[channel] = most[channel].max((blend[channel] - table[channel]).abs());
                    }
                }
            }
            assert!(most.iter().all(|&most| most < 3e-4), "B/D {width}: {most:?}");
        }
    }

    /// The slopes of direct solutions.
    #[test]
    fn the_slopes_are_those_of_the_film() {
        const STEP: f64 = 0.02;
        let width = 0.76;
        let law = slice(width);
        let at = |angle: f64| exact(width, STEP, angle, [128, 12]).unwrap().mobility;
        let (ahead, back) = (at(0.0).norm(), at(std::f64::consts::PI).norm());
        let centre = Centre::new(law.row(0), 40.0 / (4.0 * std::f64::consts::LN_10));
        let along = (ahead / back).ln() / (2.0 * STEP);
        let across = at(std::f64::consts::FRAC_PI_2);
        let lead = (across.y.atan2(across.x) - std::f64::consts::FRAC_PI_2) / STEP;
        assert!((centre.slopes[0] / along - 1.0).abs() < 0.02, "{} {along}", centre.slopes[0]);
        assert!((centre.slopes[LEAD] / lead - 1.0).abs() < 0.02, "{} {lead}", centre.slopes[LEAD]);
    }
}
