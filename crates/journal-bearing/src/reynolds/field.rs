//! What the film holds: pressure and content of its cells, and the journal's place.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::cells::Cells;

/// Pressure and content cell by cell, laid out as [`Cells`] says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Field {
    /// Pressure above that of the cavities, 1/s.
    pub(super) pressure: Vec<f64>,
    /// Share of the gap that oil fills.
    pub(super) content: Vec<f64>,
    /// Which cells are full; the unknown of a full one is its pressure, that of another its content.
    pub(super) full: Vec<bool>,
}

impl Field {
    /// Full cells without pressure; the padding does not count as full.
    pub(super) fn flooded(cells: &Cells) -> Self {
        Self {
            pressure: vec![0.0; cells.count()],
            content: vec![1.0; cells.count()],
            full: cells.area.iter().map(|&area| area > 0.0).collect(),
        }
    }

    /// Takes over another's values; allocates nothing.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.pressure.copy_from_slice(&other.pressure);
        self.content.copy_from_slice(&other.content);
        self.full.copy_from_slice(&other.full);
    }

    /// Whether so many values are stored of each.
    pub(super) fn fits(&self, cells: usize) -> bool {
        [self.pressure.len(), self.content.len(), self.full.len()] == [cells; 3]
    }
}

/// What the film keeps from step to step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    /// Eccentricity ratio of the journal in the bearing's middle plane.
    pub(super) eps: Vector2<f64>,
    /// Its rate, 1/s.
    pub(super) velocity: Vector2<f64>,
    /// Angles through which journal and bush have turned, rad.
    pub(super) angles: [f64; 2],
    /// The internal step that the error control expects to fit, s.
    pub(super) step: Option<f64>,
    pub(super) field: Field,
    /// What a pressure of one in the field stands for, Pa.
    pub(super) unit: f64,
}

impl State {
    /// The journal in the middle of a flooded film.
    pub(super) fn flooded(cells: &Cells) -> Self {
        Self {
            eps: Vector2::zeros(),
            velocity: Vector2::zeros(),
            angles: [0.0; 2],
            step: None,
            field: Field::flooded(cells),
            unit: 0.0,
        }
    }

    /// Takes over another state of the same size; allocates nothing.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.eps = other.eps;
        self.velocity = other.velocity;
        self.angles = other.angles;
        self.step = other.step;
        self.field.copy_from(&other.field);
        self.unit = other.unit;
    }
}
