//! Which points agree with the measurement.

mod requirements;

pub(crate) use requirements::share;

use std::collections::HashSet;

use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::names::did_you_mean;
use crate::study::plan::find;
use crate::study::quantity::{Scale, Sense};
use crate::study::{BOTH_SIDES, CriterionText, Quantity, Study, StudyError};
use conformity::decision::Rule;
use conformity::measured::{Measured, Measurement, Uncertainty};
use conformity::risk::Guard;
use fmu_import::Description;
use sampling::statistics::Statistic;

/// Measured value of one quantity with its tolerance, in the study's unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Criterion {
    /// Its name.
    pub name: String,
    /// The FMU's variable.
    pub variable: String,
    /// Statistic that turns the signal into one number.
    pub statistic: Statistic,
    /// The unit of the numbers.
    pub unit: Option<String>,
    /// The measured value.
    pub nominal: f64,
    /// The accuracy to both sides, in the unit.
    pub tolerance: f64,
    /// The accuracy as the study states it.
    pub stated_tolerance: String,
    /// The uncertainty of the measured value, where the study states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
    /// The group in which it is counted.
    pub group: Option<String>,
}

impl Criterion {
    /// The measured value with its tolerance and uncertainty.
    pub fn measured(&self) -> Measured {
        Measured {
            nominal: self.nominal,
            tolerance: self.tolerance,
            uncertainty: self.uncertainty,
        }
    }

    /// Whether a value agrees with the measurement; the limits themselves do.
    pub fn accepts(&self, value: f64) -> bool {
        accepts(self.nominal, self.tolerance, value)
    }
}

fn accepts(nominal: f64, tolerance: f64, value: f64) -> bool {
    (value - nominal).abs() <= tolerance
}

/// Another reading of the tolerances.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// Its meaning, and why it is there.
    pub about: Option<String>,
    /// A tolerance for each criterion, in its unit.
    pub tolerances: Vec<f64>,
}

/// All criteria of a study.
#[derive(Clone, Debug)]
pub struct Judge {
    /// The criteria in the order of the study.
    pub criteria: Vec<Criterion>,
    /// Groups with the numbers of their criteria, in the order of the study.
    pub groups: Vec<(String, Vec<usize>)>,
    /// Other readings of the tolerances.
    pub variants: Vec<Variant>,
    /// The measured values with the joint distribution of their errors.
    pub measurement: Measurement,
    /// The rule for the model as a whole, where it is another than one point that meets all criteria.
    pub rule: Option<Rule>,
    /// How far the acceptance intervals are drawn in.
    pub guard: Guard,
    /// Warnings about a study that can be used all the same, each with its place.
    pub warnings: Vec<String>,
}

/// Whether a point agrees, criterion by criterion.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PointVerdict {
    /// A flag for each criterion.
    pub passed: Vec<bool>,
}

impl PointVerdict {
    /// Whether the point agrees in everything.
    pub fn verified(&self) -> bool {
        !self.passed.is_empty() && self.passed.iter().all(|&passed| passed)
    }
}

impl Judge {
    /// The criteria of a study. With an FMU, units are converted by its definitions; without
    /// one, all numbers of a criterion must be in one unit.
    ///
    /// # Errors
    /// With line and column, when a number or a unit does not fit, and when there are no criteria.
    pub fn new(study: &Study, fmu: Option<&Description>) -> Result<Self, StudyError> {
        if study.criteria.is_empty() {
            let message = "no criteria: add at least one [criteria.NAME] with variable, nominal \
                           and tolerance";
            return Err(study.error(message));
        }
        check_columns(study)?;
        let mut judge = Self {
            criteria: Vec::new(),
            groups: Vec::new(),
            variants: Vec::new(),
            measurement: Measurement::default(),
            rule: None,
            guard: Guard::Given(0.0),
            warnings: Vec::new(),
        };
        let mut scales = Vec::new();
        for (name, text) in &study.criteria {
            let variable = fmu.map(|fmu| find(fmu, text.variable.as_ref())).transpose();
            let variable = variable.map_err(|message| study.error_at(&text.variable, message))?;
            requirements::check_variable(study, text, variable)?;
            let scale = match (fmu, variable) {
                (Some(fmu), Some(variable)) => Scale::new(text.unit.as_deref(), fmu, variable)
                    .map_err(|message| at_name(study, name, &message))?,
                _ => Scale::alone(text.unit.as_deref()),
            };
            let mut criterion = criterion(name.as_ref(), text, &scale)
                .map_err(|message| at_name(study, name, &message))?;
            criterion.uncertainty = requirements::uncertainty(study, name, text, &scale)?;
            judge.add_to_group(criterion.group.as_deref());
            judge.criteria.push(criterion);
            scales.push(scale);
        }
        judge.add_variants(study, &scales)?;
        judge.add_requirements(study)?;
        Ok(judge)
    }

