//! The parameters and the criteria of a study.

use std::env::args_os;
use std::error::Error;

use study::Study;

fn main() -> Result<(), Box<dyn Error>> {
    let file = args_os().nth(1).ok_or("the study is missing")?;
    let study = Study::read(file.as_ref())?;
    println!("parameters of {}:", study.fmu_path().display());
    for (name, parameter) in &study.parameters {
        println!("  {}: {:?}", name.as_ref(), parameter.distribution);
    }
    println!("criteria:");
    for (name, criterion) in &study.criteria {
        println!("  {}: {}", name.as_ref(), criterion.about.as_deref().unwrap_or(""));
    }
    Ok(())
}
