//! The journal at its place: areas and conductances.

use nalgebra::Vector2;

use super::QuasiStatic;
use crate::roughness::{NO_CONTACT, RoughFilm, Width, parting};

impl QuasiStatic {
    /// Puts the journal of a round, aligned bearing at the eccentricity ratio `eps`; `|eps| < 1` between smooth surfaces.
    pub fn place(&mut self, eps: Vector2<f64>) {
        self.eps = eps;
        let columns = self.grid.columns();
        let value = |film: &Self, theta: f64| film.gap(theta).map(|[value, _]| value);
        let mut before = value(self, self.grid.theta_edge(0));
        for i in 0..columns {
            let previous = self.grid.theta_width((i + columns - 1) % columns);
            let width = self.grid.theta_width(i);
            let after = value(self, self.grid.theta_edge(i + 1));
            let middle = value(self, self.grid.theta_centre(i));
            // Simpson's rule: exact for the cubic that H^3 nearly is over one cell.
            let [bears, flow] = [0, 1].map(|k| (before[k] + 4.0 * middle[k] + after[k]) / 6.0);
            self.normal[i] = self.smooth[i] * bears;
            self.along[i] = 2.0 * before[1] / (previous + width);
            self.across[i] = self.slenderness * width * flow;
            before = after;
        }
    }

    /// The share of the area on which the film bears, and the third power of the gap of the flow, with their slopes over the
    /// distance of the mean planes.
    pub(super) fn gap(&self, theta: f64) -> [Width; 2] {
        let distance = 1.0 - self.eps.x * theta.cos() - self.eps.y * theta.sin();
        let cubed = |[gap, slope]: Width| [gap.powi(3), 3.0 * gap * gap * slope];
        if distance >= NO_CONTACT * self.roughness {
            return [[1.0, 0.0], cubed([distance, 1.0])];
        }
        let ratio = distance / self.roughness;
        let [[_, bears], [flow, widens]] = RoughFilm::MeanGap.gaps(ratio);
        [[bears, parting(ratio) / self.roughness], cubed([flow * self.roughness, widens])]
    }
}
