//! The page's part on trade-offs: the front, pair by pair of criteria, and the best compromise.

use super::format::{count, number};
use super::svg::Frame;
use parameter_regions::pareto::study::{CONFLICT, Member, Pareto};
use serde::Serialize;
use std::fmt::Write as _;

/// The result's file in a folder of results.
pub const FILE: &str = "pareto.json";

/// Most pairs of criteria that are drawn; pairs in conflict come first.
const MOST_PLOTS: usize = 6;

/// Above this number, marks are drawn small and without edges.
const CROWD: usize = 300;

/// Values that the template shows.
#[derive(Serialize)]
pub struct View {
    about: String,
    nominal: Option<String>,
    conflicts: Vec<[String; 3]>,
    heads: Vec<(String, String)>,
    rows: Vec<(String, Vec<String>)>,
    plots: Vec<Plot>,
}

/// The front over two criteria.
#[derive(Serialize)]
struct Plot {
    name: String,
    svg: String,
    note: String,
}

/// Prepares a result for the template.
pub fn view(result: &Pareto) -> View {
    let Some(best) = result.front.first() else {
        return View {
            about: "No point has values.".to_owned(),
            nominal: None,
            conflicts: vec![],
            heads: vec![],
            rows: vec![],
            plots: vec![],
        };
    };
    let mut rows = vec![row("Best compromise", best)];
    if result.nearest > 0 {
        rows.push(row("Nearest", &result.front[result.nearest]));
    }
    rows.extend(
        result
            .nominal
            .iter()
            .map(|n| row("Nominal design", &n.member)),
    );
    let units = result.parameters.iter().zip(&result.units);
    let nothing = |name: &String| (name.clone(), String::new());
    View {
        about: format!(
            "From {}: of {} points {} are beaten by no other in every criterion, and {} of these meet all criteria.",
            result.method,
            count(result.points),
            count(result.unbeaten),
            count(result.unbeaten_verified)
        ),
        nominal: result.nominal.as_ref().map(|n| {
            format!(
                "The nominal design (all parameters at their medians) is beaten in every criterion by {} points of the front and lies {} of a tolerance from it.",
                count(n.beaten_by),
                number(n.to_front, 3)
            )
        }),
        conflicts: result
            .conflicts
            .iter()
            .filter(|c| c.correlation <= CONFLICT)
            .map(|c| {
                [
                    result.criteria[c.a].clone(),
                    result.criteria[c.b].clone(),
                    number(c.correlation, 2),
                ]
            })
            .collect(),
        heads: ["largest", "distance"]
            .map(|name| (name.to_owned(), String::new()))
            .into_iter()
            .chain(result.criteria.iter().map(nothing))
            .chain(units.map(|(name, unit)| (name.clone(), unit.clone())))
            .collect(),
        rows,
        plots: plots(result),
    }
}

fn row(title: &str, m: &Member) -> (String, Vec<String>) {
    let point = m.point.map_or_else(String::new, |p| format!(", point {p}"));
    let numbers = [m.largest(), m.distance()]
        .map(|v| number(v, 3))
        .into_iter()
        .chain(m.deviations.iter().map(|v| number(*v, 2)))
        .chain(m.parameters.iter().map(|v| number(*v, 4)));
    (format!("{title}{point}"), numbers.collect())
}

fn plots(result: &Pareto) -> Vec<Plot> {
    let in_order = result.conflicts.iter().map(|c| (c.a, c.b));
    let mut pairs: Vec<(usize, usize)> = in_order.collect();
    if pairs.is_empty() && result.criteria.len() > 1 {
        pairs.push((0, 1));
    }
    pairs.truncate(MOST_PLOTS);
    pairs.into_iter().map(|(a, b)| plot(result, a, b)).collect()
}

/// The plots that are written as files: name and picture.
pub fn files(result: &Pareto) -> Vec<(String, String)> {
    let named = |p: Plot| (p.name, p.svg);
    plots(result).into_iter().map(named).collect()
}

/// End of an axis: it covers the tolerance and all of the front but its outermost twentieth.
fn end(result: &Pareto, k: usize) -> f64 {
    let mut values: Vec<f64> = result.front.iter().map(|m| m.deviations[k]).collect();
    values.sort_by(f64::total_cmp);
    let most = values.get(values.len() * 19 / 20).copied().unwrap_or(1.0);
    (1.08 * most).clamp(1.2, 4.0)
}

fn plot(result: &Pareto, a: usize, b: usize) -> Plot {
    let (right, top) = (end(result, a), end(result, b));
    let frame = Frame::new(420.0, 320.0, [0.0, right], [0.0, top]);
    let name = |k: usize| format!("{}, deviation / tolerance", result.criteria[k]);
    let mut out = frame.axes(&name(a), Some(&name(b)));
    let _ = write!(
        out,
        "<path class=\"accept\" d=\"M{:.1},{:.1}H{:.1}V{:.1}H{:.1}z\"/>",
        frame.x.from,
        frame.y.at(1.0),
        frame.x.at(1.0),
        frame.y.from,
        frame.x.from
    );
    let place = |m: &Member| {
        let (x, y) = (m.deviations[a], m.deviations[b]);
        (x <= right && y <= top).then(|| (frame.x.at(x), frame.y.at(y)))
    };
    let (mut verified, mut others) = (String::new(), String::new());
    // In a crowd edges would hide each other.
    let (r, class) = if result.front.len() > CROWD {
        (1.5, "plot crowd")
    } else {
        (3.0, "plot")
    };
    for m in &result.front {
        if let Some((x, y)) = place(m) {
            let path = if m.verified() {
                &mut verified
            } else {
                &mut others
            };
            let d = 2.0 * r;
            let _ = write!(
                path,
                "M{:.1},{y:.1}a{r},{r} 0 1,0 {d},0a{r},{r} 0 1,0 -{d},0",
                x - r
            );
        }
    }
    let _ = write!(
        out,
        "<g class=\"{class}\"><path class=\"pt part\" d=\"{others}\"/><path class=\"pt in\" d=\"{verified}\"/></g>"
    );
    if let Some((x, y)) = result.front.first().and_then(place) {
        let _ = write!(
            out,
            "<path class=\"chosen\" d=\"M{:.1},{y:.1}a6,6 0 1,0 12,0a6,6 0 1,0 -12,0\"/>",
            x - 6.0
        );
    }
    if let Some((x, y)) = result.nominal.as_ref().and_then(|n| place(&n.member)) {
        let _ = write!(
            out,
            "<path class=\"design\" d=\"M{x:.1},{:.1}l6,6l-6,6l-6,-6z\"/>",
            y - 6.0
        );
    }
    let outside = result.front.iter().filter(|m| place(m).is_none()).count();
    let mut note = String::new();
    if result.front.len() < result.unbeaten {
        let shown = count(result.front.len());
        note += &format!("{shown} points of the front are shown. ");
    }
    if outside > 0 {
        note += &format!("{outside} points of the front lie outside the plot.");
    }
    let title = format!(
        "Deviations of {} and {} over the {} points of the front",
        result.criteria[a],
        result.criteria[b],
        result.front.len()
    );
    Plot {
        name: format!("pareto-{}-{}", result.criteria[a], result.criteria[b]),
        svg: frame.wrap(&title, &out),
        note,
    }
}
