//! Statistics of a signal of straight lines: reads rows of time and value, and prints a line for each argument. A number
//! is a percentile of so many percent; `frequency` and `oscillation-amplitude` are those of the strongest oscillation;
//! `rising=1.5`, `falling=1.5` and `either=1.5` are the times, since the first row, at which the signal crosses 1.5.
//!
//! `cargo run -p sampling --example statistics -- 5 50 95 frequency rising=1 < signal.csv`

use std::error::Error;
use std::io::{self, BufRead};

use sampling::statistics::{Accumulator, Direction, Statistic};

fn accumulator(argument: &str) -> Result<Accumulator, Box<dyn Error>> {
    let named = Statistic::ALL.iter().find(|known| known.name() == argument);
    if let Some(statistic) = named {
        return Ok(Accumulator::new(*statistic));
    }
    let Some((direction, level)) = argument.split_once('=') else {
        return Ok(Accumulator::percentile(argument.parse()?));
    };
    let direction = match direction {
        "rising" => Direction::Rising,
        "falling" => Direction::Falling,
        _ => Direction::Either,
    };
    Ok(Accumulator::crossing(level.parse()?, direction))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for line in io::stdin().lock().lines() {
        let line = line?;
        let (time, value) = line.split_once(',').ok_or("a row is: time,value")?;
        rows.push((time.trim().parse()?, value.trim().parse()?));
    }
    let (first, last) = (rows.first().ok_or("no rows")?.0, rows[rows.len() - 1].0);
    for argument in std::env::args().skip(1) {
        let mut statistic = accumulator(&argument)?;
        let mut before = first;
        for &(time, value) in &rows {
            statistic.add(time - before, value);
            before = time;
        }
        println!("{:?}", statistic.result(last - first));
    }
    Ok(())
}
