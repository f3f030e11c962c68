//! What a sensitivity method is.

use serde_json::{Map, Value};

use super::Estimate;
use super::sobol::FirstOrder;

/// What a method found about one output, by the keys of `sensitivity.json`.
pub type Told = Map<String, Value>;

/// How much is run, and how it is analysed.
#[derive(Clone, Copy, Debug)]
pub struct Settled {
    /// The size of the design: what is counted is the method's to say.
    pub size: u64,
    /// How first-order Sobol indices are estimated.
    pub estimator: FirstOrder,
    /// The seed.
    pub seed: u64,
}

/// A method that needs runs of its own design.
pub trait FromRuns: Sync {
    /// Its name in a study and on the command line.
    fn name(&self) -> &'static str;

    /// The option of the command line that chooses it by its size.
    fn option(&self) -> &'static str {
        "size"
    }

    /// Its design in words: `Sobol indices from 256 base points`.
    fn title(&self, size: u64) -> String;

    /// The size where none is asked for.
    fn usual_size(&self) -> u64;

    /// How many runs that makes for so many parameters.
    fn runs(&self, parameters: u64, size: u64) -> u64;

    /// The points to be run, in the unit cube of the parameters.
    ///
    /// # Errors
    /// When there is no design of this size for so many parameters.
    fn design(&self, parameters: usize, settled: &Settled) -> Result<Vec<Vec<f64>>, String>;

    /// Which of so many rows of the design are a plain sample of the parameters, of which the methods for any points
    /// tell something, too; empty where none are.
    fn plain_sample(&self, parameters: usize, rows: usize) -> Vec<usize>;

    /// What was done, in words, after so many runs.
    fn done(&self, parameters: usize, runs: usize, settled: &Settled) -> String;

    /// What the values of one output tell, in the order of the design; all keys of the method, whatever the values.
    fn tell(&self, design: &[Vec<f64>], values: &[f64], settled: &Settled) -> Told;

    /// What is shown of that, the measure of importance first.
    fn shown(&self, told: &Told) -> Vec<Measure>;
}

/// A method for any points.
pub trait FromPoints: Sync {
    /// What the values of one output tell, given the columns of the parameters.
    fn tell(&self, columns: &[&[f64]], values: &[f64], seed: u64) -> Told;

    /// What is shown of that.
    fn shown(&self, told: &Told) -> Vec<Measure>;
}

/// A number a parameter, as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// Its name.
    pub name: &'static str,
    /// The numbers in the order of the parameters; one without an interval has ends that are not numbers.
    pub estimates: Vec<Estimate>,
    /// Whether it is drawn as bars, and so tells importance.
    pub drawn: bool,
    /// What chance alone may reach.
    pub chance: Option<f64>,
}

impl Measure {
    /// A measure that is drawn.
    pub fn drawn(name: &'static str, estimates: Vec<Estimate>) -> Self {
        Self {
            name,
            estimates,
            drawn: true,
            chance: None,
        }
    }

    /// A measure that stands in the table only.
    pub fn listed(name: &'static str, estimates: Vec<Estimate>) -> Self {
        Self {
            drawn: false,
            ..Self::drawn(name, estimates)
        }
    }
}

/// What stands under a key, if anything does.
pub(super) fn read<T: serde::de::DeserializeOwned>(told: &Told, key: &str) -> Option<T> {
    serde_json::from_value(told.get(key)?.clone()).ok()
}
