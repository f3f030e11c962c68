//! The document on the model's own error.

use crate::results::Summary;
use conformity::validation::Comparison;
use result_document::{
    Document, Table,
    format::{DASH, number},
    numbers, words,
};

/// The model's own error, where the study tells it.
pub fn comparison(summary: &Summary) -> Option<Document> {
    let mut told = Document::new("comparison", "Model's error", "The model's own error");
    let row = |(name, comparison): (&String, &Comparison)| {
        let unit = summary.criteria.get(name).and_then(|c| c.criterion.unit.as_ref());
        let name = unit.map_or_else(|| name.clone(), |unit| format!("{name} ({unit})"));
        std::iter::once(name).chain(compared(comparison)).collect()
    };
    let columns = [
        words("Criterion"),
        numbers("E"),
        numbers("u_{num}"),
        numbers("u_{input}"),
        numbers("u_{D}"),
        numbers("u_{val}"),
        numbers("k (degrees of freedom)"),
        numbers("E ± k u_{val}"),
        numbers("E_{n}"),
        words("Largest"),
    ];
    let table = Table::new("Validation comparison", columns, summary.validation.iter().map(row).collect());
    told.table(Table { class: "stack".into(), ..table });
    let notes: String = summary
        .validation
        .iter()
        .map(|(name, comparison)| {
            let bound = if comparison.complete {
                ""
            } else {
                "; since not all uncertainties are known, E ± k u_{val} is wider than stated"
            };
            format!(
                " {name}: the {} uncertainty dominates; numerical uncertainty {}{bound}.",
                comparison.dominant, comparison.u_num_note
            )
        })
        .collect();
    let missing = match summary.failed {
        0 => String::new(),
        failed => format!(
            " Mean and spread are those of the {} points that have a result; {failed} failed.",
            summary.points - failed
        ),
    };
    told.hint(format!(
        "After ASME V&V 20: E is the mean of the model's values minus the measured value. Where all uncertainties are known, \
         the model's own error lies in E ± k u_{{val}}; otherwise the interval is at least so wide. E_{{n}} is E over \
         the expanded uncertainty of both values (ISO 13528): above 1 they disagree. u_{{val}} joins the \
         uncertainties of the numerical solution, of the parameters (the spread of the points) and of the measured value. \
         What is called verification here, V&V 10 and V&V 20 call validation: a comparison with measurements.{notes}{missing}"
    ));
    (!summary.validation.is_empty()).then_some(told)
}

/// Effective degrees of freedom; with so many the distribution is normal.
pub fn of_freedom(freedom: f64) -> String {
    const MANY: f64 = 1000.0;
    if freedom > MANY { "over 1,000".to_owned() } else { number(freedom, 2) }
}

fn compared(comparison: &Comparison) -> [String; 9] {
    let known = |u: Option<f64>| u.map_or_else(|| "not known".to_owned(), |u| number(u, 3));
    let least = if comparison.complete { "" } else { "at least " };
    let [low, high] = comparison.model_error.map(|limit| number(limit, 3));
    [
        number(comparison.error, 3),
        known(comparison.u_num),
        number(comparison.u_input, 3),
        known(comparison.u_d),
        format!("{least}{}", number(comparison.u_val, 3)),
        match comparison.freedom {
            Some(freedom) => format!("{} ({})", number(comparison.coverage, 3), of_freedom(freedom)),
            None => number(comparison.coverage, 3),
        },
        format!("{least}{low} .. {high}"),
        comparison.e_n.map_or(DASH.into(), |e_n| number(e_n, 2)),
        comparison.dominant.clone(),
    ]
}
