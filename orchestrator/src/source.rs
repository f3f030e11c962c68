//! Sources of points: a design, or a table.

use std::path::Path;

use number_tables::{Column, Table};
use sampling::{design::Design, distribution::Distribution};
use study::{ParameterText, Result, Study, inputs::InputError, plan::Input};

/// The points of a run, by index from 0.
pub enum PointSource {
    /// Points of a design.
    Design(Design),
    /// Given points.
    Table(Table),
    /// Points of a design that were chosen, in the order in which they run.
    Chosen {
        /// The design.
        design: Design,
        /// Their places in it.
        places: Vec<u64>,
    },
}

impl PointSource {
    /// The parameters of a study from a table, in the study's units. A fixed parameter needs
    /// no column, and without theirs the errors of recorded inputs are 0.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn from_table(study: &Study, inputs: &[Input], path: &Path) -> Result<Self> {
        let read = |with_errors: bool| Self::read(study, inputs, path, with_errors);
        let has_errors = inputs.len() > study.parameters.len();
        has_errors.then(|| read(true).ok()).flatten().map_or_else(|| read(false), Ok)
    }

    fn read(study: &Study, inputs: &[Input], path: &Path, with_errors: bool) -> Result<Self> {
        let texts = study.parameters.values().map(Some).chain(std::iter::repeat(None));
        let pairs = || texts.clone().zip(inputs);
        let constant = |(parameter, input): (Option<&ParameterText>, &Input)| match (&input.distribution, parameter) {
            (Distribution::Fixed { value }, Some(parameter)) if parameter.column.is_none() => Some(*value),
            (_, None) if !with_errors => Some(0.0),
            _ => None,
        };
        let columns: Vec<Column> = pairs()
            .filter(|&pair| constant(pair).is_none())
            .map(|(parameter, input)| {
                let column = parameter.and_then(|parameter| parameter.column.as_ref());
                (column.into_iter().chain([&input.name]).cloned().collect(), format!("the parameter {}", input.name))
            })
            .collect();
        let mut table = Table::read_points(path, &columns)?;
        let given = inputs.iter().zip(pairs().map(constant)).filter(|(_, constant)| constant.is_none());
        for (column, (input, _)) in given.enumerate() {
            input.round(&mut table, column, path);
        }
        for row in &mut table.rows {
            let mut given = row.iter().copied();
            let values = pairs().map(|pair| {
                constant(pair).or_else(|| given.next()).expect("a row has a cell of each column that was asked for")
            });
            *row = values.collect();
        }
        Ok(Self::Table(table))
    }

    /// Whether points of a table take a recorded input as it is, as its error has no column or is 0 throughout.
    pub fn lacks(&self, inputs: &[Input], error: &InputError) -> bool {
        let place = inputs.iter().position(|input| input.name == error.name);
        matches!((self, place), (Self::Table(table), Some(place)) if table.rows.iter().all(|row| row[place] == 0.0))
    }

    /// How many points there are.
    pub fn len(&self) -> u64 {
        match self {
            Self::Design(design) => design.len(),
            Self::Table(table) => table.rows.len() as u64,
            Self::Chosen { places, .. } => places.len() as u64,
        }
    }

    /// Whether there is no point at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A point's parameters, in the study's units.
    pub fn parameters(&self, index: u64) -> Vec<f64> {
        match self {
            Self::Design(design) => design.point(index),
            Self::Table(table) => table.rows[place(index)].clone(),
            Self::Chosen { design, places } => design.point(places[place(index)]),
        }
    }

    /// A point's number: counted from 1, or the table's own.
    pub fn label(&self, index: u64) -> u64 {
        match self {
            Self::Design(_) | Self::Chosen { .. } => index + 1,
            Self::Table(table) => table.labels[place(index)],
        }
    }

    /// The index of the point that is called so.
    pub fn index_of(&self, label: u64) -> Option<u64> {
        match self {
            Self::Design(_) | Self::Chosen { .. } => (1..=self.len()).contains(&label).then(|| label - 1),
            Self::Table(table) => {
                let place = table.labels.iter().position(|&known| known == label);
                place.map(|place| place as u64)
            }
        }
    }
}

/// The place of a point in a list, which is in the memory.
fn place(index: u64) -> usize {
    usize::try_from(index).expect("there are no more points than memory has places")
}
