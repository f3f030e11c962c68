//! The page's part on robustness: maps over pairs, the box, the margins.

use super::format::{escape, number, percent, with_unit};
use super::svg::ticks;
use parameter_regions::robustness::Robustness;
use parameter_regions::robustness::combinations::{Bound, Combination};
use parameter_regions::robustness::maps::{CELLS, Map};
use parameter_regions::robustness::margins::Margin;
use parameter_regions::robustness::region::Confirmed;
use serde::Serialize;
use std::fmt::Write as _;

/// The result's file in a folder of results.
pub const FILE: &str = "robustness.json";

/// Values that the template shows.
#[derive(Serialize)]
pub struct View {
    quality: Vec<[String; 4]>,
    further_runs: usize,
    rows: Vec<[String; 6]>,
    region: Option<String>,
    ellipsoid: Option<String>,
    unsafe_combinations: Vec<[String; 6]>,
    groups: Vec<Group>,
    warnings: Vec<String>,
}

/// The maps of one output.
#[derive(Serialize)]
struct Group {
    name: String,
    low: String,
    high: String,
    maps: Vec<String>,
}

/// Prepares a result for the template.
pub fn view(result: &Robustness) -> View {
    let quality = |(name, q): &(String, parameter_regions::robustness::surrogate::Quality)| {
        [
            name.clone(),
            format!("{} terms up to degree {}", q.terms, q.degree),
            number(q.error, 2),
            percent(q.predicted.max(0.0)),
        ]
    };
    let told = |share: f64, probability: f64, [low, high]: [f64; 2], own: Confirmed| {
        let claim = if low >= result.level {
            "shown to be"
        } else {
            "not shown to be"
        };
        format!(
            "{} % of the sampled space. Of it {} % are verified (95 % interval {} – {} %), {claim} {} % or more by the surrogates and the study's own points, of which {} lie inside, {} of them verified.",
            percent(share),
            percent(probability),
            percent(low),
            percent(high),
            percent(result.level),
            own.points,
            own.verified
        )
    };
    let judged = |stated: [f64; 2], fresh: Option<Confirmed>| {
        fresh.map_or_else(String::new, |f| {
            format!(
                " Of {} fresh runs inside {} are verified (95 % interval {} – {} %): {}.",
                f.points,
                f.verified,
                percent(f.interval[0]),
                percent(f.interval[1]),
                f.on(stated)
            )
        })
    };
    let combination = |c: &Combination| {
        [
            bounds(result, c),
            c.whole.map_or_else(|| "–".to_owned(), percent),
            percent(c.share),
            percent(c.probability),
            c.lost.clone(),
            format!("{} of {}", c.confirmed.verified, c.confirmed.points),
        ]
    };
    View {
        quality: result.criteria.iter().map(quality).collect(),
        further_runs: result.further_runs,
        rows: table(result),
        region: result.region.as_ref().map(|r| {
            told(r.share, r.probability, r.interval, r.confirmed) + &judged(r.interval, r.fresh)
        }),
        ellipsoid: result.ellipsoid.as_ref().map(|e| {
            told(e.share, e.probability, e.interval, e.confirmed) + &judged(e.interval, e.fresh)
        }),
        unsafe_combinations: result.unsafe_combinations.iter().map(combination).collect(),
        groups: groups(result),
        warnings: result.warnings.clone(),
    }
}

/// A region in words.
pub fn bounds(result: &Robustness, c: &Combination) -> String {
    let bound = |b: &Bound| {
        let side = if b.below { "below" } else { "above" };
        let unit = &result.units[b.parameter];
        let limit = number(b.limit, 4);
        let words = format!("{} {side} {limit} {unit}", result.parameters[b.parameter]);
        words.trim_end().to_owned()
    };
    c.bounds
        .iter()
        .map(bound)
        .collect::<Vec<_>>()
        .join(" with ")
}

/// Parameter, margins below and above with the criterion that is lost, box.
fn table(result: &Robustness) -> Vec<[String; 6]> {
    let end = |(value, lost): &(f64, Option<String>)| match lost {
        Some(name) => format!("{} ({name})", number(*value, 5)),
        None => format!("{} (end of samples)", number(*value, 5)),
    };
    let limits = |k: usize, side: usize| {
        result
            .region
            .as_ref()
            .map_or_else(|| "–".into(), |r| number(r.limits[k][side], 5))
    };
    let row = |(k, name): (usize, &String)| {
        let own = result.margins.iter().find(|m| m.parameter == *name);
        let told = |of: &dyn Fn(&Margin) -> String| own.map_or_else(|| "–".into(), of);
        [
            with_unit(name, &result.units[k]),
            told(&|m| end(&m.low)),
            told(&|m| number(m.value, 5)),
            told(&|m| end(&m.high)),
            limits(k, 0),
            limits(k, 1),
        ]
    };
    result.parameters.iter().enumerate().map(row).collect()
}

