//! The parts of a result for people, in the order in which they are read.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// A result for people.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Document {
    /// The anchor of its section in the page.
    pub id: Cow<'static, str>,
    /// The words of the link to it.
    pub link: Cow<'static, str>,
    /// Its heading in the page.
    pub title: String,
    /// Its parts, in the order in which they are read.
    pub blocks: Vec<Block>,
}

/// A part of a document.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", content = "content", rename_all = "lowercase")]
pub enum Block {
    /// A heading within the document.
    Heading(String),
    /// One or more sentences.
    Sentence(String),
    /// A caveat, without the full stop.
    Warning(String),
    /// Sentences of one kind.
    List(Vec<String>),
    /// A table.
    Table(Table),
    /// How to read what stands above. The terminal, where less is shown, leaves it out.
    Hint(String),
    /// The meaning of the figures' marks.
    Legend(Vec<Key>),
    /// Figures, in a grid of this class of the style sheet. The terminal shows their numbers.
    Figures(Cow<'static, str>, Vec<Figure>),
    /// A part that a reader unfolds: its title, whether it is open at first, and its content.
    Folded(String, bool, Vec<Block>),
}

/// A table with a head.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Table {
    /// Its name for screen readers.
    pub name: String,
    /// Its look: a class of the style sheet.
    pub class: Cow<'static, str>,
    /// The columns.
    pub columns: Vec<Column>,
    /// The cells, of which the first of a row names it.
    pub rows: Vec<Vec<String>>,
}

/// The head of a column.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Column {
    /// Its words.
    pub name: String,
    /// The unit of its cells.
    pub unit: String,
    /// Whether its cells are numbers, which stand at its right edge.
    pub is_number: bool,
}

/// A column of words.
pub fn words(name: impl Into<String>) -> Column {
    Column { name: name.into(), ..Column::default() }
}

/// A column of numbers.
pub fn numbers(name: impl Into<String>) -> Column {
    Column { is_number: true, ..words(name) }
}

/// The meaning of a mark.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Key {
    /// A small picture of the mark.
    pub svg: String,
    /// Its meaning.
    pub words: String,
}

impl Key {
    /// The mark is a path of this class in a square of 14 units.
    pub fn new(class: &str, path: &str, words: impl Into<String>) -> Self {
        Self {
            svg: format!("<svg class=\"plot key\" viewBox=\"0 0 14 14\"><path class=\"{class}\" d=\"{path}\"/></svg>"),
            words: words.into(),
        }
    }
}

/// A picture.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Figure {
    /// The name of its file, without ending.
    pub file: String,
    /// The words above it; may be empty.
    pub caption: String,
    /// The picture.
    pub svg: String,
    /// A remark on it; may be empty.
    pub note: String,
    /// The numbers that it shows.
    pub numbers: Option<Table>,
}

impl Table {
    /// A table of the usual look.
    pub fn new(name: impl Into<String>, columns: impl Into<Vec<Column>>, rows: Vec<Vec<String>>) -> Self {
        Self { name: name.into(), class: Cow::default(), columns: columns.into(), rows }
    }
}

impl Document {
    /// A document without content; its parts follow.
    pub fn new(id: &'static str, link: &'static str, title: impl Into<String>) -> Self {
        Self { id: id.into(), link: link.into(), title: title.into(), blocks: Vec::new() }
    }

    /// Adds a heading.
    pub fn heading(&mut self, words: impl Into<String>) {
        self.blocks.push(Block::Heading(words.into()));
    }

    /// Adds sentences.
    pub fn say(&mut self, sentences: impl Into<String>) {
        self.blocks.push(Block::Sentence(sentences.into()));
    }

    /// Adds caveats.
    pub fn warn(&mut self, warnings: &[String]) {
        self.blocks.extend(warnings.iter().cloned().map(Block::Warning));
    }

    /// Adds a table, unless it is empty.
    pub fn table(&mut self, table: Table) {
        if !table.rows.is_empty() {
            self.blocks.push(Block::Table(table));
        }
    }

    /// Adds a list.
    pub fn list(&mut self, sentences: Vec<String>) {
        self.blocks.push(Block::List(sentences));
    }

    /// Adds the meaning of marks.
    pub fn legend(&mut self, keys: impl Into<Vec<Key>>) {
        self.blocks.push(Block::Legend(keys.into()));
    }

    /// Adds pictures in a grid of this class.
    pub fn show(&mut self, grid: &'static str, figures: impl IntoIterator<Item = Figure>) {
        self.blocks.push(Block::Figures(grid.into(), Vec::from_iter(figures)));
    }

    /// Adds an explanation for the page.
    pub fn hint(&mut self, words: impl Into<String>) {
        self.blocks.push(Block::Hint(words.into()));
    }

    /// All pictures with the names of their files.
    pub fn figures(&self) -> Vec<&Figure> {
        fn within(block: &Block) -> Vec<&Figure> {
            match block {
                Block::Figures(_, figures) => figures.iter().collect(),
                Block::Folded(_, _, blocks) => blocks.iter().flat_map(within).collect(),
                _ => Vec::new(),
            }
        }
        self.blocks.iter().flat_map(within).collect()
    }
}
