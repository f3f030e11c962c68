//! Unsafe combinations: where a parameter alone, or two of them together, leave hardly any chance
//! of verification, whatever the others are.
//!
//! Of many candidates those are chosen that look worst, so what they were chosen by flatters none of them. They are chosen
//! by surrogates of one half of the study's points, and judged by the other half.

use super::Stand;
use super::region::{Confirmed, Sample};
use conformity::interval::clopper_pearson;
use sampling::statistics::moments::{mean, quantile, sorted};
use serde::{Deserialize, Serialize};

/// A region is a candidate where the mean probability of verification is less than this.
pub const CEILING: f64 = 0.01;
/// Slices of equal content along each parameter.
const SLICES: usize = 40;
/// Regions with a smaller part of the sampled space are not listed.
const LEAST_SHARE: f64 = 0.005;
/// The most that are listed.
const MOST_LISTED: usize = 12;

/// One bound of a region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// Index of the parameter.
    pub parameter: usize,
    /// Whether the region lies below the limit, or above it.
    pub below: bool,
    /// The limit.
    pub limit: f64,
}

impl Bound {
    fn holds(&self, x: &[f64]) -> bool {
        let value = x[self.parameter];
        if self.below { value < self.limit } else { value > self.limit }
    }
}

/// A part of the space in which hardly any point is verified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// One bound, or two of different parameters.
    pub bounds: Vec<Bound>,
    /// The part of the sampled space, without that of unsafe ranges of one parameter where there
    /// are two bounds.
    pub share: f64,
    /// The whole part of the sampled space within the bounds; results of earlier versions lack it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub whole: Option<f64>,
    /// Mean probability of verification there.
    pub probability: f64,
    /// The criterion that is met least there.
    pub lost: String,
    /// Check against the study's own points that took no part in the choice.
    pub confirmed: Confirmed,
    /// So large a part may be verified by these points: all that are listed hold together at a confidence of 95 %. Results
    /// of earlier versions lack it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
}

/// The exact upper limit of a share by independent trials, wrong with a probability of `error`.
pub(super) fn upper_limit(hits: usize, trials: usize, error: f64) -> f64 {
    match trials {
        0 => 1.0,
        _ => clopper_pearson(hits as f64, trials as f64, 1.0 - 2.0 * error)[1],
    }
}

impl Combination {
    /// Whether a point lies inside.
    pub fn contains(&self, x: &[f64]) -> bool {
        self.bounds.iter().all(|bound| bound.holds(x))
    }
}

/// The slices of all parameters: their edges, and each point's.
struct Slices {
    edges: Vec<Vec<f64>>,
    of: Vec<Vec<usize>>,
}

impl Slices {
    fn new(points: &[Vec<f64>], d: usize) -> Self {
        let edges = |k: usize| -> Vec<f64> {
            let column = sorted(points.iter().map(|x| x[k]).collect());
            let edge = |s| quantile(&column, s as f64 / SLICES as f64);
            (1..SLICES).map(edge).collect()
        };
        let edges: Vec<Vec<f64>> = (0..d).map(edges).collect();
        let of = |k: usize| {
            let slice = |x: &Vec<f64>| edges[k].partition_point(|e| *e <= x[k]);
            points.iter().map(slice).collect()
        };
        Self { of: (0..d).map(of).collect(), edges }
    }

    /// The bound of the first (or last) `count` slices.
    fn bound(&self, parameter: usize, below: bool, count: usize) -> Bound {
        let edge = if below { count } else { SLICES - count };
        Bound { parameter, below, limit: self.edges[parameter][edge - 1] }
    }

    /// A point's slice, counted from the side where a region begins.
    fn place(&self, parameter: usize, below: bool, point: usize) -> usize {
        let slice = self.of[parameter][point];
        if below { slice } else { SLICES - 1 - slice }
    }
}

