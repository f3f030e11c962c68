//! Cases: operating points or tests of one model, with common parameters.
//!
//! A study with cases is read as if its criteria stood in one list, those of the first case first. So whoever asks for
//! values, columns or verdicts sees criteria as in any study; only who simulates asks for the study of a single case.

use crate::Result;
use indexmap::IndexMap;

use toml::Spanned;

use super::{CaseText, CriterionText, LagText, Name, Setting, Simulation, Study};

/// Between the name of a case and that of a criterion.
pub const SEPARATOR: char = '/';

impl Study {
    /// Puts the criteria of all cases into one list, with the names `CASE/NAME`. Criteria of the whole study hold in
    /// every case that has none of the same name.
    pub(super) fn spread_criteria(&mut self) -> Result {
        if self.cases.is_empty() {
            return Ok(());
        }
        self.check_cases()?;
        let common = std::mem::take(&mut self.criteria);
        let mut all = IndexMap::new();
        for (number, case) in self.cases.iter().enumerate() {
            let of_case = criteria(&common, case);
            if of_case.is_empty() {
                let case = case.name.as_ref();
                return Err(self.error_at(&self.cases[number].name, format!(
                    "the case `{case}` has no criteria: add [cases.criteria.NAME] with variable, nominal and tolerance, \
                     or [criteria.NAME] for all cases"
                )));
            }
            for (name, text) in of_case {
                let full = format!("{}{SEPARATOR}{}", case.name.as_ref(), name.as_ref());
                all.insert(Name::new(name.span(), full), CriterionText { case: Some(number), ..text.clone() });
            }
        }
        self.criteria = all;
        Ok(())
    }

    fn check_cases(&self) -> Result {
        for (number, case) in self.cases.iter().enumerate() {
            let name = case.name.as_ref();
            let wrong = |message| Err(self.error_at(&case.name, message));
            if name.trim().is_empty() || name.contains(SEPARATOR) || name.contains(char::is_control) {
                return wrong(format!(
                    "a case needs a name of printable characters without `{SEPARATOR}`, which stands between case and \
                     criterion"
                ));
            }
            let before = &self.cases[..number];
            if before.iter().any(|other| other.name.as_ref() == name) {
                return wrong(format!("two cases have the name `{name}`; rename one of them"));
            }
            if let Some(Err(message)) = case.lag.as_ref().map(LagText::ends) {
                return wrong(format!("case {name}: {message}"));
            }
            let keys = case.fixed.keys().chain(case.inputs.keys());
            if let Some(key) = keys.into_iter().find(|key| self.parameters.contains_key(key.as_ref().as_str())) {
                return Err(self.error_at(key, format!(
                    "{} is under [parameters], which are common to all cases; remove it there or from the case `{name}`",
                    key.as_ref()
                )));
            }
        }
        Ok(())
    }

    /// The study as it is in each case: one study without cases for each of them, or the study itself where it has none.
    pub fn by_case(&self) -> Vec<(Option<&CaseText>, Self)> {
        if self.cases.is_empty() {
            return vec![(None, self.clone())];
        }
        self.cases.iter().enumerate().map(|(number, case)| (Some(case), self.in_case(number, case))).collect()
    }

    fn in_case(&self, number: usize, case: &CaseText) -> Self {
        let mut study = Self { cases: Vec::new(), simulation: case.simulation.or(&self.simulation), ..self.clone() };
        study.criteria.retain(|_, criterion| criterion.case == Some(number));
        // What the case gives takes the place of what the study gives, be that a value or a recording.
        let is_given = |key: &Name| {
            let key = key.as_ref().as_str();
            case.fixed.contains_key(key) || case.inputs.contains_key(key)
        };
        study.fixed.retain(|key, _| !is_given(key));
        study.inputs.retain(|key, _| !is_given(key));
        study.fixed.extend(case.fixed.clone());
        study.inputs.extend(case.inputs.clone());
        study
    }

    /// The study without the cases that are held out, which are never fitted.
    pub fn fitted(&self) -> Self {
        let mut study = self.clone();
        study.cases.retain(|case| !case.held_out);
        let kept = |number: usize| {
            let cases = self.cases.iter().take(number);
            let is_held_out = self.cases.get(number).is_some_and(|case| case.held_out);
            (!is_held_out).then(|| cases.filter(|case| !case.held_out).count())
        };
        study.criteria.retain(|_, criterion| criterion.case.is_none_or(|case| kept(case).is_some()));
        for criterion in study.criteria.values_mut() {
            criterion.case = criterion.case.and_then(kept);
        }
        // Pairs with a value that is held out have no meaning any more.
        let held_out = |name: &Name| {
            let name = name.as_ref().as_str();
            self.criteria.contains_key(name) && !study.criteria.contains_key(name)
        };
        let mut pairs = std::mem::take(&mut study.uncertainty_correlations);
        pairs.retain(|pair| !pair.as_ref().between.iter().any(held_out));
        study.uncertainty_correlations = pairs;
        study
    }

    /// What the study sets a variable to before the start, in the case of a criterion.
    pub fn setting(&self, name: &str, criterion: &CriterionText) -> Option<&Setting> {
        let case = criterion.case.and_then(|case| self.cases.get(case));
        case.and_then(|case| case.fixed.get(name)).or(self.fixed.get(name)).map(Spanned::as_ref)
    }

