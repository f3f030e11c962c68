//! An uncertain parameter that fits an FMU.

use std::path::Path;

use serde::Serialize;

use fmu_import::units::Conversion;
use number_tables::Table;
use sampling::distribution::Distribution;

/// One uncertain parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Input {
    /// The FMU's variable.
    pub name: String,
    /// The unit of the study's numbers.
    pub unit: Option<String>,
    /// The distribution, in that unit.
    #[serde(flatten)]
    pub distribution: Distribution,
    /// From that unit to the FMU's.
    #[serde(skip)]
    pub conversion: Conversion,
    /// Whether the FMU takes whole numbers only.
    #[serde(skip)]
    pub is_whole: bool,
}

impl Input {
    /// Rounds its values in a column of a table where the FMU takes whole numbers only, and says so.
    pub fn round(&self, table: &mut Table, column: usize, path: &Path) {
        let fractions: Vec<&mut f64> =
            table.rows.iter_mut().map(|row| &mut row[column]).filter(|value| value.fract() != 0.0).collect();
        if !self.is_whole || fractions.is_empty() {
            return;
        }
        fmu_points::tell::line!(
            "note: {} takes whole numbers: {} values in {} were rounded",
            self.name,
            fractions.len(),
            path.display()
        );
        fractions.into_iter().for_each(|value| *value = value.round());
    }
}
