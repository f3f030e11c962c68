//! The sensitivity of all outputs of a study in one result: of every criterion, and of "is verified".

use super::failures;
use parameter_regions::table::PointTable;
use sensitivity::{
    Estimate, RUNS, dominant,
    method::{FromRuns, KeyedResults, Measure, Settled},
    shapley::{self, Effects},
    sobol::Indices,
};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;

/// The sensitivity of a study's outputs to its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// The parameters, in the order of all lists below.
    pub parameters: Vec<String>,
    /// The units of parameters and criteria that have one, by name.
    #[serde(default)]
    pub units: BTreeMap<String, String>,
    /// Description of the method and its cost, for people.
    pub method: String,
    /// Runs that it rests on.
    pub runs: usize,
    /// Runs that did not give all results.
    pub failed: usize,
    /// Caveats for the reader.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// The criteria, then `verified`, and where runs failed `failed`: whether a run failed.
    pub outputs: Vec<Output>,
}

/// The sensitivity of one output.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// The output's name.
    pub name: String,
    /// Runs that have no value of it.
    #[serde(default)]
    pub missing: usize,
    /// The methods' results under their keys; null where a method was not used or had too few points.
    #[serde(flatten)]
    pub told: KeyedResults,
    /// The parameter that matters most, where the intervals allow to say so.
    pub dominant: Option<String>,
}

impl Output {
    /// The measures to show, of the method that was used.
    pub fn shown(&self) -> Vec<Measure> {
        RUNS.iter().flat_map(|method| method.shown(&self.told)).chain(shapley::shown(&self.told)).collect()
    }

    /// Why no parameter is called the most important.
    pub fn undecided(&self) -> &'static str {
        let shown = self.shown();
        let Some(first) = shown.iter().find(|measure| measure.drawn) else {
            return "too few runs have values for a number by which the parameters could be compared";
        };
        let surest = &first.estimates;
        let all = |holds: fn(&Estimate) -> bool| surest.iter().all(holds);
        if all(|e| e.value == 0.0 && e.low == 0.0 && e.high == 0.0) {
            "all numbers are 0: the output is the same in all runs that have a value, so no parameter matters to it"
        } else if !all(|e| e.value.is_finite()) {
            "a parameter has no number, as too few runs tell it, so none can be called the most important"
        } else if surest.iter().any(|estimate| estimate.low.is_nan() || estimate.high.is_nan()) {
            "without intervals, as too few runs carry its variance, no parameter can be called the most important: take more"
        } else {
            "the intervals overlap: no parameter can be called the most important"
        }
    }
}

/// The parameter whose first measure is largest, where the intervals leave no doubt.
fn most_important(shown: &[Measure], parameters: &[String]) -> Option<String> {
    let surest = &shown.iter().find(|measure| measure.drawn)?.estimates;
    // A parameter without a number could be the most important.
    if surest.iter().any(|estimate| !estimate.value.is_finite()) {
        return None;
    }
    let index = dominant(surest)?;
    (surest[index].value != 0.0).then(|| parameters[index].clone())
}

/// The keys of the methods that were not used, without values.
fn unused(seed: u64) -> KeyedResults {
    let settled = Settled { size: 0, seed };
    RUNS.iter().flat_map(|method| method.tell(&[], &[], &settled)).collect()
}

/// Analyses the runs of a method's own design.
pub fn from_runs(method: &dyn FromRuns, design: &[Vec<f64>], rows: &PointTable, settled: &Settled) -> Sensitivity {
    let parameters: Vec<String> = rows.parameters.iter().map(|p| p.name.clone()).collect();
    let mut warnings = failures::warnings(rows);
    let mut told_outputs = Vec::new();
    for (name, values) in outputs(rows) {
        let mut told = unused(settled.seed);
        told.extend(method.tell(design, &values, settled));
        for parameter in first_above_total(&told, &parameters) {
            warnings.push(format!(
                "the first-order index of {parameter} in {name} is above its total by more than its error, which no model has: \
                 take more base points"
            ));
        }
        let dominant = most_important(&method.shown(&told), &parameters);
        told_outputs.push(Output { missing: failures::missing(&values), name, told, dominant });
    }
    let tried = method.facts().tried_size;
    if settled.size < tried {
        warnings.push(format!(
            "{}: the intervals were tried from {tried} on; with so few they may be too narrow",
            method.title(settled.size)
        ));
    }
    let of_parameters = rows.parameters.iter().map(|p| (&p.name, &p.unit));
    let of_criteria = rows.criteria.iter().map(|c| (&c.name, &c.unit));
    let units = of_parameters.chain(of_criteria).filter(|(_, unit)| !unit.is_empty());
    Sensitivity {
        units: units.map(|(name, unit)| (name.clone(), unit.clone())).collect(),
        outputs: told_outputs,
        method: method.done(rows.len(), settled),
        runs: rows.len(),
        failed: failures::failed(rows),
        warnings,
        parameters,
    }
}

