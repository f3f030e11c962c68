//! The document of trade-offs: the best compromise, and the front, pair by pair of criteria.

use conformity::conclusion::grouped;
use parameter_regions::pareto::study::{Member, Pareto};
use result_document::{
    Column, Document, Figure, Key, Table,
    format::number,
    numbers,
    svg::{Frame, area, circle, path},
    words,
};
use sampling::statistics::moments::sorted;

/// Most pairs of criteria that are drawn.
const MOST_PLOTS: usize = 6;

/// Above this number, marks are drawn small and without edges.
const CROWD: usize = 300;

/// The document of a result.
pub fn document(result: &Pareto) -> Document {
    let mut told = Document::new("pareto", "Trade-offs", "What the criteria cost each other");
    let Some(best) = result.front.first() else {
        told.say("No point has values.");
        return told;
    };
    told.say(format!(
        "For {} of the study's {} points no other one is as near in every criterion and nearer in one; {} of these meet all criteria.",
        grouped(result.unbeaten),
        grouped(result.points),
        grouped(result.unbeaten_verified)
    ));
    told.table(members(result, best));
    told.hint(
        "Criteria: the value and, in brackets, its deviation in units of the tolerance. The best compromise has the least \
         largest deviation: every criterion keeps as much room as the worst of them can have.",
    );
    told.legend(legend());
    told.show("thirds", plots(result));
    told
}

/// The points that are worth a look.
fn members(result: &Pareto, best: &Member) -> Table {
    let mut rows = vec![row("Best compromise", best)];
    if result.nearest > 0 {
        rows.push(row("Nearest", &result.front[result.nearest]));
    }
    let parameters =
        result.parameters.iter().zip(&result.units).map(|(name, unit)| Column { unit: unit.clone(), ..numbers(name) });
    let columns = [words(""), numbers("largest"), numbers("distance")].into_iter();
    Table {
        name: "Best compromise".into(),
        class: "best".into(),
        columns: columns.chain(result.criteria.iter().map(numbers)).chain(parameters).collect(),
        rows,
    }
}

fn row(title: &str, m: &Member) -> Vec<String> {
    let criterion = |(value, deviation): (&f64, &f64)| format!("{} ({})", number(*value, 5), number(*deviation, 2));
    let title = [format!("{title}, point {}", m.point), number(m.largest(), 3), number(m.distance(), 3)];
    let criteria = m.values.iter().zip(&m.deviations).map(criterion);
    title.into_iter().chain(criteria).chain(m.parameters.iter().map(|v| number(*v, 4))).collect()
}

fn legend() -> [Key; 3] {
    let at = |r| circle([7.0, 7.0], r);
    [
        Key::new("pt in", &at(3.0), "meets all criteria"),
        Key::new("pt part", &at(3.0), "fails one or more"),
        Key::new("chosen", &at(5.5), "best compromise"),
    ]
}

fn plots(result: &Pareto) -> Vec<Figure> {
    let pairs = (0..result.criteria.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    pairs.take(MOST_PLOTS).map(|(a, b)| plot(result, a, b)).collect()
}

/// End of an axis: it covers the tolerance and all of the front but its outermost twentieth.
fn end(result: &Pareto, k: usize) -> f64 {
    let values = sorted(result.front.iter().map(|m| m.deviations[k]).collect());
    let most = values.get(values.len() * 19 / 20).copied().unwrap_or(1.0);
    (1.08 * most).clamp(1.2, 4.0)
}

fn plot(result: &Pareto, a: usize, b: usize) -> Figure {
    let (right, top) = (end(result, a), end(result, b));
    let frame = Frame::new(420.0, 320.0, [0.0, right], [0.0, top]);
    let name = |k: usize| format!("{}, deviation / tolerance", result.criteria[k]);
    let mut out = frame.axes(&name(a), Some(&name(b)));
    let tolerance = [frame.y.at(1.0), frame.y.from];
    out += &area("accept", [frame.x.from, frame.x.at(1.0)], tolerance);
    let place = |m: &Member| {
        let (x, y) = (m.deviations[a], m.deviations[b]);
        (x <= right && y <= top).then(|| [frame.x.at(x), frame.y.at(y)])
    };
    // In a crowd edges would hide each other.
    let (r, class) = if result.front.len() > CROWD { (1.5, "plot crowd") } else { (3.0, "plot") };
    let marks = |verified: bool| -> String {
        result.front.iter().filter(|m| m.verified() == verified).filter_map(place).map(|at| circle(at, r)).collect()
    };
    let (others, verified) = (path("pt part", marks(false)), path("pt in", marks(true)));
    out += &format!("<g class=\"{class}\">{others}{verified}</g>");
    if let Some(at) = result.front.first().and_then(place) {
        out += &path("chosen", circle(at, 6.0));
    }
    let outside = result.front.iter().filter(|m| place(m).is_none()).count();
    let mut note = String::new();
    if result.front.len() < result.unbeaten {
        let shown = grouped(result.front.len());
        note += &format!("{shown} points of the front are shown. ");
    }
    if outside > 0 {
        note += &format!("{outside} points of the front lie outside the plot.");
    }
    let [one, other] = [a, b].map(|k| &result.criteria[k]);
    let title = format!("Deviations of {one} and {other} over the {} points of the front", result.front.len());
    Figure { file: format!("pareto-{one}-{other}"), svg: frame.wrap(&title, &out), note, ..Figure::default() }
}