    /// Whether an input follows a recording, in the case of a criterion.
    pub fn feeds(&self, name: &str, criterion: &CriterionText) -> bool {
        let case = criterion.case.and_then(|case| self.cases.get(case));
        self.inputs.contains_key(name) || case.is_some_and(|case| case.inputs.contains_key(name))
    }
}

impl Simulation {
    /// These settings, and those of `general` where there are none.
    pub fn or(&self, general: &Self) -> Self {
        // Warm-up and window say the same in two ways.
        let is_stated = self.warm_up.is_some() || self.window.is_some();
        let seen = if is_stated { self } else { general };
        Self {
            start: self.start.or(general.start),
            stop: self.stop.or(general.stop),
            step: self.step.or(general.step),
            tolerance: self.tolerance.or(general.tolerance),
            warm_up: seen.warm_up,
            window: seen.window,
            leap: self.leap.or(general.leap),
        }
    }
}

/// The criteria of a case: those of the whole study, of which it may have some otherwise, and its own.
fn criteria<'a>(common: &'a IndexMap<Name, CriterionText>, case: &'a CaseText) -> Vec<(&'a Name, &'a CriterionText)> {
    let of_case = |name: &Name| case.criteria.get_key_value(name.as_ref().as_str());
    let common_ones = common.iter().map(|(name, text)| of_case(name).unwrap_or((name, text)));
    let further = case.criteria.iter().filter(|(name, _)| !common.contains_key(name.as_ref().as_str()));
    common_ones.chain(further).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const STUDY: &str = r#"
fmu = "a.fmu"
fixed = { "oil.temperature" = "40 degC", "drive.speed" = "100 rpm" }
[simulation]
stop = 10
warm-up = 4
leap = true
[parameters.clearance]
distribution = "uniform"
min = 1
max = 2
[criteria.T]
variable = "t"
nominal = 80
tolerance = 1
[criteria.M]
variable = "m"
nominal = 3
tolerance = 1
[[cases]]
name = "slow"
fixed = { "drive.speed" = "300 rpm" }
criteria.T = { variable = "t", nominal = 70, tolerance = 1 }
criteria.F = { variable = "f", nominal = 5, tolerance = 1 }
[[cases]]
name = "fast"
held-out = true
simulation = { stop = 20, window = 3, leap = false }
inputs."drive.speed" = { file = "n.csv" }
"#;

    fn read(from: &str, to: &str) -> Result<Study, String> {
        assert!(STUDY.contains(from), "{from}");
        let text = STUDY.replacen(from, to, 1);
        Study::parse(Path::new("s.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn criteria_of_the_study_hold_in_every_case_that_has_no_other() {
        let study = read("slow", "slow").unwrap();
        let all: Vec<(String, f64)> = study
            .criteria
            .iter()
            .map(|(name, text)| (name.as_ref().clone(), text.nominal.as_ref().unwrap().number))
            .collect();
        let expected = [("slow/T", 70.0), ("slow/M", 3.0), ("slow/F", 5.0), ("fast/T", 80.0), ("fast/M", 3.0)];
        assert_eq!(all, expected.map(|(name, number)| (name.to_owned(), number)));
    }

    #[test]
    fn a_case_counts_more_than_the_study() {
        let study = read("slow", "slow").unwrap();
        let cases = study.by_case();
        let [(Some(slow), one), (Some(fast), other)] = &cases[..] else { panic!("two cases") };
        assert!(!slow.held_out && fast.held_out);
        assert_eq!(one.criteria.len(), 3);
        assert_eq!(one.fixed["drive.speed"].as_ref(), &Setting::Text("300 rpm".to_owned()));
        assert_eq!(one.simulation.warm_up, Some(4.0));
        // A recording takes the place of a value.
        assert!(!other.fixed.contains_key("drive.speed"));
        assert!(other.fixed.contains_key("oil.temperature"));
        assert!(other.inputs.contains_key("drive.speed"));
        let simulation = &other.simulation;
        assert_eq!((simulation.stop, simulation.leap), (Some(20.0), Some(false)));
        assert_eq!((simulation.warm_up, simulation.window), (None, Some(3.0)));
    }

    #[test]
    fn mistakes_have_their_place_and_remedy() {
        let criteria = "[criteria.T]\nvariable = \"t\"\nnominal = 80\ntolerance = 1\n[criteria.M]\nvariable = \"m\"\n\
                        nominal = 3\ntolerance = 1\n";
        for (from, to, expected) in [
            ("\"fast\"", "\"slow\"", "s.toml:26:8: two cases have the name `slow`"),
            ("\"fast\"", "\"fa/st\"", "s.toml:26:8: a case needs a name"),
            (criteria, "", "s.toml:18:8: the case `fast` has no criteria"),
            (
                "{ \"drive.speed\" = \"300",
                "{ clearance = \"300",
                "s.toml:22:11: clearance is under [parameters], which are common to all cases",
            ),
            ("held-out", "heldout", "s.toml:27:1: unknown field `heldout`; did you mean `held-out`?"),
        ] {
            let error = read(from, to).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
