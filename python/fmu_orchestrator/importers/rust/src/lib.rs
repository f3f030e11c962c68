//! The scenario as it comes on the command line, and the samples as they go to standard output.

/// `FMU STEP STEPS name=value,... output,...`
pub struct Scenario {
    pub fmu: String,
    pub step: f64,
    pub steps: usize,
    pub start: Vec<(String, f64)>,
    pub outputs: Vec<String>,
}

impl Scenario {
    /// Reads the arguments.
    pub fn from_arguments() -> Self {
        let [fmu, step, steps, start, outputs] =
            std::env::args().skip(1).collect::<Vec<_>>().try_into().expect("five arguments");
        let pair = |pair: &str| {
            let (name, value) = pair.split_once('=').expect("name=value");
            (name.to_owned(), value.parse().expect("a number"))
        };
        Self {
            fmu,
            step: step.parse().expect("a step size"),
            steps: steps.parse().expect("a number of steps"),
            start: start.split(',').filter(|pair| !pair.is_empty()).map(pair).collect(),
            outputs: outputs.split(',').filter(|name| !name.is_empty()).map(str::to_owned).collect(),
        }
    }
}

/// Prints one sample, each value with all its digits, after a word that tells it from what else an
/// importer prints.
pub fn print(values: impl IntoIterator<Item = f64>) {
    let values = values.into_iter().map(|value| format!("{value:?}")).collect::<Vec<_>>();
    println!("sample {}", values.join(","));
}
