//! Prints the mean of a column: `cargo run --example column -- run.csv M`.

use std::error::Error;

use number_tables::{Table, column};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(name)) = (arguments.next(), arguments.next()) else {
        return Err("usage: column FILE COLUMN".into());
    };
    let table = Table::read(file.as_ref(), &[column(&name, "the mean")])?;
    let sum: f64 = table.rows.iter().map(|row| row[0]).sum();
    println!("{}", sum / table.rows.len() as f64);
    Ok(())
}
