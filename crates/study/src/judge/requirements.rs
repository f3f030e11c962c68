//! A study's requirements of the model as a whole.

use crate::{
    CriterionText, Name, Required, Result, Study,
    concern::{ACCEPTS_ZERO, Code, Concern},
    points::{Pairs, pairs},
};
use std::collections::HashMap;

use toml::Spanned;

use super::{Judge, criterion::Criterion};
use conformity::{
    decision::Rule,
    measured::{Limits, Measurement},
    risk::Guard,
};
use fmu_import::{Causality, Variable, quantity::Quantity};

/// Refuses a criterion on what the study sets itself: it would only judge the sampling.
pub fn check_variable(study: &Study, text: &CriterionText, variable: Option<&Variable>) -> Result {
    let name = text.variable.as_ref().as_str();
    let kind = match variable.map(|variable| variable.causality) {
        Some(Causality::Input) => "an input",
        Some(Causality::Parameter) => "a parameter",
        Some(Causality::Independent) => "the time",
        Some(_) => return Ok(()),
        None if study.parameters.contains_key(name) || study.setting(name, text).is_some() => "a parameter",
        None if study.feeds(name, text) => "an input",
        None => return Ok(()),
    };
    Err(study.error_at(
        &text.variable,
        format!(
            "{name} is {kind} of the model, not a result of it: a criterion on it judges the study's own \
         setting; remove the criterion or name an output"
        ),
    ))
}

impl Judge {
    /// Reads what is required of the model as a whole, once the criteria are known.
    pub fn add_requirements(&mut self, study: &Study) -> Result {
        self.measurement = self.correlated(study)?;
        if let Some(required) = &study.verdict {
            self.rule = Some(rule(study, required.as_ref())?);
            self.guard = self.guard_band(study, required)?;
        }
        if !self.is_guarded() {
            self.warn_of_uncertainties(study);
        }
        self.warn_of_widths(study);
        self.warn_of_held_out(study);
        self.warn_of_readings(study);
        self.warn_of_contradictions(study);
        self.warn_of_own_values(study);
        Ok(())
    }

    /// A model that agrees with its own values has been compared with nothing.
    fn warn_of_own_values(&mut self, study: &Study) {
        let (names, places): (Vec<&str>, Vec<&Name>) = self
            .criteria
            .iter()
            .zip(study.criteria.keys())
            .filter(|(criterion, _)| criterion.nominal_from.is_some())
            .map(|(criterion, place)| (criterion.name.as_str(), place))
            .unzip();
        let Some(place) = places.first() else { return };
        let warning = study.error_at(
            place,
            format!(
                "no measured value yet: the nominal value of {} comes from a run of the model itself",
                names.join(", ")
            ),
        );
        self.warnings.push(
            Concern::new(Code::NominalFromModel, warning).remedied(
                "Write measured values into the study in place of the model's own, and remove `nominal-from`.",
            ),
        );
    }

    fn correlated(&self, study: &Study) -> Result<Measurement> {
        let pairs = pairs(
            study,
            &study.uncertainty_correlations,
            |name| self.uncertain(study, name),
            "an error is not correlated with itself; name two criteria",
            (|coefficient: f64| (-1.0..=1.0).contains(&coefficient), "the coefficient must be a number from -1 to 1"),
        )?;
        // Draws of curves see to theirs.
        let is_curve = |number: usize| self.criteria[number].metric.is_some();
        for (entry, (a, b, coefficient)) in study.uncertainty_correlations.iter().zip(&pairs) {
            if (is_curve(*a) || is_curve(*b)) && !(is_curve(*a) && is_curve(*b) && coefficient.abs() == 1.0) {
                return Err(study.error_at(entry, "the error of a curve is correlated with that of another curve alone, and fully: coefficient = 1 where \
                               both come from the same sensor (-1 with the other sign); otherwise remove the pair"));
            }
        }
        let mut pairs = self.with_derived(study, pairs)?;
        pairs.retain(|&(a, ..)| !is_curve(a));
        let measured = |count: usize| {
            let criteria = self.criteria.iter().take(count).map(Criterion::measured);
            let pairs: Pairs = pairs.iter().filter(|&&(a, b, _)| a < count && b < count).copied().collect();
            Measurement::new(criteria.collect(), &pairs)
        };
        let told = (0..self.criteria.len()).filter(|&k| self.criteria[k].row_correlation.is_some());
        measured(self.criteria.len()).map(|measurement| measurement.with_told(told.collect())).map_err(|message| {
            // The first criterion with which it cannot be.
            let first = (0..self.criteria.len()).find(|&k| measured(k + 1).is_err());
            let name = first.map_or("", |k| self.criteria[k].name.as_str());
            let message = format!("{message} (with the criteria up to `{name}`)");
            match study.uncertainty_correlations.first() {
                Some(first) => study.error_at(first, message),
                None => study.error(message),
            }
        })
    }

