//! The film's state: pressure and oil content of its cells, and the journal's position.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::{cells::Cells, warmth::Warm};

/// Pressure and content cell by cell, in the order of [`Cells`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// Pressure above that of the cavities, 1/s.
    pub pressure: Vec<f64>,
    /// Share of the gap that oil fills, 0..1.
    pub content: Vec<f64>,
    /// Whether the cell is full. The unknown of a full cell is its pressure, that of another its content.
    pub full: Vec<bool>,
}

impl Field {
    /// Full cells without pressure; padding cells do not count as full.
    pub fn flooded(cells: &Cells) -> Self {
        Self {
            pressure: vec![0.0; cells.count()],
            content: vec![1.0; cells.count()],
            full: cells.area.iter().map(|&area| area > 0.0).collect(),
        }
    }

    /// Copies another field of the same size; allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.pressure.copy_from_slice(&other.pressure);
        self.content.copy_from_slice(&other.content);
        self.full.copy_from_slice(&other.full);
    }

    /// Empties every cell: neither pressure nor full cells.
    pub fn rupture(&mut self) {
        self.full.fill(false);
        self.pressure.fill(0.0);
    }

    /// Whether the field has this number of cells.
    pub fn fits(&self, cells: usize) -> bool {
        [self.pressure.len(), self.content.len(), self.full.len()] == [cells; 3]
    }
}

/// All that the film keeps from step to step; together with the settings it determines the future.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Eccentricity ratio of the journal in the bearing's middle plane.
    pub eps: Vector2<f64>,
    /// Its rate, 1/s.
    pub velocity: Vector2<f64>,
    /// Angles through which journal and bush have turned, rad.
    pub angles: [f64; 2],
    /// Internal step that the error control expects to fit next, s.
    pub step: Option<f64>,
    pub field: Field,
    /// Temperature and viscosity of each column; empty where the film has no temperature of its own.
    pub warm: Vec<Warm>,
    /// Pressure for which a value of one in the field stands, Pa.s.
    pub unit: f64,
}

impl State {
    /// The journal in the middle of a flooded film.
    pub fn flooded(cells: &Cells) -> Self {
        Self { field: Field::flooded(cells), ..Self::default() }
    }

    /// Copies another state of the same size; allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.eps = other.eps;
        self.velocity = other.velocity;
        self.angles = other.angles;
        self.step = other.step;
        self.field.copy_from(&other.field);
        self.warm.clone_from(&other.warm);
        self.unit = other.unit;
    }
}
