use super::*;
use crate::table::{CriterionColumn, ParameterColumn};
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// Two criteria of three parameters, the third without influence.
fn model(x: &[f64]) -> [f64; 2] {
    [x[0] + 0.3 * x[1] * x[1], x[1] - 0.2 * x[0]]
}

fn sample(n: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = StdRng::seed_from_u64(seed);
    (0..n).map(|_| (0..3).map(|_| random.random_range(-2.0..2.0)).collect()).collect()
}

fn verified(x: &[f64]) -> bool {
    let [a, b] = model(x);
    a.abs() <= 1.0 && b.abs() <= 1.0
}

fn table(n: usize) -> PointTable {
    let points = sample(n, 1);
    let criterion = |k: usize| {
        let values: Vec<f64> = points.iter().map(|x| model(x)[k]).collect();
        CriterionColumn {
            name: format!("c{k}"),
            unit: String::new(),
            nominal: 0.0,
            lower: -1.0,
            upper: 1.0,
            group: None,
            ok: values.iter().map(|v| v.abs() <= 1.0).collect(),
            values,
        }
    };
    let column = |k: usize| ParameterColumn {
        name: format!("p{k}"),
        unit: String::new(),
        values: points.iter().map(|x| x[k]).collect(),
    };
    PointTable {
        ids: (1..=n as u64).collect(),
        parameters: (0..3).map(column).collect(),
        criteria: (0..2).map(criterion).collect(),
        verified: points.iter().map(|x| verified(x)).collect(),
        status: vec!["ok".into(); n],
    }
}

#[test]
fn the_stated_probability_holds_on_fresh_samples() {
    let r = robustness(&table(300), &table(300), &sample(20_000, 7), 0.9).unwrap();
    assert!(r.warnings.is_empty(), "{:?}", r.warnings);
    let region = r.region.unwrap();
    let fresh = sample(100_000, 99);
    let share = |inside: &dyn Fn(&[f64]) -> bool| {
        let held: Vec<bool> = fresh.iter().filter(|x| inside(x)).map(|x| verified(x)).collect();
        (held.iter().filter(|v| **v).count() as f64 / held.len() as f64, held.len() as f64 / fresh.len() as f64)
    };
    let (p, size) = share(&|x| region.contains(x));
    // Not much more than the level, which the lower limit of what is stated must reach.
    let held = |[low, high]: [f64; 2], p: f64| low >= 0.9 && low <= p && p <= high;
    assert!(held(region.interval, p) && p < 0.96, "{p} {region:?}");
    assert!((size - region.share).abs() < 0.03);
    // The whole verified part is a quarter of the space; a box takes most of it.
    assert!(region.share > 0.12, "{region:?}");
    assert!(region.confirmed.points > 0 && region.confirmed.verified <= region.confirmed.points);
    // The parameter without influence is not cut.
    assert!(region.limits[2][1] - region.limits[2][0] > 3.4, "{region:?}");
}

#[test]
fn margins_end_where_a_criterion_does() {
    let t = table(300);
    let r = robustness(&t, &t, &region::cloud(&rows(&t), 7), 0.9).unwrap();
    let best = &rows(&t)[t.ranking()[0].point];
    let m = &r.margins[0];
    // c0 = p0 + 0.3 p1^2 <= 1.
    assert!((m.high.0 - (1.0 - 0.3 * best[1] * best[1])).abs() < 1e-6, "{m:?}");
    assert_eq!(m.high.1.as_deref(), Some("c0"));
    assert_eq!(r.margins[2].low.1, None);
}

#[test]
fn maps_cover_all_pairs() {
    let t = table(100);
    let r = robustness(&t, &t, &sample(4_000, 7), 0.9).unwrap();
    let pairs: Vec<(usize, usize)> = r.maps.iter().map(|m| (m.x, m.y)).collect();
    assert_eq!(pairs, [(0, 1), (0, 2), (1, 2)]);
    let middle = maps::CELLS * maps::CELLS / 2 + maps::CELLS / 2;
    assert!(r.maps[0].probability[middle] > 0.99);
    assert!(r.maps[0].probability[0] < 0.01);
}

#[test]
fn a_level_that_is_reached_nowhere_is_said() {
    let mut t = table(100);
    t.criteria[0].lower = 50.0;
    t.criteria[0].upper = 51.0;
    let r = robustness(&t, &t, &sample(4_000, 7), 0.9).unwrap();
    assert!(r.region.is_none() && r.warnings.iter().any(|w| w.contains("no box")));
}