    /// The number of a criterion that has an uncertainty.
    fn uncertain(&self, study: &Study, name: &Name) -> Result<usize> {
        let number = self.number_of(name).map_err(|m| study.error_at(name, m))?;
        let (criterion, name_text) = (&self.criteria[number], name.as_ref());
        if criterion.uncertainty.is_some() || criterion.row_correlation.is_some() {
            return Ok(number);
        }
        Err(study.error_at(
            name,
            format!("{name_text} has no `uncertainty` that could be correlated; add it under [criteria.{name_text}]"),
        ))
    }

    fn guard_band(&mut self, study: &Study, required: &Spanned<Required>) -> Result<Guard> {
        const ONE: &str = "risk, point-risk and guard-band each say which points are accepted; keep one";
        let Required { risk, point_risk, guard_band, .. } = required.as_ref();
        let allowed = |risk, key| {
            self.all_uncertain(study, risk, key)?;
            between_0_and_1(study, risk, "the risk")
        };
        match (risk, point_risk, guard_band) {
            (Some(_), Some(second), _) => Err(study.error_at(second, ONE)),
            (Some(_), _, Some(second)) | (_, Some(_), Some(second)) => Err(study.error_at(second, ONE)),
            (Some(risk), None, None) => Ok(Guard::Limiting { risk: allowed(risk, "risk")? }),
            (None, Some(risk), None) => Ok(Guard::EachPoint { risk: allowed(risk, "point-risk")? }),
            (None, None, Some(band)) => {
                self.all_uncertain(study, band, "a guard band")?;
                let factor = *band.as_ref();
                if factor >= 0.0 && factor.is_finite() {
                    self.warn_of_guard_band(study, band);
                    return Ok(Guard::Given(factor));
                }
                Err(study.error_at(
                    band,
                    format!("the guard band {factor} must be a number of expanded uncertainties, 0 or more"),
                ))
            }
            (None, None, None) => Ok(Guard::Given(0.0)),
        }
    }

    /// A guard band as wide as a tolerance leaves nothing to accept.
    fn warn_of_guard_band(&mut self, study: &Study, band: &Spanned<f64>) {
        let factor = *band.as_ref();
        for criterion in &self.criteria {
            let widest = criterion.measured().largest_margin();
            if factor >= widest {
                let message = format!(
                    "the guard band of {factor} expanded uncertainties leaves nothing of {}'s tolerance {}, \
                     so that no point can be accepted",
                    criterion.name, criterion.stated_tolerance
                );
                let remedy = format!(
                    "Give a guard band below {widest:.3}, measure {} better or widen its tolerance.",
                    criterion.name
                );
                let warning = study.error_at(band, message);
                self.warnings.push(Concern::new(Code::GuardBandTooWide, warning).remedied(remedy));
            }
        }
    }

    fn all_uncertain<T>(&self, study: &Study, at: &Spanned<T>, what: &str) -> Result {
        let mut criteria = self.criteria.iter();
        let Some(without) = criteria.find(|criterion| criterion.uncertainty.is_none()) else {
            return Ok(());
        };
        let message = match without.metric {
            Some(_) => format!(
                "{what} needs the expanded uncertainty of every measured value, and the curve {} has none, since its metric is no \
                 measured value; remove {what} or the criterion",
                without.name
            ),
            None => format!(
                "{what} needs the uncertainty of every measured value; add `uncertainty` under \
                 [criteria.{}]",
                without.name
            ),
        };
        Err(study.error_at(at, message))
    }

    /// What accepts 0 in place of a measured value hardly refuses anything.
    fn warn_of_widths(&mut self, study: &Study) {
        for (criterion, name) in self.criteria.iter().zip(study.criteria.keys()) {
            let measured = criterion.measured();
            let least = measured.error.map_or(0.0, |error| error.expanded);
            let value = measured.value.filter(|value| criterion.metric.is_none() && value.abs() > least);
            let Some(value) = value.filter(|_| !criterion.limits.is_one_sided() && criterion.limits.accepts(0.0))
            else {
                continue;
            };
            let (name_text, unit) = (&criterion.name, criterion.unit_behind());
            let message = format!(
                "{name_text}: with the tolerance {} even 0 is accepted in place of the measured value {value}{unit}",
                criterion.stated_tolerance
            );
            let warning = study.error_at(name, message);
            self.warnings.push(Concern::new(Code::WideTolerance, warning).remedied(ACCEPTS_ZERO));
        }
    }

    /// Where nothing may be fitted, `held-out` sets nothing apart.
    fn warn_of_held_out(&mut self, study: &Study) {
        let Some(first) = study.cases.first().filter(|_| study.cases.iter().all(|case| case.held_out)) else { return };
        let message =
            "every case is held out, and none is left that `identify` may see, so `held-out` sets nothing apart";
        let warning = study.error_at(&first.name, message);
        let remedy = "Remove `held-out` from a case, or add the cases that the parameters were fitted to.";
        self.warnings.push(Concern::new(Code::AllHeldOut, warning).remedied(remedy));
    }

