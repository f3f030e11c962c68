//! A document on the terminal.

use super::{format::with_unit, html::between};
use crate::document::{Block, Document, Figure, Table};

impl Document {
    /// The document for the terminal: without its title, which is the command's name, without explanations, and with the
    /// numbers of its figures.
    pub fn as_text(&self) -> String {
        text(&self.blocks)
    }
}

/// The parts of a document for the terminal.
pub fn text(blocks: &[Block]) -> String {
    blocks.iter().map(block).collect()
}

/// Sentences beside a label, in lines that a terminal of 80 columns holds.
pub fn wrapped(label: &str, sentences: &str) -> String {
    const WIDTH: usize = 80;
    const MARGIN: usize = 8;
    let mut lines = String::new();
    let mut line = format!("{label:<MARGIN$}");
    for word in sentences.split_whitespace() {
        let has_words = length(&line) > MARGIN;
        if has_words && length(&line) + 1 + length(word) > WIDTH {
            lines = lines + &line + "\n";
            line = " ".repeat(MARGIN);
        }
        line = line + " " + word;
    }
    lines + line.trim_end() + "\n"
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(words) => format!("\n{words}\n"),
        Block::Sentence(words) => format!("{words}\n"),
        Block::Warning(words) => format!("warning: {words}\n"),
        Block::List(sentences) => sentences.iter().map(|one| format!("  {one}\n")).collect(),
        Block::Table(content) => table(content),
        Block::Figures(_, figures) => figures.iter().map(figure).collect(),
        Block::Hint(_) | Block::Legend(_) | Block::Folded(..) => String::new(),
    }
}

fn figure(figure: &Figure) -> String {
    let numbers = figure.numbers.as_ref();
    numbers.map(|numbers| format!("\n{}\n{}{}\n", figure.caption, table(numbers), figure.note)).unwrap_or_default()
}

/// Columns as wide as their widest cell; where that is wider than a screen and the rows are few, a line for each column.
fn table(table: &Table) -> String {
    const SCREEN: usize = 132;
    let heads = table.columns.iter().map(|column| plain(&with_unit(&column.name, &column.unit))).collect();
    let mut rows: Vec<Vec<String>> = vec![heads];
    rows.extend_from_slice(&table.rows);
    let upright = aligned(&rows, |column| table.columns[column].is_number);
    let width = upright.lines().map(length).max().unwrap_or(0);
    if width <= SCREEN || table.rows.len() >= table.columns.len() {
        return upright;
    }
    let column = |k: usize| rows.iter().map(|row| row[k].clone()).collect();
    let turned: Vec<Vec<String>> = (0..table.columns.len()).map(column).collect();
    aligned(&turned, |k| k > 0)
}

/// A line for each row, with its cells at the left of their columns, numbers at the right.
fn aligned(rows: &[Vec<String>], is_number: impl Fn(usize) -> bool) -> String {
    let width = |k: usize| rows.iter().map(|row| length(&row[k])).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let padded = |(k, cell): (usize, &String)| {
        let width = widths[k];
        if is_number(k) { format!("  {cell:>width$}") } else { format!("  {cell:<width$}") }
    };
    let line = |row: &Vec<String>| row.iter().enumerate().map(padded).collect::<String>().trim_end().to_owned() + "\n";
    rows.iter().map(line).collect()
}

/// How many columns of the terminal a text takes.
fn length(text: &str) -> usize {
    text.chars().count()
}

/// A name without the marks of its index.
fn plain(name: &str) -> String {
    between(name, "_{", "}").into_iter().flat_map(|(part, is_index)| [if is_index { "_" } else { "" }, part]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_stands_behind_a_line_and_a_name_keeps_its_own() {
        for (name, expected) in [("u_{num} (K)", "u_num (K)"), ("x_{1}", "x_1"), ("k_", "k_"), ("a_{b}_{c}", "a_b_c")] {
            assert_eq!(plain(name), expected);
        }
    }
}
