//! The unknown of each cell: pressure where it is full, content where it is not.

use super::super::{cells::Cells, liquid::Liquid, state::Field, sweeps::fill};

/// The kinds of the cells' unknowns, as factors of one or zero for sweeps without branches.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// One for cells whose unknown is the pressure.
    pub full: Vec<f64>,
    /// One for cells whose unknown is the content.
    pub empty: Vec<f64>,
    /// One for cells whose balance must hold: those with an unknown.
    pub balanced: Vec<f64>,
    /// Derivative of the oil per gap (density times content) over the cell's unknown.
    pub swell: Vec<f64>,
}

impl Unknowns {
    /// For a number of cells, none of which has an unknown yet.
    pub fn new(cells: usize) -> Self {
        let zeros = || vec![0.0; cells];
        Self { full: zeros(), empty: zeros(), balanced: zeros(), swell: zeros() }
    }

    /// Sorts the cells by their unknowns.
    pub fn sort(&mut self, cells: &Cells, liquid: &Liquid, field: &Field) {
        let conserving = cells.conserves_mass();
        for (c, &full) in field.full.iter().enumerate() {
            let real = cells.area[c] > 0.0;
            self.full[c] = f64::from(full);
            self.empty[c] = f64::from(!full && conserving && real);
            self.balanced[c] = self.full[c] + self.empty[c];
        }
        let of = [&self.full, &liquid.swelling, &self.empty, &liquid.density].map(Vec::as_slice);
        fill(&mut self.swell, of, |[full, swelling, empty, density]| full * swelling + empty * density);
    }

    /// The column with the fewest full cells.
    pub fn emptiest_column(&self, cells: &Cells) -> usize {
        let count = |range: std::ops::Range<usize>| self.full[range].iter().sum::<f64>();
        let counts = cells.columns().map(|(i, range)| (count(range), i));
        let least = counts.min_by(|(one, _), (other, _)| one.total_cmp(other));
        least.map_or(0, |(_, column)| column)
    }
}