/// The plots that are written as files: name and picture.
pub fn plots(result: &Robustness) -> Vec<(String, String)> {
    let name = |k: usize| &result.parameters[k];
    let mut plots = Vec::new();
    for group in groups(result) {
        for (map, svg) in result.maps.iter().zip(group.maps) {
            let file = format!("map-{}-{}-{}", group.name, name(map.x), name(map.y));
            plots.push((file, svg));
        }
    }
    plots
}

fn groups(result: &Robustness) -> Vec<Group> {
    let probability = Group {
        name: "Probability of verification".into(),
        low: "0".into(),
        high: "1".into(),
        maps: result
            .maps
            .iter()
            .map(|m| {
                picture(
                    result,
                    m,
                    "probability of verification",
                    &m.probability,
                    [0.0, 1.0],
                )
            })
            .collect(),
    };
    if result.maps.is_empty() {
        return Vec::new();
    }
    let criterion = |(c, (name, _)): (usize, &(String, _))| {
        let values = || result.maps.iter().flat_map(|m| &m.criteria[c]).copied();
        let range = values().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| {
            [l.min(v), h.max(v)]
        });
        Group {
            name: name.clone(),
            low: number(range[0], 4),
            high: number(range[1], 4),
            maps: result
                .maps
                .iter()
                .map(|m| picture(result, m, name, &m.criteria[c], range))
                .collect(),
        }
    };
    let criteria: Vec<Group> = result.criteria.iter().enumerate().map(criterion).collect();
    std::iter::once(probability).chain(criteria).collect()
}

/// One map in nine shades.
fn picture(result: &Robustness, map: &Map, what: &str, values: &[f64], range: [f64; 2]) -> String {
    const SHADES: usize = 9;
    const LEFT: f64 = 56.0;
    const SIDE: f64 = 180.0;
    let cell = SIDE / CELLS as f64;
    let span = (range[1] - range[0]).max(f64::MIN_POSITIVE);
    let mut paths = vec![String::new(); SHADES];
    for (k, v) in values.iter().enumerate() {
        let shade = (((v - range[0]) / span * SHADES as f64) as usize).min(SHADES - 1);
        let (x, y) = (
            LEFT + (k % CELLS) as f64 * cell,
            6.0 + SIDE - (k / CELLS + 1) as f64 * cell,
        );
        // Neighbouring cells overlap slightly: some renderers would show seams between them.
        let _ = write!(
            paths[shade],
            "M{x:.0},{y:.0}h{0:.1}v{0:.1}h-{0:.1}z",
            cell + 0.3
        );
    }
    let mut out: String = paths
        .iter()
        .enumerate()
        .filter(|(_, d)| !d.is_empty())
        .map(|(s, d)| format!("<path class=\"shade s{s}\" d=\"{d}\"/>"))
        .collect();
    for t in ticks(map.x_range[0], map.x_range[1], 3) {
        let x = LEFT + (t - map.x_range[0]) / (map.x_range[1] - map.x_range[0]) * SIDE;
        let _ = write!(
            out,
            "<text class=\"tick\" x=\"{x:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>",
            SIDE + 21.0,
            number(t, 4)
        );
    }
    for t in ticks(map.y_range[0], map.y_range[1], 4) {
        let y = 6.0 + SIDE - (t - map.y_range[0]) / (map.y_range[1] - map.y_range[0]) * SIDE;
        let _ = write!(
            out,
            "<text class=\"tick\" x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 4.0,
            y + 4.0,
            number(t, 4)
        );
    }
    let name = |k: usize| with_unit(&result.parameters[k], &result.units[k]);
    let _ = write!(
        out,
        "<text class=\"title\" x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text><text class=\"title\" transform=\"translate(11,{:.0}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        LEFT + SIDE / 2.0,
        SIDE + 38.0,
        escape(&name(map.x)),
        6.0 + SIDE / 2.0,
        escape(&name(map.y))
    );
    let [low, high] = values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| {
            [l.min(*v), h.max(*v)]
        });
    let _ = write!(
        out,
        "<text class=\"tick\" x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{} … {}</text>",
        LEFT + SIDE / 2.0,
        SIDE + 53.0,
        number(low, 4),
        number(high, 4)
    );
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot map\" viewBox=\"0 0 246 {:.0}\" role=\"img\" aria-label=\"{}\">{out}</svg>",
        SIDE + 58.0,
        escape(&format!(
            "{what} over {} and {}: {} to {}",
            name(map.x),
            name(map.y),
            number(low, 4),
            number(high, 4)
        ))
    )
}
