//! Percentiles over time of a signal of straight lines: reads rows of time and value, and prints a line for each percent
//! among the arguments.
//!
//! `cargo run -p sampling --example percentile -- 5 50 95 < signal.csv`

use std::error::Error;
use std::io::{self, BufRead};

use sampling::statistics::Accumulator;

fn main() -> Result<(), Box<dyn Error>> {
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for line in io::stdin().lock().lines() {
        let line = line?;
        let (time, value) = line.split_once(',').ok_or("a row is: time,value")?;
        rows.push((time.trim().parse()?, value.trim().parse()?));
    }
    let (first, last) = (rows.first().ok_or("no rows")?.0, rows[rows.len() - 1].0);
    for percent in std::env::args().skip(1) {
        let mut percentile = Accumulator::percentile(percent.parse()?);
        let mut before = first;
        for &(time, value) in &rows {
            percentile.add(time - before, value);
            before = time;
        }
        println!("{:?}", percentile.result(last - first));
    }
    Ok(())
}
