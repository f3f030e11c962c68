//! Writes a section with a plot: `cargo run --example section > page.html`.

use result_document::svg::{STYLE, picture, text};
use result_document::{Block, Document, Figure};

fn main() {
    let mut document = Document::new("load", "load", "The load");
    document.say("The load was measured once.");
    let figure = Figure {
        file: "load".to_owned(),
        svg: picture("plot", [200.0, 40.0], "The load", &text("title", [100.0, 24.0], "middle", "750 N")),
        ..Figure::default()
    };
    document.blocks.push(Block::Figures("plots".into(), vec![figure]));
    println!("<!doctype html><style>{STYLE}</style>{}", document.as_html());
}
