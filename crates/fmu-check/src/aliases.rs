//! Variables that are one under several names: they have the same base type and value reference (FMI 2.0.5, section
//! 2.2.7).

use crate::document::{Firsts, Sort, Variable};

/// Only one of them can be set, and have a start value; they agree in constancy.
pub fn alias(scalar: Variable) -> Option<String> {
    let earlier = Earlier::of(scalar)?;
    let first = earlier.first(Sort::Any)?;
    let when = |is: bool, sort| earlier.first(sort).filter(|_| is);
    let (settable, independent) = (scalar.is_settable(), scalar.causality == "independent");
    let constant = |scalar: Variable| scalar.variability == "constant";
    let (other, wrong) = if let Some(other) = when(settable, Sort::Settable) {
        (other, "and both can be set")
    } else if let Some(other) = when(independent, Sort::Settable) {
        (other, "and that can be set, but this is the time")
    } else if let Some(other) = when(settable, Sort::Independent) {
        (other, "and this can be set, but that is the time")
    } else if constant(first) != constant(scalar) {
        (first, "but only one of them is constant")
    } else if !constant(first) {
        let other = when(scalar.start().is_some(), Sort::Started)?;
        (other, "and both have a start value")
    } else if !same(first.start()?, scalar.start()?) {
        (first, "but their values differ")
    } else {
        return None;
    };
    Some(earlier.clash(other, wrong))
}

/// They agree in their unit, too.
pub fn unit(scalar: Variable) -> Option<String> {
    let earlier = Earlier::of(scalar)?;
    let other = earlier.first(Sort::WithUnit)?;
    let [one, two] = [other, scalar].map(|scalar| scalar.effective("unit"));
    one.zip(two).is_some_and(|(one, two)| one != two).then(|| earlier.clash(other, "but their units differ"))
}

/// One of them with a unit and another without.
pub fn without_unit(scalar: Variable) -> Option<String> {
    let earlier = Earlier::of(scalar)?;
    let other = earlier.first(Sort::Any)?;
    let [one, two] = [other, scalar].map(|scalar| scalar.effective("unit").is_some());
    let (reference, name) = (earlier.reference, other.name);
    (one != two).then(|| {
        format!("valueReference {reference} is {name}'s, too, but only one of them has a unit: give it to both")
    })
}

/// They may change at the same times.
pub fn variability(scalar: Variable) -> Option<String> {
    let earlier = Earlier::of(scalar)?;
    let other = earlier.first(Sort::Any)?;
    let (reference, one, two) = (earlier.reference, other.variability, scalar.variability);
    (one != two).then(|| {
        format!(
            "valueReference {reference} is {}'s, too, but that is {one} and this is {two}: give both the same variability",
            other.name
        )
    })
}

/// The variables before one that are the same under another name.
struct Earlier<'a> {
    scalar: Variable<'a>,
    firsts: &'a Firsts,
    reference: &'a str,
}

impl<'a> Earlier<'a> {
    fn of(scalar: Variable<'a>) -> Option<Self> {
        let firsts = scalar.document.aliases.get(&scalar.place()?)?;
        Some(Self { scalar, firsts, reference: scalar.node.attribute("valueReference")? })
    }

    /// The first variable of a sort; none where it has the same name, which is a finding of its own.
    fn first(&self, sort: Sort) -> Option<Variable<'a>> {
        let Variable { document, .. } = self.scalar;
        let at = self.firsts[sort as usize].filter(|at| *at < self.scalar.position)?;
        let first = document.scalars[at].as_ref()?;
        (first.name != self.scalar.name).then_some(document.variable(first))
    }

    fn clash(&self, other: Variable, wrong: &str) -> String {
        format!(
            "valueReference {} is {}'s, too, {wrong}: give one of them a valueReference of its own",
            self.reference, other.name
        )
    }
}

/// Whether two values are the same, however they are written.
fn same(one: &str, other: &str) -> bool {
    let numbers = [one, other].map(|text| text.trim().parse::<f64>().ok());
    match numbers {
        [Some(one), Some(other)] => one == other,
        _ => one == other,
    }
}
