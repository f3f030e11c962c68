//! The largest box: what part of it is verified, by fresh samples, against what is stated.

use parameter_regions::robustness::region::Confirmed;
use parameter_regions::robustness::robustness;
use parameter_regions::table::{CriterionColumn, ParameterColumn, PointTable};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use sampling::design::cube;
use sampling::statistics::moments::{quantile, sorted};
use sampling::statistics::share::Fraction;

use crate::percent;

/// A criterion: its value at a point, the measured value and the tolerance.
type Look = (fn(&[f64]) -> f64, f64, f64);

/// The criteria of a study.
struct Case {
    name: &'static str,
    dimensions: usize,
    criteria: Vec<Look>,
}

const LEVEL: f64 = 0.9;

/// Fresh runs of `--confirm`.
const CONFIRM: usize = 400;

fn cases() -> Vec<Case> {
    let case = |name, dimensions, criteria| Case { name, dimensions, criteria };
    let root = |u: &[f64]| (u[0] - 0.5).hypot(u[1] - 0.5);
    vec![
        case("corner of 9 %", 2, vec![(|u| u[0], 0.85, 0.15), (|u| u[1], 0.85, 0.15)]),
        case("curved band", 2, vec![(|u| (8.0 * u[0]).sin() + u[1], 0.5, 0.4)]),
        case("disc", 2, vec![(root, 0.0, 0.3)]),
        case("kink", 2, vec![(|u| (u[0] - 0.5).abs() + u[1].min(0.6), 0.5, 0.3)]),
        case("jump", 2, vec![(|u| u[0] + f64::from(u8::from(u[1] > 0.63)), 0.3, 0.4)]),
        case("sums of 5", 5, vec![(|u| u.iter().sum(), 2.5, 0.5), (|u| u[0] - u[1] + 0.5 * u[2], 0.25, 0.4)]),
        case(
            "products of 7",
            7,
            vec![
                (|u| u[0] * (1.0 + u[1]) / (1.0 + u[2]), 0.5, 0.3),
                (|u| (u[3] - u[4]).exp() + 0.3 * u[5] * u[6], 1.1, 0.5),
            ],
        ),
    ]
}

impl Case {
    fn is_verified(&self, u: &[f64]) -> bool {
        let mut criteria = self.criteria.iter();
        criteria.all(|(f, nominal, tolerance)| (f(u) - nominal).abs() <= *tolerance)
    }

    /// The points of a study.
    fn table(&self, points: &[Vec<f64>]) -> PointTable {
        let criteria = self.criteria.iter().enumerate();
        let criterion = |(k, &(f, nominal, tolerance)): (usize, &Look)| {
            let values: Vec<f64> = points.iter().map(|u| f(u)).collect();
            CriterionColumn {
                name: format!("c{k}"),
                unit: String::new(),
                nominal,
                lower: nominal - tolerance,
                upper: nominal + tolerance,
                group: None,
                ok: values.iter().map(|v| (v - nominal).abs() <= tolerance).collect(),
                values,
            }
        };
        let column = |k: usize| ParameterColumn {
            name: format!("p{k}"),
            unit: String::new(),
            values: points.iter().map(|u| u[k]).collect(),
        };
        PointTable {
            ids: (1..=points.len() as u64).collect(),
            parameters: (0..self.dimensions).map(column).collect(),
            criteria: criteria.map(criterion).collect(),
            verified: points.iter().map(|u| self.is_verified(u)).collect(),
            status: vec!["ok".into(); points.len()],
        }
    }
}

/// A box: what it states, what part of it is verified in truth, and whether the interval of fresh runs holds that.
#[derive(Clone, Copy)]
struct Judged {
    /// The part of the space that it takes.
    share: f64,
    stated: f64,
    interval: [f64; 2],
    truth: f64,
    holds: bool,
}

fn uniform(dimensions: usize, random: &mut StdRng) -> Vec<f64> {
    (0..dimensions).map(|_| random.random()).collect()
}

fn judged(
    case: &Case,
    contains: impl Fn(&[f64]) -> bool,
    (stated, interval): (f64, [f64; 2]),
    seed: u64,
) -> Option<Judged> {
    const MANY: usize = 100_000;
    let mut random = StdRng::seed_from_u64(7_000_000 + seed);
    let mut inside = |draws: usize, wanted: usize| -> Vec<bool> {
        let points = (0..draws).map(|_| uniform(case.dimensions, &mut random));
        let inside = points.filter(|u| contains(u));
        inside.take(wanted).map(|u| case.is_verified(&u)).collect()
    };
    let part = |held: &[bool]| held.iter().filter(|v| **v).count();
    let all = inside(MANY, MANY);
    let truth = part(&all) as f64 / all.len() as f64;
    let drawn = inside(usize::MAX, CONFIRM);
    let share = Fraction::wilson(part(&drawn), CONFIRM);
    let confirmed = Confirmed { points: CONFIRM, verified: part(&drawn), interval: [share.low, share.high] };
    Some(Judged { share: all.len() as f64 / MANY as f64, stated, interval, truth, holds: confirmed.agrees([truth; 2]) })
}

fn one(case: &Case, points: u64, seed: u64) -> Option<Judged> {
    let study = cube(case.dimensions, points, 100 + seed, 1).ok()?;
    let mut random = StdRng::seed_from_u64(5_000_000 + seed);
    let cloud = (0..40_000).map(|_| uniform(case.dimensions, &mut random));
    let cloud: Vec<Vec<f64>> = cloud.collect();
    let table = case.table(&study);
    let found = robustness(&table, &table, &cloud, LEVEL)?;
    let region = found.region?;
    judged(case, |u| region.contains(u), (region.probability, region.interval), seed)
}

pub fn print(repetitions: u64) -> Result<(), String> {
    println!(
        "\nBox of {} % or more, {repetitions} studies each: found, and their median part of the space; mean of",
        percent(LEVEL)
    );
    println!(
        "stated less true part; % of the 95 % intervals that hold the true part, and of their lower limits; of how many the"
    );
    println!(
        "lower limit is no less than the level, and the least true part of these and of all; intervals of {CONFIRM} fresh runs"
    );
    for case in cases() {
        for points in [128, 512] {
            let found: Vec<Judged> =
                (0..repetitions).into_par_iter().filter_map(|seed| one(&case, points, seed)).collect();
            told(&format!("{:<14} {points:>4} points", case.name), &found);
        }
    }
    Ok(())
}

fn told(of: &str, found: &[Judged]) {
    if found.is_empty() {
        return println!("  {of}: none found");
    }
    let n = found.len() as f64;
    let part = |of: &dyn Fn(&Judged) -> bool| percent(found.iter().filter(|own| of(own)).count() as f64 / n);
    let shown = |own: &&Judged| own.interval[0] >= LEVEL;
    let least = |of: &mut dyn Iterator<Item = &Judged>| of.map(|own| own.truth).fold(1.0, f64::min);
    let excess = found.iter().map(|own| own.stated - own.truth).sum::<f64>() / n;
    println!(
        "  {of}: {n:>2} found, {:>4.1} %; {:+.2}; {:>5.1}, {:>5.1}; {:>2}, {:.1}, {:.1}; {:>5.1}",
        percent(quantile(&sorted(found.iter().map(|own| own.share).collect()), 0.5)),
        percent(excess),
        part(&|own| own.interval[0] <= own.truth && own.truth <= own.interval[1]),
        part(&|own| own.interval[0] <= own.truth),
        found.iter().filter(shown).count(),
        percent(least(&mut found.iter().filter(shown))),
        percent(least(&mut found.iter())),
        part(&|own| own.holds),
    );
}
