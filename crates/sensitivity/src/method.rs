//! The interface of a sensitivity method.

use serde_json::{Map, Value};

use sampling::statistics::estimate::Estimate;

/// Results of a method for one output, under their keys in `sensitivity.json`.
pub type KeyedResults = Map<String, Value>;

/// The estimator of first-order Sobol indices. Results come from the default one; the others are what other programs compute.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstOrder {
    /// The weighted mean of both others that scatters least, with weights from the same runs: their difference has the
    /// mean 0, so that it is a control variate (Lavenberg & Welch 1981, "A perspective on the use of control variables
    /// to increase the efficiency of Monte Carlo simulations", Management Science 27, 322-335).
    #[default]
    Combined,
    /// V - mean((f_B - f_AB)^2) / 2: Jansen (1999), "Analysis of variance designs for model output",
    /// Computer Physics Communications 117, 35-43. Surer where the output has a heavy tail.
    Jansen,
    /// mean(f_B (f_AB - f_A)): Saltelli et al. (2010), table 2 (b). Surer for a parameter without
    /// influence, of which it is exactly 0.
    Saltelli,
}

/// How much is run, and how it is analysed.
#[derive(Clone, Copy, Debug)]
pub struct Settled {
    /// The size of the design. The method says what it counts: base points, trajectories.
    pub size: u64,
    /// The seed.
    pub seed: u64,
}

/// The fixed properties of a method that needs runs of its own.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// Its name in a study and on the command line.
    pub name: &'static str,
    /// The option of the command line that chooses it by its size.
    pub option: &'static str,
    /// Its subject, in words that stand before and after the size: `Sobol indices from`, `base points`.
    pub words: [&'static str; 2],
    /// The size where none is asked for.
    pub usual_size: u64,
    /// The least size at which its intervals were tried on functions with known indices.
    pub tried_size: u64,
}

/// A method that needs runs of its own design.
pub trait FromRuns: Sync {
    /// Its fixed properties.
    fn facts(&self) -> Facts;

    /// Its design in words: `Sobol indices from 256 base points`.
    fn title(&self, size: u64) -> String {
        let [before, after] = self.facts().words;
        format!("{before} {size} {after}")
    }

    /// How many runs this size needs for these parameters.
    fn runs(&self, parameters: usize, size: u64) -> u64;

    /// The points to be run, in the unit cube of the parameters.
    ///
    /// # Errors
    /// When there is no design of this size for these parameters.
    fn design(&self, parameters: usize, settled: &Settled) -> Result<Vec<Vec<f64>>, String>;

    /// Method and cost in words, after `runs` runs.
    fn done(&self, runs: usize, settled: &Settled) -> String {
        format!("{} ({runs} runs)", self.title(settled.size))
    }

    /// Analyses the values of one output, in the order of the design. Returns all keys of the method, whatever the
    /// values.
    fn tell(&self, design: &[Vec<f64>], values: &[f64], settled: &Settled) -> KeyedResults;

    /// The measures to show to people, the one that tells importance first.
    fn shown(&self, told: &KeyedResults) -> Vec<Measure>;
}

/// A number per parameter, as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// Its name.
    pub name: &'static str,
    /// The numbers in the order of the parameters; one without an interval has ends that are not numbers.
    pub estimates: Vec<Estimate>,
    /// Whether it is drawn as bars, and so tells importance.
    pub drawn: bool,
}

impl Measure {
    /// A measure that is drawn.
    pub fn drawn(name: &'static str, estimates: Vec<Estimate>) -> Self {
        Self { name, estimates, drawn: true }
    }

    /// A measure that stands in the table only.
    pub fn listed(name: &'static str, estimates: Vec<Estimate>) -> Self {
        Self { drawn: false, ..Self::drawn(name, estimates) }
    }
}

/// The result under a key, if there is one.
pub(crate) fn read<T: serde::de::DeserializeOwned>(told: &KeyedResults, key: &str) -> Option<T> {
    serde_json::from_value(told.get(key)?.clone()).ok()
}
