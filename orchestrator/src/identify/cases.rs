//! The table of measured cases.

use toml::Spanned;

use super::error::BindError;
use crate::study::Identification;
use crate::study::{Name, Study};
use crate::table::Table;

/// The columns of the table that the section names, or a single case without any.
pub(super) struct Columns {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    /// The cases' names.
    pub(super) labels: Vec<u64>,
}

impl Columns {
    pub(super) fn read(study: &Study, settings: &Identification) -> Result<Self, BindError> {
        let known = settings
            .known
            .iter()
            .map(|(name, known)| (name, Some(&known.column)));
        let latent = settings
            .latent
            .iter()
            .map(|(name, latent)| (name, latent.column.as_ref()));
        let measured = settings
            .measured
            .iter()
            .map(|(name, text)| (name, text.column.as_ref()));
        let named: Vec<(&Name, &String)> = known
            .chain(latent)
            .chain(measured)
            .filter_map(|(name, column)| Some((name, column?)))
            .collect();
        let Some(path) = &settings.cases else {
            if let Some((name, column)) = named.first() {
                let message = format!(
                    "column `{column}` of which table? `cases` is missing under [identify]"
                );
                return Err(study.error_at(name, message).into());
            }
            return Ok(Self {
                names: Vec::new(),
                rows: vec![Vec::new()],
                labels: vec![1],
            });
        };
        let wanted: Vec<(Vec<String>, String)> = named
            .iter()
            .map(|(name, column)| (vec![(*column).clone()], name.as_ref().clone()))
            .collect();
        let table = Table::read_points(&beside(study, path), &wanted)?;
        Ok(Self {
            names: named
                .into_iter()
                .map(|(_, column)| column.clone())
                .collect(),
            rows: table.rows,
            labels: table.labels,
        })
    }

    /// How many cases there are.
    pub(super) fn cases(&self) -> usize {
        self.rows.len()
    }

    /// A column's numbers, case by case.
    pub(super) fn column(&self, name: &str) -> Vec<f64> {
        // Every column that the section names was read.
        let place = self.names.iter().position(|own| own == name);
        place.map_or_else(Vec::new, |place| {
            self.rows.iter().map(|row| row[place]).collect()
        })
    }
}

/// A path that the study gives relative to itself.
fn beside(study: &Study, path: &Spanned<std::path::PathBuf>) -> std::path::PathBuf {
    study
        .path()
        .parent()
        .unwrap_or("".as_ref())
        .join(path.as_ref())
}
