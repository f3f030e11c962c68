//! What an identification says, for the terminal and its page: parameters, sensors, fit and residuals.

use std::{ops::Range, path::Path};

use calibration::{
    fit::FitVerdict,
    influence::Group,
    local::End,
    outcome::{FreeOutcome, IdentificationOutcome, OptimumOutcome, Residual},
    sample,
    surrogate::text::sentences,
    text,
};
use conformity::conclusion::grouped;

use crate::{error::Result, identify::bind::Bound, plain, results::words::unit_behind};
use result_document::{
    Block, Document, Figure, Key, Table,
    format::{cleared, digits_between, number, shown},
    numbers,
    svg::{Frame, area},
    words,
};

/// Most rows of the table of values, and curves that are drawn.
const MOST_ROWS: usize = 200;
const MOST_CURVES: usize = 24;
/// The values of so many cases are folded.
const MANY_CASES: usize = 6;

/// An identification for its page.
pub struct Page<'a> {
    pub title: &'a str,
    pub bound: &'a Bound,
    pub outcome: &'a IdentificationOutcome,
}

/// Quantities that were measured together, in all cases.
fn group(bound: &Bound, name: &str, quantities: Range<usize>) -> Group {
    let cases = 0..bound.problem.cases.len();
    let values = quantities.flat_map(|quantity| cases.clone().map(move |case| [case, quantity]));
    Group { name: name.to_owned(), values: values.collect() }
}

/// The measured curves.
pub fn curves(bound: &Bound) -> Vec<Group> {
    bound.curves.iter().map(|curve| group(bound, &curve.name, curve.quantities.clone())).collect()
}

/// What was measured together: the curves, and the single quantities.
pub fn groups(bound: &Bound) -> Vec<Group> {
    let singles = singles(bound).map(|k| group(bound, &bound.problem.quantities[k].name, k..k + 1));
    curves(bound).into_iter().chain(singles).collect()
}

/// The quantities that are no rows of a curve.
fn singles(bound: &Bound) -> impl Iterator<Item = usize> {
    let of_curve = |k: &usize| bound.curves.iter().any(|c| c.quantities.contains(k));
    (0..bound.problem.quantities.len()).filter(move |k| !of_curve(k))
}

