//! The table of measured cases that `[identify]` names.

use crate::{Identification, Name, Result, Study};
use number_tables::{Column, Table};

/// The columns of the table that the section names, or a single case without any.
pub struct CaseTable {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    /// The cases' names.
    pub labels: Vec<u64>,
}

impl CaseTable {
    /// Reads the table of a study's section.
    ///
    /// # Errors
    /// With its place in the study, when the table cannot be read or a column is not there.
    pub fn read(study: &Study, settings: &Identification) -> Result<Self> {
        let known = settings.known.iter();
        let known = known.map(|(name, known)| (name, Some(&known.column)));
        let latent = settings.latent.iter();
        let latent = latent.map(|(name, latent)| (name, latent.column.as_ref()));
        let measured = settings.measured.iter().map(|(name, text)| (name, text.column.as_ref()));
        let named: Vec<(&Name, &String)> =
            known.chain(latent).chain(measured).filter_map(|(name, column)| Some((name, column?))).collect();
        let Some(path) = &settings.cases else {
            if let Some((name, column)) = named.first() {
                return Err(study
                    .error_at(name, format!("column `{column}` of which table? `cases` is missing under [identify]")));
            }
            return Ok(Self { names: Vec::new(), rows: vec![Vec::new()], labels: vec![1] });
        };
        let wanted: Vec<Column> =
            named.iter().map(|(name, column)| number_tables::column(column, name.as_ref())).collect();
        let table =
            Table::read_points(&study.path_of(path.as_ref()), &wanted).map_err(|error| study.error_at(path, error))?;
        let names = named.into_iter().map(|(_, column)| column.clone());
        Ok(Self { names: names.collect(), rows: table.rows, labels: table.labels })
    }

    /// How many cases there are.
    pub fn cases(&self) -> usize {
        self.rows.len()
    }

    /// A column's numbers, case by case.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let place =
            self.names.iter().position(|known| known == name).expect("every column that the section names was read");
        self.rows.iter().map(|row| row[place]).collect()
    }
}
