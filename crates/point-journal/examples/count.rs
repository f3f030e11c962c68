//! How many points the journal in a folder holds, and of how many.

use std::env::args_os;
use std::error::Error;

use point_journal::Finished;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = args_os().nth(1).ok_or("the folder is missing")?;
    let finished = Finished::read(folder.as_ref())?;
    match finished.header.points {
        Some(points) => println!("{} of {points} points", finished.count),
        None => println!("{} points", finished.count),
    }
    Ok(())
}
