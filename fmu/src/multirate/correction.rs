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
    pub nodes: Vec<(f64, Orbit)>,
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