    fn add_to_group(&mut self, group: Option<&str>) {
        let number = self.criteria.len();
        let Some(group) = group else { return };
        match self.groups.iter_mut().find(|(name, _)| name == group) {
            Some((_, members)) => members.push(number),
            None => self.groups.push((group.to_owned(), vec![number])),
        }
    }

    fn add_variants(&mut self, study: &Study, scales: &[Scale<'_>]) -> Result<(), StudyError> {
        for (name, text) in &study.variants {
            let mut tolerances: Vec<f64> = self
                .criteria
                .iter()
                .map(|criterion| criterion.tolerance)
                .collect();
            for (criterion, quantity) in &text.tolerance {
                let number = self
                    .number_of(criterion)
                    .map_err(|m| study.error_at(criterion, m))?;
                let Some(text) = study.criteria.get(criterion.as_ref().as_str()) else {
                    continue;
                };
                tolerances[number] = tolerance(quantity, &text.nominal, &scales[number])
                    .map_err(|message| at_name(study, criterion, &message))?;
            }
            self.variants.push(Variant {
                name: name.clone(),
                about: text.about.clone(),
                tolerances,
            });
        }
        Ok(())
    }

    fn number_of(&self, name: &Spanned<String>) -> Result<usize, String> {
        let name = name.as_ref();
        let names = || {
            self.criteria
                .iter()
                .map(|criterion| criterion.name.as_str())
        };
        names().position(|known| known == name).ok_or_else(|| {
            let suggestion = did_you_mean(crate::names::nearest(name, names()));
            format!("there is no criterion `{name}`{suggestion}")
        })
    }

    /// Judges the values of one point; `None` is a point that failed.
    pub fn verdict(&self, values: Option<&[f64]>) -> PointVerdict {
        let passed = |(number, criterion): (usize, &Criterion)| {
            values.is_some_and(|values| values.get(number).is_some_and(|&v| criterion.accepts(v)))
        };
        PointVerdict {
            passed: self.criteria.iter().enumerate().map(passed).collect(),
        }
    }

    /// Judges the values of one point by another reading of the tolerances.
    pub fn variant_verdict(&self, variant: &Variant, values: Option<&[f64]>) -> PointVerdict {
        let passed = |(number, criterion): (usize, &Criterion)| {
            let tolerance = variant.tolerances[number];
            values.is_some_and(|values| {
                values
                    .get(number)
                    .is_some_and(|&v| accepts(criterion.nominal, tolerance, v))
            })
        };
        PointVerdict {
            passed: self.criteria.iter().enumerate().map(passed).collect(),
        }
    }

    /// Whether a guard band decides which points are accepted.
    pub fn is_guarded(&self) -> bool {
        self.guard != Guard::Given(0.0)
    }

    /// How far the values are from the measured ones: the root of the sum of the squared
    /// deviations, each relative to its tolerance. The point with the least distance is the nearest one.
    pub fn distance(&self, values: &[f64]) -> f64 {
        let terms =
            self.criteria.iter().zip(values).map(|(criterion, value)| {
                ((value - criterion.nominal) / criterion.tolerance).powi(2)
            });
        // A number in any case: the summary has no way to write another one.
        terms.sum::<f64>().min(f64::MAX).sqrt()
    }
}

/// Refuses criteria whose columns in `points.csv` could not be told apart from other ones.
fn check_columns(study: &Study) -> Result<(), StudyError> {
    const OWN: [&str; 4] = ["point", "verified", "accepted", "status"];
    let parameters = study.parameters.keys().map(|name| name.as_ref().as_str());
    let mut columns: HashSet<String> = OWN
        .into_iter()
        .chain(parameters)
        .map(String::from)
        .collect();
    for name in study.criteria.keys() {
        let text = name.as_ref();
        if text.trim().is_empty() || text.contains(char::is_control) {
            let message = "a criterion needs a name of printable characters";
            return Err(study.error_at(name, message));
        }
        for column in [text.clone(), format!("{text}.ok")] {
            if !columns.insert(column.clone()) {
                let message =
                    format!("points.csv would have two columns `{column}`; rename the criterion");
                return Err(study.error_at(name, message));
            }
        }
    }
    Ok(())
}

fn at_name(study: &Study, name: &Spanned<String>, message: &str) -> StudyError {
    study.error_at(name, format!("{}: {message}", name.as_ref()))
}

fn criterion(name: &str, text: &CriterionText, scale: &Scale<'_>) -> Result<Criterion, String> {
    let nominal = scale.number(&text.nominal, Sense::Value)?;
    if !nominal.is_finite() {
        return Err(format!(
            "the nominal value {} is not a finite number",
            text.nominal
        ));
    }
    Ok(Criterion {
        name: name.to_owned(),
        variable: text.variable.as_ref().clone(),
        statistic: text.statistic,
        unit: scale.unit.clone(),
        nominal,
        tolerance: tolerance(&text.tolerance, &text.nominal, scale)?,
        stated_tolerance: stated(&text.tolerance, &text.nominal, scale),
        uncertainty: None,
        group: text.group.clone(),
    })
}

/// A tolerance as people read it beside the nominal value in the study's unit.
fn stated(quantity: &Quantity, nominal: &Quantity, scale: &Scale<'_>) -> String {
    let is_elsewhere = nominal.unit.is_some() && nominal.unit != scale.unit;
    if is_elsewhere && quantity.unit.as_deref() == Some("%") {
        return format!("{quantity} of {nominal}");
    }
    quantity.to_string()
}

/// A tolerance in the study's unit. Percents are of the nominal value as written: 0.75 % of 82 degC is 0.615 degC.
fn tolerance(quantity: &Quantity, nominal: &Quantity, scale: &Scale<'_>) -> Result<f64, String> {
    let tolerance = match quantity.unit.as_deref() {
        // "+0.5/-1", "-1 .. 0.5"
        Some(rest) if rest.starts_with(['/', '+', '-', '.', ',']) => {
            return Err(format!(
                "the tolerance `{quantity}` cannot be used: {BOTH_SIDES}"
            ));
        }
        Some("%") => scale.part(quantity.number / 100.0, nominal)?,
        _ => scale.number(quantity, Sense::Difference)?,
    };
    if tolerance > 0.0 && tolerance.is_finite() {
        Ok(tolerance)
    } else if nominal.number == 0.0 && quantity.number > 0.0 && quantity.number.is_finite() {
        Err(format!(
            "the tolerance {quantity} of the nominal value 0 is nothing; give it without %"
        ))
    } else {
        Err(format!(
            "the tolerance {quantity} must be a positive, finite number"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const STUDY: &str = r#"
        fmu = "a.fmu"
        [criteria.T]
        variable = "t"
        nominal = 82
        tolerance = "0.75 %"
        unit = "degC"
        group = "temperature"
        [criteria.F]
        variable = "f"
        nominal = "750 N"
        tolerance = "7 %"
        unit = "N"
        [variants.absolute]
        tolerance.T = "0.75 degC"
    "#;

    fn judge(text: &str) -> Result<Judge, String> {
        let study = Study::parse(Path::new("s.toml"), text.to_owned());
        let study = study.map_err(|error| error.to_string())?;
        Judge::new(&study, None).map_err(|error| error.to_string())
    }

    #[test]
    fn percents_are_of_the_nominal_value_as_printed() {
        let judge = judge(STUDY).unwrap();
        assert!((judge.criteria[0].tolerance - 0.615).abs() < 1e-12);
        assert!((judge.criteria[1].tolerance - 52.5).abs() < 1e-12);
        assert!(judge.verdict(Some(&[81.39, 697.5])).verified());
        assert!(!judge.verdict(Some(&[81.33, 700.0])).verified());
        let absolute = &judge.variants[0];
        assert!(
            judge
                .variant_verdict(absolute, Some(&[81.33, 700.0]))
                .verified()
        );
    }

    /// A part of a value in a unit with another zero depends on the unit in which the value is written.
    #[test]
    fn percents_count_in_the_unit_in_which_the_value_is_written() {
        let fmu = r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><CoSimulation modelIdentifier="m"/>
            <UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/>
            <DisplayUnit name="mK" factor="1000"/></Unit></UnitDefinitions>
            <ModelVariables><ScalarVariable name="t" valueReference="0" causality="output"><Real unit="K"/>
            </ScalarVariable></ModelVariables><ModelStructure/></fmiModelDescription>"#;
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("modelDescription.xml"), fmu).unwrap();
        let package = fmu_import::Package::open(folder.path()).unwrap();
        let fmu = package.description();
        let of = |nominal: &str, unit: &str| {
            let text = format!(
                "fmu = \"a\"\n[criteria.T]\nvariable = \"t\"\nnominal = {nominal}\ntolerance = \"1 %\"\n\
                 uncertainty = \"0.5 %\"\n{unit}\n[variants.wide]\ntolerance.T = \"2 %\"\n"
            );
            let study = Study::parse(Path::new("s.toml"), text).unwrap();
            let judge = Judge::new(&study, Some(fmu)).map_err(|error| error.to_string())?;
            let t = &judge.criteria[0];
            let expanded = t.uncertainty.unwrap().expanded;
            assert!((expanded / t.tolerance - 0.5).abs() < 1e-12);
            assert!((judge.variants[0].tolerances[0] / t.tolerance - 2.0).abs() < 1e-12);
            let is_elsewhere = nominal.contains("degC") && unit.is_empty() || unit.contains("mK");
            let words = if is_elsewhere {
                format!("1 % of {}", nominal.trim_matches('"'))
            } else {
                "1 %".to_owned()
            };
            assert_eq!(t.stated_tolerance, words);
            Ok::<_, String>((t.nominal, t.tolerance))
        };
        for (nominal, unit, expected) in [
            ("82", "unit = \"degC\"", (82.0, 0.82)),
            ("\"82 degC\"", "unit = \"degC\"", (82.0, 0.82)),
            ("\"82 degC\"", "", (355.15, 0.82)),
            ("355.15", "", (355.15, 3.5515)),
            ("\"355.15 K\"", "unit = \"K\"", (355.15, 3.5515)),
            ("\"355.15 K\"", "unit = \"mK\"", (355_150.0, 3551.5)),
        ] {
            let (value, tolerance) = of(nominal, unit).unwrap();
            assert!(
                (value - expected.0).abs() < 1e-9,
                "{nominal} {unit}: {value}"
            );
            assert!(
                (tolerance - expected.1).abs() < 1e-9,
                "{nominal} {unit}: {tolerance}"
            );
        }
        let refused = of("\"355.15 K\"", "unit = \"degC\"").unwrap_err();
        assert!(
            refused.contains("T: 1 % could be that of 355.15 K or of 82")
                && refused.contains("\"3.551500 K\" or \"0.820000 degC\""),
            "{refused}"
        );
    }

    #[test]
    fn the_limits_belong_to_what_is_accepted() {
        let judge = judge(&STUDY.replace("0.75 %", "0.5 degC")).unwrap();
        let [t, f] = [&judge.criteria[0], &judge.criteria[1]];
        assert!(t.accepts(81.5) && t.accepts(82.5) && f.accepts(697.5) && f.accepts(802.5));
        assert!(!t.accepts(81.49) && !t.accepts(82.51) && !t.accepts(f64::NAN));
        let variant = |t: f64| judge.variant_verdict(&judge.variants[0], Some(&[t, 750.0]));
        assert_eq!(variant(82.75).passed, [true, true]);
        assert_eq!(variant(82.76).passed, [false, true]);
    }

    #[test]
    fn a_percentage_of_a_negative_value_is_positive() {
        let judge = judge(&STUDY.replace("nominal = 82", "nominal = -82")).unwrap();
        assert!((judge.criteria[0].tolerance - 0.615).abs() < 1e-12);
    }

    #[test]
    fn criteria_of_a_group_are_counted_together() {
        let text = STUDY.replace("unit = \"N\"", "unit = \"N\"\ngroup = \"temperature\"");
        let group = |members: &[usize]| vec![("temperature".to_owned(), members.to_vec())];
        assert_eq!(judge(STUDY).unwrap().groups, group(&[0]));
        assert_eq!(judge(&text).unwrap().groups, group(&[0, 1]));
    }

    #[test]
    fn a_failed_point_is_not_verified() {
        let judge = judge(STUDY).unwrap();
        assert_eq!(judge.verdict(None).passed, [false, false]);
        assert_eq!(judge.verdict(Some(&[82.0])).passed, [true, false]);
        let variant = &judge.variants[0];
        assert_eq!(judge.variant_verdict(variant, None).passed, [false, false]);
        assert!(!PointVerdict::default().verified());
    }

    #[test]
    fn a_distance_adds_the_squares_of_the_deviations() {
        let judge = judge(STUDY).unwrap();
        let distance = judge.distance(&[82.615, 645.0]);
        assert!((distance - 5_f64.sqrt()).abs() < 1e-9, "{distance}");
    }

    #[test]
    fn columns_can_be_told_apart() {
        for name in [
            "point", "verified", "accepted", "status", "T.ok", "a.width", "", "a\\nb",
        ] {
            let text = STUDY
                .replace("[criteria.F]", &format!("[criteria.\"{name}\"]"))
                .replace(
                    "[criteria.T]",
                    "[parameters.\"a.width\"]\ndistribution = \"fixed\"\nvalue = 1\n[criteria.T]",
                );
            let error = judge(&text).unwrap_err();
            assert!(error.contains("name"), "{name}: {error}");
        }
    }

    #[test]
    fn a_distance_is_a_number() {
        let judge = judge(&STUDY.replace("0.75 %", "1e-320 degC")).unwrap();
        assert!(judge.distance(&[80.0, 750.0]).is_finite());
    }

    #[test]
    fn errors_have_their_place() {
        assert!(judge("fmu = \"a\"").unwrap_err().contains("no criteria"));
        let wrong = STUDY.replace("\"0.75 %\"", "\"-1 degC\"");
        assert_eq!(
            judge(&wrong).unwrap_err(),
            "s.toml:3:19: T: the tolerance -1 degC must be a positive, finite number"
        );
        for tolerance in ["1e308 %", "0 %", "0 N", "-7 %"] {
            let error = judge(&STUDY.replace("7 %", tolerance)).unwrap_err();
            assert!(
                error.contains("F: the tolerance") && error.ends_with("positive, finite number"),
                "{error}"
            );
        }
        for tolerance in ["0 %", "-7 %"] {
            let nothing = STUDY.replace("750 N", "0 N").replace("7 %", tolerance);
            assert!(judge(&nothing).unwrap_err().contains("must be a positive"));
        }
        for tolerance in ["+0.5/-1", "+0.5 -1", "-1 .. 0.5"] {
            let error = judge(&STUDY.replace("7 %", tolerance)).unwrap_err();
            assert!(error.contains("is the same to both sides"), "{error}");
        }
        let wrong = STUDY.replace("nominal = 82", "nominal = nan");
        assert_eq!(
            judge(&wrong).unwrap_err(),
            "s.toml:3:19: T: the nominal value NaN is not a finite number"
        );
        let wrong = STUDY.replace("nominal = 82", "nominal = 0");
        assert!(judge(&wrong).unwrap_err().contains("give it without %"));
        let wrong = STUDY.replace("tolerance.T =", "tolerance.TT =");
        assert!(judge(&wrong).unwrap_err().contains("no criterion `TT`"));
        let wrong = STUDY.replace("\"0.75 degC\"", "\"0.75 K\"");
        assert!(judge(&wrong).unwrap_err().contains("without the FMU"));
    }
}
