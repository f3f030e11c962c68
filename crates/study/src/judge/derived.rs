//! Measured values that are the product of two others: their errors follow, and are no second measurement.

use super::{Judge, product, scalar::distance_unit};
use crate::{CriterionText, Name, Result, Study, cases::SEPARATOR, points::Pairs};
use conformity::uncertainty::Uncertainty;
use fmu_import::Description;

/// A criterion whose error follows from others'.
#[derive(Debug)]
pub struct Derived {
    /// Its number.
    number: usize,
    /// The factors' numbers, each with the product over its value.
    factors: Vec<(usize, f64)>,
}

impl Derived {
    fn has_factor(&self, criterion: usize) -> bool {
        self.factors.iter().any(|(factor, _)| *factor == criterion)
    }
}

impl Judge {
    /// Gives criteria that are `derived` the uncertainty that follows from their factors': in a product relative errors
    /// add, and those of two measurements are independent (GUM, 5.1.2 and 5.1.6).
    pub fn derive(&mut self, study: &Study, fmu: Option<&Description>) -> Result {
        for (number, (name, text)) in study.criteria.iter().enumerate() {
            if text.derived.is_none() {
                continue;
            }
            let wrong = |message| study.error_of(name, message);
            if self.criteria[number].uncertainty.is_some() {
                return Err(wrong("its error follows from those of its factors; remove `uncertainty` and the keys beside it, or `derived`".to_owned()));
            }
            let value = |k: usize| self.value(k).filter(|value| *value != 0.0);
            let mut factors: Vec<(usize, f64)> = Vec::new();
            for factor in self.factors(study, text, number).map_err(wrong)? {
                let criterion = &self.criteria[factor];
                let (product, factor_value) = value(number).zip(value(factor)).filter(|_| criterion.uncertainty.is_some()).ok_or_else(|| {
                    wrong(format!(
                        "an error can only follow where both have a measured value other than 0, and {} its `uncertainty`",
                        criterion.name
                    ))
                })?;
                factors.push((factor, product / factor_value));
            }
            let [first, second] = [0, 1].map(|k| factors.get(k).map(|&(k, _)| &self.criteria[k]));
            if let Some(first) = first {
                product::check((study, fmu), text, &self.criteria[number], first, second).map_err(wrong)?;
            }
            if let Some(&(factor, _)) = factors.get(1)
                && self.criteria[factor].measured().error.is_none_or(|error| !error.is_normal())
            {
                return Err(wrong(format!(
                    "the error of {} must be normal: state it without `repeats` and not as rectangular, or exchange `from` and `by`",
                    self.criteria[factor].name
                )));
            }
            let derived = Derived { number, factors };
            self.follow(&derived);
            // In what a limit's distance counts may be this uncertainty.
            let unit = self.criteria[number].distance_unit;
            self.criteria[number].distance_unit = unit.map(|_| distance_unit(&self.criteria[number]));
            self.derived.push(derived);
        }
        Ok(())
    }

    /// Sets the uncertainty of a derived criterion to the one that follows from its factors'.
    fn follow(&mut self, derived: &Derived) {
        let (first, ratio) = derived.factors[0];
        self.criteria[derived.number].uncertainty = self.criteria[first].uncertainty.map(|first| {
            let mut uncertainty =
                Uncertainty { expanded: ratio.abs() * first.expanded, noise: ratio.abs() * first.noise, ..first };
            for &(factor, ratio) in &derived.factors[1..] {
                // In the product it is an error in proportion.
                let relative = ratio * self.size(factor) / self.value(derived.number).unwrap_or(1.0);
                uncertainty.gain = uncertainty.gain.hypot(relative);
            }
            uncertainty
        });
    }

    fn value(&self, criterion: usize) -> Option<f64> {
        self.criteria[criterion].measured().value
    }

    /// The standard uncertainty of a measured value.
    fn size(&self, criterion: usize) -> f64 {
        let error = self.criteria[criterion].measured().error;
        error.map_or(0.0, |error| error.standard())
    }

    /// The numbers of the criteria that are the factors of a derived one.
    fn factors(&self, study: &Study, text: &CriterionText, number: usize) -> Result<Vec<usize>, String> {
        let Some(derived) = &text.derived else { return Ok(Vec::new()) };
        let case = text.case.map(|case| format!("{}{SEPARATOR}", study.cases[case].name.as_ref())).unwrap_or_default();
        let find = |key: &Name| {
            let full = format!("{case}{}", key.as_ref());
            self.names().position(|known| *known == full)
        };
        let [from, by] = [&derived.from, &derived.by].map(|key| key.as_ref().as_str());
        let first = find(&derived.from)
            .ok_or_else(|| format!("there is no criterion `{from}` from which it could be derived"))?;
        let second = find(&derived.by);
        // What the study sets itself has no error.
        let is_set = study.parameters.contains_key(by) || study.setting(by, text).is_some() || study.feeds(by, text);
        if second.is_none() && !is_set {
            return Err(format!("`{by}` is no criterion, and no input or parameter that the study sets"));
        }
        let factors: Vec<usize> = [Some(first), second].into_iter().flatten().collect();
        let is_derived = |k: usize| study.criteria.values().nth(k).is_some_and(|text| text.derived.is_some());
        let is_same = second == Some(first) || factors.contains(&number);
        if is_same || factors.iter().any(|&k| is_derived(k)) {
            Err("it is the product of another criterion and a further one, or an input; neither may be derived itself"
                .to_owned())
        } else {
            Ok(factors)
        }
    }

    /// The stated correlations, and those that follow for derived criteria.
    pub fn with_derived(&self, study: &Study, mut pairs: Pairs) -> Result<Pairs> {
        for (place, &(a, b, _)) in pairs.iter().enumerate() {
            let follows = self.derived.iter().any(|derived| {
                derived.number == a || derived.number == b || derived.has_factor(a) && derived.has_factor(b)
            });
            if follows {
                return Err(study.error_at(&study.uncertainty_correlations[place], "this correlation follows from `derived`, whose factors' errors are independent; remove one of them"));
            }
        }
        for Derived { number, factors } in &self.derived {
            let mut following: Pairs = Vec::new();
            for &(factor, ratio) in factors {
                let part = (ratio * self.size(factor) / self.size(*number)).clamp(-1.0, 1.0);
                following.push((*number, factor, part));
                for &(a, b, coefficient) in &pairs {
                    let other = match factor {
                        _ if a == factor => b,
                        _ if b == factor => a,
                        _ => continue,
                    };
                    match following.iter_mut().find(|(_, known, _)| *known == other) {
                        Some((.., sum)) => *sum += part * coefficient,
                        None => following.push((*number, other, part * coefficient)),
                    }
                }
            }
            let clamped = following.into_iter().map(|(a, b, r)| (a, b, r.clamp(-1.0, 1.0)));
            pairs.extend(clamped);
        }
        Ok(pairs)
    }
}