/// Sobol indices of independent parameters and Shapley effects that a surrogate told of an output, if it told any; so many runs
/// have no value of it.
pub fn by_surrogate(
    name: String,
    missing: usize,
    found: Option<(Option<Indices>, Effects)>,
    parameters: &[String],
    seed: u64,
) -> Output {
    let mut told = unused(seed);
    if let Some((indices, effects)) = found {
        told.insert("sobol".to_owned(), json!(indices));
        told.insert(shapley::KEY.to_owned(), json!(effects));
    }
    let mut output = Output { missing, dominant: None, name, told };
    output.dominant = most_important(&output.shown(), parameters);
    output
}

/// The parameters whose first-order index lies above the total one by more than the error of both.
fn first_above_total(told: &KeyedResults, parameters: &[String]) -> Vec<String> {
    let indices = told.get("sobol").and_then(|told| serde_json::from_value::<Indices>(told.clone()).ok());
    let Some(Indices { first, total, .. }) = indices else { return Vec::new() };
    let half = |estimate: &Estimate| 0.5 * (estimate.high - estimate.low);
    let all = first.into_iter().zip(total).zip(parameters);
    all.filter(|((first, total), _)| first.value - total.value > half(first).hypot(half(total)))
        .map(|(_, parameter)| parameter.clone())
        .collect()
}

/// The criteria's values; 1 or 0 for verified or not, where a run that failed is not; and 1 or 0 for failed or not, where
/// any run failed.
fn outputs(table: &PointTable) -> Vec<(String, Vec<f64>)> {
    let flags = |flag: &dyn Fn(usize) -> bool| (0..table.len()).map(flag).map(f64::from).collect();
    let criteria = table.criteria.iter().map(|c| (c.name.clone(), c.values.clone()));
    let verified = ("verified".to_owned(), flags(&|i| table.verified[i]));
    let failed = (failures::failed(table) > 0).then(|| {
        // A criterion may have this name.
        let taken = table.criteria.iter().any(|c| c.name == failures::OUTPUT);
        let name = if taken { "the run failed" } else { failures::OUTPUT };
        (name.to_owned(), flags(&|i| !table.completed(i)))
    });
    criteria.chain([verified]).chain(failed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An output with these two indices.
    fn output(effects: [Estimate; 2]) -> Output {
        let effects = Effects { effects: effects.to_vec() };
        Output { told: KeyedResults::from_iter([(shapley::KEY.to_owned(), json!(effects))]), ..Output::default() }
    }

    #[test]
    fn why_no_parameter_is_the_most_important_is_said_as_it_is() {
        let nothing = Estimate::around(f64::NAN, f64::NAN);
        let bare = |value| Estimate { value, ..nothing };
        for (output, words) in [
            (Output::default(), "too few runs have values"),
            (output([nothing; 2]), "a parameter has no number"),
            (output([nothing, Estimate::around(0.8, 0.1)]), "a parameter has no number"),
            (output([Estimate::around(0.0, 0.0); 2]), "all numbers are 0"),
            (output([bare(0.8), bare(0.3)]), "without intervals"),
            (output([Estimate::around(0.8, 0.3), Estimate::around(0.5, 0.2)]), "the intervals overlap"),
        ] {
            assert_eq!(most_important(&output.shown(), &["a".into(), "b".into()]), None);
            let said = output.undecided();
            assert!(said.starts_with(words), "{said}");
        }
    }
}
