//! A document on the terminal.

use super::format::with_unit;
use super::html::between;
use super::{Block, Document, Figure, Table};

impl Document {
    /// The document for the terminal: without its title, which is the command's name, without explanations, and with the
    /// numbers of its figures.
    pub fn as_text(&self) -> String {
        self.blocks.iter().map(block).collect()
    }
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(words) => format!("\n{words}\n"),
        Block::Sentence(words) => format!("{words}\n"),
        Block::Warning(words) => format!("warning: {words}\n"),
        Block::List(sentences) => sentences.iter().map(|one| format!("  {one}\n")).collect(),
        Block::Table(own) => table(own),
        Block::Figures(_, figures) => figures.iter().map(figure).collect(),
        Block::Hint(_) | Block::Legend(_) | Block::Folded(..) => String::new(),
    }
}

fn figure(figure: &Figure) -> String {
    let numbers = figure.numbers.as_ref();
    numbers.map_or_else(String::new, |numbers| {
        format!("\n{}\n{}{}\n", figure.caption, table(numbers), figure.note)
    })
}

/// Columns as wide as their widest cell.
fn table(table: &Table) -> String {
    let heads = table.columns.iter();
    let heads: Vec<String> = heads
        .map(|column| plain(&with_unit(&column.name, &column.unit)))
        .collect();
    let rows = || std::iter::once(&heads).chain(&table.rows);
    let length = |cell: &String| cell.chars().count();
    let widths: Vec<usize> = (0..heads.len())
        .map(|k| rows().map(|row| length(&row[k])).max().unwrap_or(0))
        .collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).zip(&table.columns);
        let padded = cells.map(|((cell, &width), column)| match column.is_number {
            true => format!("  {cell:>width$}"),
            false => format!("  {cell:<width$}"),
        });
        padded.collect::<String>().trim_end().to_owned() + "\n"
    };
    rows().map(line).collect()
}

/// A name without the marks of its index.
fn plain(name: &str) -> String {
    let parts: Vec<&str> = between(name, "_{", "}")
        .into_iter()
        .map(|(part, _)| part)
        .collect();
    parts.join("_").trim_end_matches('_').to_owned()
}