impl Page<'_> {
    /// The result, in the order in which it is read.
    fn documents(&self) -> Vec<Document> {
        let causes = super::causes::document(self.outcome);
        let documents = [causes, Some(self.parameters()), self.sensors(), Some(self.fit())];
        documents.into_iter().flatten().collect()
    }

    /// The result as a section of a page.
    pub fn section(&self) -> Document {
        let (_, headline, told) = self.headline();
        let mut section = Document::new("identification", "Identification", "Which parameters fit the measured values");
        section.warn(&self.warnings());
        section.say(format!("{headline}."));
        told.into_iter().for_each(|sentence| section.say(sentence));
        for document in self.documents() {
            section.heading(document.title);
            section.blocks.extend(document.blocks);
        }
        section
    }

    /// Writes the page into a folder.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&self, folder: &Path) -> Result {
        let (is_good, headline, _) = self.headline();
        let page = plain::Page {
            kicker: "Identification",
            title: self.title,
            headline: &headline,
            is_good,
            documents: &[self.section()],
        };
        page.write(&folder.join("report.html"))
    }

    /// Whether all is well, what came of it, and how well it fits.
    fn headline(&self) -> (bool, String, Vec<String>) {
        let outcome = self.outcome;
        let (values, fit) = (self.bound.problem.values(), outcome.fit());
        let headline = match fit {
            _ if outcome.end != End::Converged => "The search ended before it converged".to_owned(),
            _ if outcome.has_several() => text::several(outcome).unwrap_or_default(),
            FitVerdict::Good => "The model fits the measured values".to_owned(),
            FitVerdict::Untested => "Nothing is left to test the model by".to_owned(),
            FitVerdict::Misses => "The model misses the measured values".to_owned(),
        };
        let mut agreement = vec![format!(
            "{} measured value{}; sum of squares {} with {} degrees of freedom.",
            grouped(values),
            if values == 1 { "" } else { "s" },
            number(outcome.cost, 4),
            outcome.degrees_of_freedom,
        )];
        agreement.extend(super::causes::headline(outcome));
        if outcome.is_explained() {
            agreement.push("What follows is the fit without that.".to_owned());
        }
        agreement.extend(text::doubts(outcome));
        if outcome.has_several() && fit != FitVerdict::Misses {
            agreement.push("None of them is \"the\" value: further measurements must decide.".to_owned());
        }
        if let (FitVerdict::Good, Some(p), [_]) = (fit, outcome.probability, &agreement[..]) {
            agreement.push(format!("A right model misses by more in {} % of such tests.", number(100.0 * p, 2)));
        }
        let is_one = outcome.end == End::Converged && !outcome.has_several();
        (is_one && fit == FitVerdict::Good && self.warnings().is_empty(), headline, agreement)
    }

    fn warnings(&self) -> Vec<String> {
        let concerns = super::concerns(self.outcome).into_iter();
        concerns.map(|concern| concern.to_string().trim_end_matches('.').to_owned()).collect()
    }

    fn residual(&self, case: usize, quantity: usize) -> &Residual {
        &self.outcome.cases[case].residuals[quantity]
    }

    fn fit(&self) -> Document {
        let mut told = Document::new("fit", "Fit", "Fit and residuals");
        let mut curves = self.bound.curves.iter().peekable();
        if curves.peek().is_some() {
            told.legend([
                Key::new("line measured", "M0,9l3,-5l3,6l3,-6l5,4", "measured"),
                Key::new("band", "M0,3h14v8h-14z", "two standard deviations of its noise"),
                Key::new("line", "M0,7h14", "model"),
            ]);
            let figures = curves.by_ref().take(MOST_CURVES).filter_map(|curve| {
                let rows = curve.quantities.clone();
                let rows: Vec<&Residual> = rows.map(|k| self.residual(0, k)).collect();
                fitted(&curve.name, shown(&curve.unit), &curve.times, &rows)
            });
            told.show("planes", figures);
            let left = self.bound.curves.len().saturating_sub(MOST_CURVES);
            if left > 0 {
                told.say(format!("{left} more curves are not drawn."));
            }
            told.hint(
                "*Below each curve*: model less measurement in standard deviations of a row's noise, after the shared errors that the data \
                 prefer are taken out of the measurement. Of a right model nineteen rows in twenty lie in the band, in no order: waves \
                 and steps are what the model, or the stated noise, does not explain.",
            );
        }
        let rows: Vec<_> = singles(self.bound).flat_map(|quantity| self.rows(quantity)).collect();
        let is_long = self.outcome.cases.len() >= MANY_CASES;
        if (rows.is_empty() || is_long) && !self.outcome.is_farthest_doubtful() {
            text::largest(self.outcome).into_iter().for_each(|sentence| told.say(sentence));
        }
        if is_long && !rows.is_empty() {
            told.blocks.push(Block::Folded("All values".into(), false, vec![Block::Table(values(rows))]))
        } else {
            told.table(values(rows))
        }
        list(&mut told, text::excluded(self.outcome));
        list(&mut told, self.outcome.surrogate.as_ref().map(sentences).unwrap_or_default());
        items(&mut told, text::influence(self.outcome));
        text::searches(self.outcome).into_iter().for_each(|sentence| told.say(sentence));
        told
    }

    /// The rows of the table of a quantity, a row a case.
    fn rows(&self, quantity: usize) -> Vec<Vec<String>> {
        let cases = &self.outcome.cases;
        let unit = unit_behind(self.bound.problem.quantities[quantity].unit.as_deref());
        let row = |case: usize| {
            let value = self.residual(case, quantity);
            let name = match cases.len() {
                1 => value.quantity.clone(),
                _ => format!("{}, case {}", value.quantity, cases[case].label),
            };
            let [measured, model] = [value.measured, value.predicted].map(|v| number(v, 5) + &unit);
            let missed = value.missed();
            vec![
                name,
                measured,
                model,
                number(cleared(value.difference, value.accuracy), 3),
                number(cleared(missed, 1.0), 3),
            ]
        };
        (0..cases.len().min(MOST_ROWS)).map(row).collect()
    }

    fn sensors(&self) -> Option<Document> {
        let said = text::shared(self.outcome);
        let mut told = Document::new("errors", "Sensors", "What the data say of the sensors");
        told.hint(
            "The parameters and these errors are estimated together, so an interval that holds 0 says that no error is needed.",
        );
        told.blocks.insert(0, Block::List(said.clone()));
        (!said.is_empty()).then_some(told)
    }

    fn parameters(&self) -> Document {
        let mut told = Document::new("parameters", "Parameters", "Parameters");
        // Of a parameter of which so much is left the search tells its start or a bound.
        const NOTHING: f64 = 0.9;
        let rows = self.outcome.optima.iter().enumerate().flat_map(|(place, optimum)| {
            optimum.free.iter().map(move |free| {
                let name = if self.outcome.has_several() {
                    format!("{}, optimum {}", free.name, place + 1)
                } else {
                    free.name.clone()
                };
                let [value, low, high] = self::told(free);
                vec![
                    name,
                    if free.left > NOTHING {
                        "the data do not tell".to_owned()
                    } else {
                        value + &unit_behind(free.unit.as_deref())
                    },
                    match free.at_bound {
                        Some(side) => format!("{low} .. {high}, at its {side} bound"),
                        None => format!("{low} .. {high}"),
                    },
                    format!("{} %", number(100.0 * free.left, 2)),
                ]
            })
        });
        let columns = [
            words("Parameter"),
            numbers("Most probable"),
            numbers(self.outcome.interval()),
            numbers("Left of the prior's spread"),
        ];
        told.table(Table::new("Parameters", columns, rows.collect()));
        if self.outcome.has_several() {
            let optimum = |(place, optimum): (usize, &OptimumOutcome)| {
                format!(
                    "optimum {}: {} % of the posterior, sum of squares {}, reached by {} searches",
                    place + 1,
                    number(100.0 * optimum.weight, 4),
                    number(optimum.cost, 6),
                    optimum.reached
                )
            };
            items(&mut told, self.outcome.optima.iter().enumerate().map(optimum).collect());
        }
        items(&mut told, text::remarks(self.outcome));
        list(&mut told, text::open(self.outcome));
        self.outcome.notes.iter().for_each(|note| told.say(note));
        if let (Some(sample), Some(evidence)) = (&self.outcome.posterior, &self.outcome.evidence) {
            told.heading("Sample of the posterior");
            let columns =
                [words("Parameter"), numbers("Mean"), numbers("Deviation"), numbers("Median"), words("95 % of it")];
            told.table(Table::new("Sample of the posterior", columns, sample::text::marginals(sample)));
            list(&mut told, sample::text::sentences(sample, evidence));
        }
        told
    }
}

