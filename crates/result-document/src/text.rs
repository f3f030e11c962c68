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
    const MARGIN: usize = 9;
    let mut text = String::new();
    let mut line = format!("{label:<MARGIN$}").trim_end().to_owned();
    for word in sentences.split_whitespace() {
        let length = line.chars().count().max(MARGIN);
        if length > MARGIN && length + 1 + word.chars().count() > WIDTH {
            text = text + &line + "\n";
            line.clear();
        }
        line = match line.chars().count() {
            short if short < MARGIN => format!("{line:<MARGIN$}{word}"),
            _ => line + " " + word,
        };
    }
    text + &line + "\n"
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
    const WIDEST: usize = 132;
    let heads: Vec<String> = table.columns.iter().map(|column| plain(&with_unit(&column.name, &column.unit))).collect();
    let lines: Vec<&Vec<String>> = std::iter::once(&heads).chain(&table.rows).collect();
    let drawn = aligned(&lines, |k| table.columns[k].is_number);
    let width = drawn.lines().map(|line| line.chars().count()).max();
    if width.unwrap_or(0) <= WIDEST || table.rows.len() >= heads.len() {
        return drawn;
    }
    let turned = |k: usize| lines.iter().map(|line| line[k].clone()).collect();
    let turned: Vec<Vec<String>> = (0..heads.len()).map(turned).collect();
    aligned(&turned.iter().collect::<Vec<_>>(), |k| k > 0)
}

fn aligned(lines: &[&Vec<String>], is_number: impl Fn(usize) -> bool) -> String {
    let length = |cell: &String| cell.chars().count();
    let width = |k: usize| lines.iter().map(|line| length(&line[k])).max().unwrap_or(0);
    let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
    lines
        .iter()
        .map(|line| {
            let padded = line.iter().zip(&widths).enumerate().map(|(k, (cell, &width))| {
                if is_number(k) { format!("  {cell:>width$}") } else { format!("  {cell:<width$}") }
            });
            padded.collect::<String>().trim_end().to_owned() + "\n"
        })
        .collect()
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
