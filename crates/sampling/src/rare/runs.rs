//! Runs of the model that a search asks for, and their number.

use super::{Ask, Judged};

/// Runs with a limit.
pub(super) struct Runs<'a, E> {
    ask: Ask<'a, E>,
    /// How many were made.
    pub(super) made: u64,
    /// How many may be made.
    pub(super) most: u64,
}

impl<'a, E> Runs<'a, E> {
    pub(super) fn new(ask: Ask<'a, E>, most: u64) -> Self {
        Self { ask, made: 0, most }
    }

    pub(super) fn left(&self) -> u64 {
        self.most.saturating_sub(self.made)
    }

    /// Results of points, given as standard normal scores.
    pub(super) fn of(&mut self, points: &[Vec<f64>]) -> Result<Vec<Judged>, E> {
        self.made += points.len() as u64;
        (self.ask)(points)
    }

    /// Those of the points at which the event happens.
    pub(super) fn hits(&mut self, points: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, E> {
        let results = self.of(&points)?;
        let pairs = points.into_iter().zip(results);
        Ok(pairs.filter(|(_, r)| r.met).map(|(p, _)| p).collect())
    }

    /// The levels of points.
    pub(super) fn levels(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, E> {
        Ok(self.of(points)?.iter().map(Judged::rank).collect())
    }
}