/// Adds a sentence, and what follows from it as a list.
fn list(told: &mut Document, sentences: Vec<String>) {
    let mut sentences = sentences.into_iter();
    sentences.next().into_iter().for_each(|first| told.say(first));
    items(told, sentences.collect());
}

/// Adds a list, unless it is empty.
fn items(told: &mut Document, sentences: Vec<String>) {
    if !sentences.is_empty() {
        told.list(sentences);
    }
}

/// The range of an axis with a margin; none of equal values.
fn range(all: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    let margin = 0.05 * (high - low);
    (margin > 0.0).then_some([low - margin, high + margin])
}

/// Value and interval of a parameter, with digits that tell them apart.
fn told(free: &FreeOutcome) -> [String; 3] {
    let [low, high] = free.interval;
    let digits = digits_between(free.interval) - 1;
    [free.value, low, high].map(|v| number(cleared(v, high - low), digits))
}

/// The table of measured values.
fn values(rows: Vec<Vec<String>>) -> Table {
    let columns = [
        words("Value"),
        numbers("Measured"),
        numbers("Model"),
        numbers("Model less measured"),
        numbers("in standard uncertainties"),
    ];
    Table::new("Measured values", columns, rows)
}

/// A curve with its residuals below.
fn fitted(name: &str, unit: &str, times: &[f64], rows: &[&Residual]) -> Option<Figure> {
    let of = |value: &dyn Fn(&Residual) -> f64| rows.iter().map(|r| value(r)).collect::<Vec<f64>>();
    let (measured, model) = (of(&|r| r.measured), of(&|r| r.predicted));
    let [low, high] = [-2.0, 2.0].map(|side| of(&|r| r.measured + side * r.accuracy));
    let missed = of(&Residual::missed);
    let (start, end) = (*times.first()?, *times.last()?);
    if end <= start {
        return None;
    }
    let y = range(low.iter().chain(&high).chain(&model).copied())?;
    let frame = Frame::new(560.0, 230.0, [start, end], y);
    let mut out = frame.axes("time (s)", Some(if unit.is_empty() { name } else { unit }));
    out += &frame.band(times, [&low, &high]);
    out += &frame.line("line measured", times, &measured);
    out += &frame.line("line", times, &model);
    let top = frame.wrap(&format!("{name}: measurement and model"), &out);
    let y = range(missed.iter().copied().chain([-3.0, 3.0]))?;
    let frame = Frame::new(560.0, 130.0, [start, end], y);
    let mut out = frame.axes("time (s)", Some("residual"));
    out += &area("band", [frame.x.at(start), frame.x.at(end)], [frame.y.at(-2.0), frame.y.at(2.0)]);
    out += &frame.line("line", times, &missed);
    let bottom = frame.wrap(&format!("{name}: residuals in standard deviations"), &out);
    let squares: f64 = missed.iter().map(|m| m * m).sum();
    let shared = rows.iter().map(|r| r.shared).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let taken = if shared == 0.0 {
        String::new()
    } else {
        format!("; shared errors of up to {}{} are taken out of them", number(shared, 2), unit_behind(Some(unit)))
    };
    Some(Figure {
        file: format!("fit-{name}"),
        caption: name.to_owned(),
        svg: top + &bottom,
        note: format!(
            "{} rows; root mean square of the residuals {} standard deviations{taken}",
            grouped(rows.len()),
            number((squares / rows.len() as f64).sqrt(), 3)
        ),
        ..Figure::default()
    })
}
