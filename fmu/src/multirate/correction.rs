//! The flows of a film that is slow to compute, from those of a fast one.
//!
//! Two models of the same film give different heat, but the ratio of their heats, averaged over a turn, hardly changes with
//! the temperature. So a few turns of the slow film tell how to correct the fast one everywhere. Flows and viscosity enter
//! with their logarithms, as between [orbits](super::orbit).

use super::orbit::{Orbit, Piece};
use crate::bearing::Flows;

/// Ratios of the slow film's flows to the fast one's over the viscosity.
#[derive(Clone, Debug, Default)]
pub struct Correction {
    /// Pairs of ln(viscosity) and the difference of the logarithms of both films' flows, in ascending order.
    nodes: Vec<(f64, Orbit)>,
}

/// Nodes closer than this in ln(viscosity) would show each other's errors rather than the slope between them.
pub const CLOSEST: f64 = 0.01;

impl Correction {
    /// Takes over the flows of both films at a viscosity, Pa.s, in place of what was known next to it.
    pub fn learn(&mut self, viscosity: f64, slow: &Flows, fast: &Flows) {
        let x = viscosity.ln();
        self.nodes.retain(|(node, _)| (node - x).abs() > CLOSEST);
        let [slow, fast] = [slow, fast].map(|flows| Orbit::new([0.0; 2], flows));
        let index = self.nodes.partition_point(|(node, _)| *node < x);
        self.nodes.insert(index, (x, Orbit(slow.0 - fast.0)));
    }

    /// The slow film's flows where the fast one has these. Beyond the outermost viscosities their ratios hold; without any,
    /// the flows stay as they are.
    pub fn apply(&self, viscosity: f64, fast: &Flows) -> Flows {
        let [Some((first, _)), Some((last, _))] = [self.nodes.first(), self.nodes.last()] else {
            return *fast;
        };
        let x = viscosity.ln().max(*first).min(*last);
        let gap = self.nodes.partition_point(|(node, _)| *node <= x);
        let (difference, _) = Piece::new(&self.nodes, gap).at(x);
        Orbit(Orbit::new([0.0; 2], fast).0 + difference.0).flows()
    }

    /// How far a viscosity is from the nearest one that is known, in ln(viscosity).
    pub fn distance(&self, viscosity: f64) -> f64 {
        let x = viscosity.ln();
        let distances = self.nodes.iter().map(|(node, _)| (node - x).abs());
        distances.fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fast film's flows, and a slow film's with other powers of the viscosity. Boundary friction sets in below 20 mPa.s.
    fn films(viscosity: f64) -> [Flows; 2] {
        let flows = |power: f64| Flows {
            viscous: 40.0 * viscosity.powf(power),
            boundary: 500.0 * (0.02 - viscosity).max(0.0) * viscosity.powf(power - 0.5),
            side_flow: 1e-9 / viscosity.powf(power),
            feed: 0.0,
        };
        [flows(0.5), flows(0.45)]
    }

    fn known(viscosities: &[f64]) -> Correction {
        let mut correction = Correction::default();
        for &viscosity in viscosities {
            let [fast, slow] = films(viscosity);
            correction.learn(viscosity, &slow, &fast);
        }
        correction
    }

    fn heat(flows: &Flows) -> f64 {
        flows.viscous + flows.boundary
    }

    #[test]
    fn two_nodes_correct_a_ratio_that_is_a_power() {
        let correction = known(&[0.03, 0.008]);
        for viscosity in [0.009, 0.015, 0.025] {
            let [fast, slow] = films(viscosity);
            let corrected = correction.apply(viscosity, &fast);
            assert!((heat(&corrected) / heat(&slow) - 1.0).abs() < 1e-3, "{viscosity}: {corrected:?} {slow:?}");
            assert!((corrected.side_flow / slow.side_flow - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn nothing_is_corrected_where_nothing_is_known() {
        let [fast, _] = films(0.01);
        assert_eq!(Correction::default().apply(0.01, &fast), fast);
    }

    #[test]
    fn a_node_takes_the_place_of_one_next_to_it() {
        let mut correction = known(&[0.03, 0.008]);
        let [fast, _] = films(0.008);
        correction.learn(0.00801, &fast, &fast);
        let corrected = correction.apply(0.00801, &fast);
        assert!((heat(&corrected) / heat(&fast) - 1.0).abs() < 1e-12);
        assert_eq!(correction.nodes.len(), 2);
    }

    #[test]
    fn distances_count_from_the_nearest_node() {
        let correction = known(&[0.01, 0.02]);
        assert!((correction.distance(0.005) - 2f64.ln()).abs() < 1e-12);
        assert!((correction.distance(0.018) - (0.02 / 0.018f64).ln()).abs() < 1e-12);
        assert_eq!(Correction::default().distance(0.01), f64::INFINITY);
    }
}
