//! Prints the model description of the lag (`examples/lag`), which makes an FMU of its library.
//! `scripts/bench` packs it.

// Only the description is used; it comes with the whole boundary.
#![allow(dead_code)]

#[path = "../src/fmi2/mod.rs"]
mod fmi2;
#[path = "lag/model.rs"]
mod lag;
#[path = "../src/model.rs"]
mod model;

fn main() {
    print!("{}", fmi2::description::xml::<lag::Lag>());
}
