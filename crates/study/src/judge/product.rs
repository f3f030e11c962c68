//! Whether a derived value is what it says: the product of its factors, in units that fit.

use super::criterion::Criterion;
use crate::{CriterionText, DerivedText, Setting, Study, values::value_of};
use fmu_import::{
    Description,
    units::{BaseUnit, Conversion},
};

/// How far a product of measured values may be from the measured product: means of swings do not multiply exactly.
const CLOSE: f64 = 0.1;

/// A quantity in SI base units, as far as the study and the FMU tell it.
#[derive(Clone, Copy)]
struct Amount {
    number: Option<f64>,
    /// Exponents of kg, m, s, A, K, mol and cd; an angle has none.
    exponents: Option<[i32; 7]>,
}

impl Amount {
    /// A number of a variable in the variable's own unit.
    fn new(number: Option<f64>, base: Option<BaseUnit>) -> Self {
        let exponents = base.map(|base| std::array::from_fn(|k| base.exponents[k]));
        let to_base = base.map_or(Conversion::IDENTITY, |base| base.to_base);
        Self { number: number.map(|number| to_base.value(number)), exponents }
    }
}

/// Refuses a derived criterion whose unit or value is not the product's of its factors.
///
/// # Errors
/// Says what does not fit.
pub fn check(
    (study, fmu): (&Study, Option<&Description>),
    text: &CriterionText,
    product: &Criterion,
    first: &Criterion,
    second: Option<&Criterion>,
) -> Result<(), String> {
    let Some(DerivedText { from, by }) = &text.derived else { return Ok(()) };
    let of = |criterion| amount_of(criterion, fmu);
    let second = match second {
        Some(criterion) => of(criterion),
        None => amount_of_setting(study, fmu, by.as_ref(), text),
    };
    let [Some(product), Some(first), Some(second)] = [of(product), of(first), second] else { return Ok(()) };
    let amounts = [product, first, second];
    if let [Some(product), Some(a), Some(b)] = amounts.map(|amount| amount.exponents)
        && (0..7).any(|k| product[k] != a[k] + b[k])
    {
        return Err(format!(
            "its unit is not that of {} x {}; remove `derived`, or name other factors",
            from.as_ref(),
            by.as_ref()
        ));
    }
    match amounts.map(|amount| amount.number) {
        [Some(product), Some(a), Some(b)] if (product / (a * b) - 1.0).abs() > CLOSE => Err(format!(
            "its measured value is {:.4} times the product of {} and {}; correct one of them, or remove `derived`",
            product / (a * b),
            from.as_ref(),
            by.as_ref()
        )),
        _ => Ok(()),
    }
}

/// The measured value of a criterion; none where nobody tells its unit.
fn amount_of(criterion: &Criterion, fmu: Option<&Description>) -> Option<Amount> {
    let number = criterion.measured().value;
    let Some(fmu) = fmu else {
        return criterion.unit.is_none().then(|| Amount::new(number, None));
    };
    let variable = fmu.variables.get(&criterion.variable)?;
    let to_variable = match &criterion.unit {
        Some(unit) => fmu.conversion(unit, variable).ok()?,
        None => Conversion::IDENTITY,
    };
    amount(fmu, variable.unit(), number.map(|number| to_variable.value(number)))
}

/// What the study sets; its number is unknown where it varies.
fn amount_of_setting(study: &Study, fmu: Option<&Description>, name: &str, text: &CriterionText) -> Option<Amount> {
    let setting = study.setting(name, text);
    let Some(fmu) = fmu else {
        return match setting? {
            Setting::Number(number) => Some(Amount::new(Some(*number), None)),
            Setting::Integer(number) => Some(Amount::new(Some(*number as f64), None)),
            _ => None,
        };
    };
    let variable = fmu.variables.get(name)?;
    let number = setting.and_then(|setting| value_of(fmu, variable, setting).ok());
    amount(fmu, variable.unit(), number.map(|value| value.number()))
}

fn amount(fmu: &Description, unit: Option<&str>, number: Option<f64>) -> Option<Amount> {
    match unit.filter(|unit| !matches!(*unit, "1" | "" | "-")) {
        None => Some(Amount::new(number, None)),
        Some(unit) => Some(Amount::new(number, Some(fmu.units.0.get(unit)?.base?))),
    }
}