/// Lists the unsafe ranges of single parameters and, outside these, the unsafe corners of pairs, the
/// largest first. `judges` are points that the surrogates do not know, each with whether it is verified.
pub(super) fn combinations(stand: &Stand, cloud: &Sample<'_>, judges: &[(&Vec<f64>, bool)]) -> Vec<Combination> {
    const ERROR: f64 = 0.05;
    let Some(d) = cloud.points.first().map(Vec::len) else {
        return vec![];
    };
    let slices = Slices::new(cloud.points, d);
    let all: Vec<usize> = (0..cloud.points.len()).collect();
    let mut listed: Vec<Combination> = (0..d)
        .flat_map(|k| [[(k, true)], [(k, false)]])
        .filter_map(|side| corner(cloud, &slices, &all, &side))
        .map(|bounds| finish(bounds, stand, cloud, &all))
        .collect();
    let open: Vec<usize> =
        all.iter().copied().filter(|&j| !listed.iter().any(|c| c.contains(&cloud.points[j]))).collect();
    for (x, y) in (0..d).flat_map(|x| (x + 1..d).map(move |y| (x, y))) {
        for (x_below, y_below) in [(true, true), (true, false), (false, true), (false, false)] {
            let sides = [(x, x_below), (y, y_below)];
            if let Some(bounds) = corner(cloud, &slices, &open, &sides) {
                listed.push(finish(bounds, stand, cloud, &open));
            }
        }
    }
    listed.retain(|c| c.share >= LEAST_SHARE);
    listed.sort_by(|a, b| b.share.total_cmp(&a.share));
    listed.truncate(MOST_LISTED);
    let error = ERROR / listed.len().max(1) as f64;
    for combination in &mut listed {
        let inside = judges.iter().filter(|(x, _)| combination.contains(x));
        let confirmed = Confirmed::count(inside.map(|(_, v)| *v));
        combination.at_most = Some(upper_limit(confirmed.verified, confirmed.points, error));
        combination.confirmed = confirmed;
    }
    listed
}

/// The unsafe corner of two parameters that holds most of the points; of one parameter the range from one of its ends.
fn corner(cloud: &Sample<'_>, slices: &Slices, open: &[usize], sides: &[(usize, bool)]) -> Option<Vec<Bound>> {
    const FEWEST: usize = 30;
    // A parameter that is not there has all points in its first slice.
    let place = |k: usize, j: usize| {
        let side = sides.get(k);
        side.map_or(0, |&(parameter, below)| slices.place(parameter, below, j))
    };
    // Numbers and sums of all corners up to a cell: summed along the rows, then along the columns.
    let mut n = vec![[0usize; SLICES]; SLICES];
    let mut sum = vec![[0.0; SLICES]; SLICES];
    for &j in open {
        let (a, b) = (place(0, j), place(1, j));
        n[a][b] += 1;
        sum[a][b] += cloud.verdicts[j];
    }
    let mut best: Option<(usize, usize, usize)> = None;
    for a in 0..SLICES - 1 {
        for b in 0..SLICES - 1 {
            if a > 0 {
                n[a][b] += n[a - 1][b];
                sum[a][b] += sum[a - 1][b];
            }
        }
        let (mut points, mut total) = (0, 0.0);
        for b in 0..SLICES - 1 {
            points += n[a][b];
            total += sum[a][b];
            let holds = points >= FEWEST && total < CEILING * points as f64;
            if holds && best.is_none_or(|(most, ..)| points > most) {
                best = Some((points, a + 1, b + 1));
            }
        }
    }
    let (_, a, b) = best?;
    let bounds = sides.iter().zip([a, b]);
    let bounds = bounds.map(|(&(parameter, below), count)| slices.bound(parameter, below, count));
    Some(bounds.collect())
}

fn finish(bounds: Vec<Bound>, stand: &Stand, cloud: &Sample<'_>, open: &[usize]) -> Combination {
    /// Points that are enough to tell which criterion is lost.
    const ENOUGH: usize = 500;
    let contains = |x: &[f64]| bounds.iter().all(|bound| bound.holds(x));
    let inside = |j: &usize| contains(&cloud.points[*j]);
    let inside: Vec<usize> = open.iter().copied().filter(inside).collect();
    let some = inside.iter().take(ENOUGH).map(|&j| &cloud.points[j]);
    let verdicts: Vec<f64> = inside.iter().map(|&j| cloud.verdicts[j]).collect();
    let n = cloud.points.len() as f64;
    let whole = cloud.points.iter().filter(|x| contains(x)).count();
    Combination {
        share: inside.len() as f64 / n,
        whole: Some(whole as f64 / n),
        probability: mean(&verdicts),
        lost: stand.least_met(some),
        confirmed: Confirmed::default(),
        at_most: None,
        bounds,
    }
}