    /// A measured value beyond the limit that it stands beside is a mistake, or a specimen that fails.
    fn warn_of_readings(&mut self, study: &Study) {
        for (criterion, name) in self.criteria.iter().zip(study.criteria.keys()) {
            let Some(reading) = criterion.reading.filter(|&value| !criterion.limits.accepts(value)) else {
                continue;
            };
            let warning = study.error_at(
                name,
                format!(
                    "{}: the measured value {reading}{} is itself beyond the limit ({})",
                    criterion.name,
                    criterion.unit_behind(),
                    criterion.wanted()
                ),
            );
            self.warnings.push(Concern::new(Code::MeasuredBeyondLimit, warning).remedied(format!(
                "Correct the measured value of {} or its limit, unless the model shall fail as the specimen did.",
                criterion.name
            )));
        }
    }

    /// Measured values of one quantity may exclude each other, as those of two sensors do of which one is wrong.
    fn warn_of_contradictions(&mut self, study: &Study) {
        let texts: Vec<_> = study.criteria.iter().collect();
        // Few criteria of a study judge one variable.
        let mut alike: HashMap<(Option<usize>, &str), Vec<usize>> = HashMap::new();
        for (k, (criterion, (name, text))) in self.criteria.iter().zip(&texts).enumerate() {
            let [low, high] = criterion.limits.ends();
            let earlier = alike.entry((text.case, &criterion.variable)).or_default();
            let other = earlier.iter().copied().find(|&other| {
                let [least, most] = self.criteria[other].limits.ends();
                (low > most || least > high) && text.judges_as(texts[other].1)
            });
            earlier.push(k);
            let Some(other) = other.map(|other| &self.criteria[other].name) else {
                continue;
            };
            let warning = study.error_at(*name, format!(
                "no point can meet both {other} and {}: they judge the same value, and their limits have nothing in common",
                criterion.name
            ));
            self.warnings.push(
                Concern::new(Code::Contradictory, warning)
                    .remedied(format!("Find out which of {other} and {} was measured wrongly.", criterion.name)),
            );
        }
    }

    /// Where the measurement is worse than what it shall tell, acceptance means little.
    fn warn_of_uncertainties(&mut self, study: &Study) {
        for (criterion, (name, text)) in self.criteria.iter().zip(&study.criteria) {
            let Some(error) = criterion.measured().error else { continue };
            let Limits { minus, plus, .. } = criterion.limits;
            if !criterion.limits.is_one_sided() && error.expanded > minus.min(plus) {
                let message = format!(
                    "{}: the uncertainty {} exceeds the tolerance {}, so that accepted points often \
                     do not conform",
                    criterion.name,
                    // As the study says it, where that is all of it.
                    match (&text.uncertainty, criterion.uncertainty) {
                        (Some(stated), Some(parts)) if parts.expanded == error.expanded => stated.as_ref().to_string(),
                        _ => format!("{:.4}{}", error.expanded, criterion.unit_behind()),
                    },
                    criterion.stated_tolerance
                );
                let place = text.uncertainty.as_ref().map_or(name.span(), Spanned::span);
                let warning = study.error_at(&Spanned::new(place, ()), message);
                self.warnings.push(Concern::new(Code::UncertaintyAboveTolerance, warning).remedied("Measure better what is less sure than its tolerance, or state a `share` and a `risk` under [verdict]."));
            }
        }
    }
}

fn rule(study: &Study, required: &Required) -> Result<Rule> {
    const USUAL: f64 = 0.95;
    let confidence = required.confidence.as_ref().map_or(Ok(USUAL), |stated| {
        let number = Quantity::from(*stated.as_ref());
        let confidence = share(&number).filter(|&confidence| confidence >= 0.5);
        let message = || format!("the confidence {number} must be at least 0.5 and below 1");
        confidence.ok_or_else(|| study.error_at(stated, message()))
    })?;
    Ok(Rule { share: between_0_and_1(study, &required.share, "the share")?, confidence })
}

fn between_0_and_1(study: &Study, quantity: &Spanned<Quantity>, what: &str) -> Result<f64> {
    share(quantity.as_ref()).ok_or_else(|| {
        study.error_at(
            quantity,
            format!("{what} {} must be more than 0 % and less than 100 %, such as \"5 %\" or 0.05", quantity.as_ref()),
        )
    })
}

/// A share, in percent or not, that is neither nothing nor everything.
pub fn share(quantity: &Quantity) -> Option<f64> {
    let share = match quantity.unit.as_deref() {
        None => quantity.number,
        Some("%") => quantity.number / 100.0,
        Some(_) => return None,
    };
    (share > 0.0 && share < 1.0).then_some(share)
}

#[cfg(test)]
mod tests;
