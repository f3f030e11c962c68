//! Shares too small to be counted: runs chosen at the edge of the event (Echard, Gayton & Lemaire 2011, "AK-MCS: an active learning
//! reliability method", Structural Safety 33), with a population that a surrogate draws where the event may be.
//!
//! Points are independent standard normal scores, one for each parameter.
//!
//! 1. The first runs fill directions and radii out to where one point in a million lies, so that an edge far out is seen.
//! 2. A surrogate of the runs leads points by levels to where the event may be (subset simulation, Au & Beck 2001). Points around
//!    these, weighted by what they stand for (importance sampling), give the share for each function that the model may be.
//! 3. A batch has points whose side of the edge is least known, and plain points of the event, which show that it is there. What
//!    the surrogate said of each before it was run is held against what came out.

use std::f64::consts::PI;

use crate::campaign::undecided;
use crate::doubt::{REFUTED, surprise};
use crate::limit::{Event, Limit};
use crate::possible::Possible;
use crate::share::{Basis, Share};
use crate::surrogate::{Run, Surrogate};
use nalgebra::DMatrix;
use sampling::design::cube;
use sampling::distribution::Distribution;
use sampling::random::{Purpose, Random};
use sampling::statistics::moments::{length, mean, sorted};

/// Runs before any is chosen.
const START: usize = 20;
/// The least of a batch; later ones are a twelfth of the runs that are there.
const BATCH: usize = 5;
/// The first runs reach as many deviations as one normal number in a million.
const REACH: f64 = 4.75;
/// Points that are led to the event, and the part of them that a level keeps.
const WALKERS: usize = 800;
const KEPT: f64 = 0.2;
/// Levels at most: 0.2^12 is below one in 10^8.
const LEVELS: usize = 12;
/// Steps of a point on each level.
const STEPS: usize = 4;
/// A point may belong to the event when it does so many deviations off.
const OPTIMISM: f64 = 1.0;
/// The widths of the draws around such a point, across and along its radius (the latter is divided by the radius).
const WIDTHS: [f64; 2] = [0.9, 1.0];
/// The part of the draws that are plain.
const PLAIN: f64 = 0.2;
/// Points and functions of each member: for a batch, and for the answer.
const OF_BATCH: [usize; 2] = [1500, 4];
const OF_ANSWER: [usize; 2] = [32_000, 8];
/// The search ends when two answers in turn are known so well (relative deviation), and so many runs are of the event.
const ENOUGH: f64 = 0.01;
const ENOUGH_INSIDE: usize = 8;
/// The surrogate is never surer of a side than that.
const SUREST: f64 = 0.03;
/// A run that is off by so many of its deviations is beyond a jump: of normal errors, one in 150,000 is.
const JUMP: f64 = 4.5;
/// A share whose relative deviation is larger is not told: such an interval is no answer. Where runs fail less is left open, because
/// where failures cut the event the surrogate was off by many of its deviations.
const MOST_OPEN: f64 = 0.25;
const MOST_OPEN_AT_FAILURES: f64 = 0.1;
/// Runs of the event without which nothing is said.
const LEAST_INSIDE: usize = 3;

/// Runs points, given by their scores, and tells what came out, in the same order; `None`: the run failed.
pub type Ask<'a, E> = &'a mut dyn FnMut(&[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>, E>;

/// A share that is looked for.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    /// The event.
    pub event: Event,
    /// The limits that a run keeps or misses.
    pub limits: &'a [Limit],
    /// Parameters that vary.
    pub dimensions: usize,
    /// A point as the surrogate sees it, by its scores.
    pub coordinates: &'a dyn Fn(&[f64]) -> Vec<f64>,
    /// Runs at most.
    pub runs: usize,
    /// The seed.
    pub seed: u64,
}

/// What the runs say.
#[derive(Clone, Debug)]
pub struct RareAnswer {
    /// The share, or why the runs do not tell it.
    pub share: Result<Share, Unknown>,
    /// The runs' scores.
    pub scores: Vec<Vec<f64>>,
    /// Runs that are of the event, by number.
    pub inside: Vec<usize>,
}

/// Why runs do not tell a share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unknown {
    /// No surrogate fits.
    Unfit,
    /// Hardly any run is of the event.
    Outside,
    /// The runs contradict what the surrogate said of them.
    Contradicted {
        /// By so many deviations.
        deviations: f64,
    },
    /// The surrogate leaves it open.
    Open {
        /// Its deviation over the share.
        relative: f64,
    },
}

/// Weighted points, and the event's function at them: a row a point, a column a function, below 0 where it happens.
struct Population {
    scores: Vec<Vec<f64>>,
    weights: Vec<f64>,
    values: DMatrix<f64>,
}

impl Population {
    /// The part of the functions by which each point is of the event.
    fn probabilities(&self) -> Vec<f64> {
        let one = |i: usize| self.values.row(i).iter().filter(|v| **v < 0.0).count() as f64;
        (0..self.scores.len()).map(|i| one(i) / self.values.ncols() as f64).collect()
    }

    /// The share in the mean over the functions, known as well as these and the points let it; and the relative deviation of what
    /// the functions alone leave open, which counts `widening` times. A few functions that are far off (their tails are heavy) count
    /// by their number alone.
    fn share(&self, widening: f64) -> (Share, f64) {
        let points = self.scores.len() as f64;
        let of = |k: usize| {
            let column = self.values.column(k);
            column.iter().zip(&self.weights).filter(|(v, _)| **v < 0.0).map(|(_, w)| w).sum::<f64>() / points
        };
        let shares = sorted((0..self.values.ncols()).map(of).collect());
        let cut = shares.len() / 20;
        let inner = &shares[cut..shares.len() - cut];
        let estimate = mean(inner).min(1.0);
        // Both are 1.645 deviations off where the shares are normal.
        let open = widening * (inner[inner.len() - 1] - estimate).max(estimate - inner[0]) / 1.645;
        let parts = self.probabilities();
        let squares = parts.iter().zip(&self.weights).map(|(p, w)| (p * w - estimate).powi(2)).sum::<f64>();
        let variance = open * open + squares / points / points;
        let trials = if variance > 0.0 { estimate * (1.0 - estimate) / variance } else { 0.0 };
        (Share { estimate, trials, basis: Basis::Surrogate }, open / estimate)
    }
}

impl Search<'_> {
    /// Runs points in batches and says what they tell.
    ///
    /// # Errors
    /// Those of `ask`.
    pub fn answer<E>(&self, ask: Ask<'_, E>) -> Result<RareAnswer, E> {
        let like: Vec<Vec<f64>> = self.plain(512, 1).iter().map(|z| (self.coordinates)(z)).collect();
        let start = START.max(3 * self.dimensions + 6);
        let filling = self.filling(self.runs, start);
        let (mut runs, mut places): (Vec<Run>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
        let mut earlier: Option<Surrogate> = None;
        // What the surrogate said of a run before, and what came out.
        let mut foretold: Vec<[f64; 2]> = Vec::new();
        let (mut enough, mut filled) = (0, 0);
        loop {
            let done = runs.len();
            let fitted = Surrogate::fit(&runs, &like, earlier.as_ref(), self.seed).ok();
            // Where no run fails, nothing is known of those that do.
            let surrogate = fitted.filter(|s| self.event != Event::Failed || s.success.is_some());
            let inside: Vec<usize> = (0..done).filter(|&i| self.event.is(self.limits, &runs[i])).collect();
            if done >= self.runs || enough == 2 {
                let told = self.told(surrogate.as_ref(), inside.len(), &foretold, &runs);
                // The last runs may have shown something new.
                let settled = told.as_ref().is_ok_and(|(_, open)| *open < 2.0 * ENOUGH);
                if done >= self.runs || settled {
                    return Ok(RareAnswer { share: told.map(|(share, _)| share), scores: places, inside });
                }
                enough = 0;
            }
            let size = if done == 0 { start } else { BATCH.max(done / 12) }.min(self.runs - done);
            let mut batch: Vec<(Vec<f64>, Option<f64>)> = Vec::new();
            if let Some(surrogate) = &surrogate {
                let mut random = Random::new(self.seed, Purpose::Search, 1 + done as u32);
                let population = self.population(surrogate, OF_BATCH, &mut random);
                let (_, open) = population.share(1.0);
                enough = if inside.len() >= ENOUGH_INSIDE && open < ENOUGH { enough + 1 } else { 0 };
                batch = self.chosen(&population, size, &mut random);
            }
            earlier = surrogate;
            let missing = size - batch.len();
            batch.extend(filling[filled..filled + missing].iter().map(|scores| (scores.clone(), None)));
            filled += missing;
            let scores: Vec<Vec<f64>> = batch.iter().map(|(scores, _)| scores.clone()).collect();
            for ((scores, said), values) in batch.into_iter().zip(ask(&scores)?) {
                let run = Run { point: (self.coordinates)(&scores), values };
                let is = f64::from(self.event.is(self.limits, &run));
                foretold.extend(said.map(|said| [said, is]));
                runs.push(run);
                places.push(scores);
            }
        }
    }

    /// The share and what the functions alone leave open of it, unless hardly any run is `inside` or the runs contradict what was said of them.
    fn told(
        &self,
        surrogate: Option<&Surrogate>,
        inside: usize,
        foretold: &[[f64; 2]],
        runs: &[Run],
    ) -> Result<(Share, f64), Unknown> {
        let surrogate = surrogate.ok_or(Unknown::Unfit)?;
        if inside < LEAST_INSIDE {
            return Err(Unknown::Outside);
        }
        let [scattered, one_sided] = surprise(foretold.iter().copied(), SUREST);
        let deviations = scattered.max(one_sided);
        if deviations > REFUTED {
            return Err(Unknown::Contradicted { deviations });
        }
        let [largest, widening] = self.unevenness(surrogate, runs);
        if largest > JUMP {
            return Err(Unknown::Contradicted { deviations: largest });
        }
        let most = if surrogate.success.is_some() { MOST_OPEN_AT_FAILURES } else { MOST_OPEN };
        let mut random = Random::new(self.seed, Purpose::Search, 0);
        match self.population(surrogate, OF_ANSWER, &mut random).share(widening) {
            (_, relative) if relative > most => Err(Unknown::Open { relative }),
            told => Ok(told),
        }
    }

    /// How unevenly the errors by leaving one run out are spread: the largest in its own deviations, and by how much more than its
    /// functions say the surrogate is off. Those spread errors over all places; at a jump a few runs have them all, and the kurtosis,
    /// three where errors are normal, tells how few.
    fn unevenness(&self, surrogate: &Surrogate, runs: &[Run]) -> [f64; 2] {
        let of_limit = |limit: &Limit| {
            let values = runs.iter().filter_map(Run::finite).map(|values| values[limit.output]);
            let errors = values.zip(surrogate.left_out(limit.output));
            let squares: Vec<f64> = errors.map(|(value, [mean, off])| ((value - mean) / off).powi(2)).collect();
            let mean = mean(&squares);
            let fourth = squares.iter().map(|square| square * square).sum::<f64>() / squares.len() as f64;
            [squares.iter().copied().fold(0.0, f64::max), fourth / mean / mean / 3.0].map(f64::sqrt)
        };
        self.limits
            .iter()
            .map(of_limit)
            .fold([0.0, 1.0], |[a, b], [largest, widening]| [a.max(largest), b.max(widening)])
    }

    /// Plain points.
    fn plain(&self, count: usize, stream: u64) -> Vec<Vec<f64>> {
        units(self.dimensions, count, self.seed.wrapping_add(stream)).iter().map(|u| normals(u)).collect()
    }

    /// Points that fill directions and, each `cycle` of them, radii.
    fn filling(&self, count: usize, cycle: usize) -> Vec<Vec<f64>> {
        let d = self.dimensions as f64;
        // Wilson & Hilferty's approximation of a chi-squared number.
        let reach = (d * (1.0 - 2.0 / (9.0 * d) + REACH * (2.0 / (9.0 * d)).sqrt()).powi(3)).sqrt();
        let mut random = Random::new(self.seed, Purpose::Jitter, 0);
        let mut radii: Vec<f64> = Vec::new();
        while radii.len() < count {
            let mut order: Vec<usize> = (0..cycle).collect();
            random.shuffle(&mut order);
            radii.extend(order.into_iter().map(|k| reach * (k as f64 + random.unit()) / cycle as f64));
        }
        let scaled = |(mut scores, radius): (Vec<f64>, f64)| {
            let length = length(scores.iter().copied());
            scores.iter_mut().for_each(|z| *z *= radius / length);
            scores
        };
        self.plain(count, 2).into_iter().zip(radii).map(scaled).collect()
    }

    /// At or below 0 where the event may happen.
    fn optimistic(&self, surrogate: &Surrogate, scores: &[Vec<f64>]) -> Vec<f64> {
        let points: Vec<Vec<f64>> = scores.iter().map(|z| (self.coordinates)(z)).collect();
        let standard = surrogate.standard(&points);
        let success = surrogate.success.as_ref().map(|success| success.at_once(&standard));
        let may_end = |i: usize, sign: f64| success.as_ref().map(|s| s[i][0] + sign * OPTIMISM * s[i][1]);
        if self.event == Event::Failed {
            return (0..points.len()).map(|i| may_end(i, -1.0).unwrap_or(1.0)).collect();
        }
        let sign = if self.event == Event::Kept { 1.0 } else { -1.0 };
        let mut least = vec![f64::INFINITY; points.len()];
        for limit in self.limits {
            let spread = surrogate.spread(limit.output);
            for (least, [mean, deviation]) in least.iter_mut().zip(surrogate.outputs[limit.output].at_once(&standard)) {
                *least = least.min((limit.margin(mean) + sign * OPTIMISM * deviation) / spread);
            }
        }
        let one = |(i, least): (usize, f64)| (-sign * least).max(-may_end(i, 1.0).unwrap_or(f64::INFINITY));
        least.into_iter().enumerate().map(one).collect()
    }

    /// Points where the event may happen.
    fn led(&self, surrogate: &Surrogate, random: &mut Random) -> Vec<Vec<f64>> {
        let mut scores: Vec<Vec<f64>> = (0..WALKERS).map(|_| random.normals(self.dimensions)).collect();
        let mut levels = self.optimistic(surrogate, &scores);
        for _ in 0..LEVELS {
            let mut order: Vec<usize> = (0..WALKERS).collect();
            order.sort_by(|a, b| levels[*a].total_cmp(&levels[*b]));
            let kept = (KEPT * WALKERS as f64) as usize;
            let level = levels[order[kept]].max(0.0);
            let seeds: Vec<usize> = order.into_iter().take_while(|i| levels[*i] <= level).collect();
            if level <= 0.0 {
                return seeds.into_iter().map(|i| scores[i].clone()).collect();
            }
            (scores, levels) =
                (0..WALKERS).map(|i| seeds[i % seeds.len()]).map(|i| (scores[i].clone(), levels[i])).unzip();
            for step in 0..STEPS {
                // Long and short steps in turn, for an event that is wide and one that is thin.
                let turn: f64 = [0.5, 0.9][step % 2];
                let rest = (1.0 - turn * turn).sqrt();
                let moved = |from: &Vec<f64>, random: &mut Random| -> Vec<f64> {
                    from.iter().map(|z| turn * z + rest * random.normal()).collect()
                };
                let to: Vec<Vec<f64>> = scores.iter().map(|from| moved(from, random)).collect();
                for (i, (to, reached)) in to.iter().zip(self.optimistic(surrogate, &to)).enumerate() {
                    if reached <= level {
                        (scores[i], levels[i]) = (to.clone(), reached);
                    }
                }
            }
        }
        scores
    }

    /// Weighted points around where the event may happen.
    fn population(&self, surrogate: &Surrogate, [count, each]: [usize; 2], random: &mut Random) -> Population {
        let mut led = self.led(surrogate, random);
        random.shuffle(&mut led);
        let centres: Vec<Kernel> = led.into_iter().take(400).map(Kernel::new).collect();
        // A net makes the share more exact than independent draws would; what is said of it counts those.
        let draw = |units: Vec<f64>| {
            let scores = normals(&units[1..]);
            let among = (units[0] - PLAIN) / (1.0 - PLAIN);
            if among < 0.0 { scores } else { centres[(among * centres.len() as f64) as usize].around(scores) }
        };
        let net = units(self.dimensions + 1, count, random.below(usize::MAX) as u64);
        let scores: Vec<Vec<f64>> = net.into_iter().map(draw).collect();
        let d = self.dimensions as f64;
        let weight = |z: &Vec<f64>| {
            let own = -0.5 * z.iter().map(|z| z * z).sum::<f64>() - 0.5 * d * (2.0 * PI).ln();
            let around = centres.iter().map(|kernel| (kernel.log_density(z) - own).exp()).sum::<f64>();
            1.0 / (PLAIN + (1.0 - PLAIN) * around / centres.len() as f64)
        };
        let weights = scores.iter().map(weight).collect();
        let points: Vec<Vec<f64>> = scores.iter().map(|z| (self.coordinates)(z)).collect();
        let values = Possible::new(surrogate, &points, each).event(self.event, self.limits);
        Population { scores, weights, values }
    }

    /// A batch: plain points of the event, and those whose side is least known; each with the probability of the event.
    fn chosen(&self, population: &Population, count: usize, random: &mut Random) -> Vec<(Vec<f64>, Option<f64>)> {
        let parts = population.probabilities();
        let weights = &population.weights;
        let of_event: Vec<f64> = parts.iter().zip(weights).map(|(p, w)| p * w).collect();
        let open: Vec<f64> = parts.iter().zip(weights).map(|(p, w)| (p * (1.0 - p)).sqrt() * w).collect();
        let sum = |weights: &[f64]| weights.iter().sum::<f64>();
        let mut chosen: Vec<usize> = Vec::new();
        if sum(&of_event) > 0.0 {
            chosen.extend((0..count.div_ceil(4)).map(|_| random.pick(&of_event)));
        }
        if sum(&open) > 0.0 {
            let mut candidates: Vec<usize> = (0..300).map(|_| random.pick(&open)).collect();
            candidates.sort_unstable();
            candidates.dedup();
            candidates.retain(|i| !chosen.contains(i));
            let rows = population.values.select_rows(&candidates);
            chosen.extend(undecided(rows, count - chosen.len()).into_iter().map(|k| candidates[k]));
        }
        chosen.sort_unstable();
        chosen.dedup();
        chosen.into_iter().map(|i| (population.scores[i].clone(), Some(parts[i]))).collect()
    }
}

/// Points of the unit cube: those of a net, or independent ones where there is no net of so many dimensions.
fn units(dimensions: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    cube(dimensions, count as u64, seed, 1).unwrap_or_else(|_| {
        let mut random = Random::new(seed, Purpose::Point, 0);
        (0..count).map(|_| (0..dimensions).map(|_| random.unit()).collect()).collect()
    })
}

fn normals(units: &[f64]) -> Vec<f64> {
    let normal = Distribution::Normal { mean: 0.0, deviation: 1.0 };
    units.iter().map(|u| normal.quantile(*u)).collect()
}

/// A normal distribution around a point, narrower along its radius.
struct Kernel {
    centre: Vec<f64>,
    along: Vec<f64>,
    width: f64,
}

impl Kernel {
    fn new(centre: Vec<f64>) -> Self {
        let radius = length(centre.iter().copied());
        let along = centre.iter().map(|z| z / radius).collect();
        Self { centre, along, width: (WIDTHS[1] / radius).min(WIDTHS[0]) }
    }

    fn around(&self, mut scores: Vec<f64>) -> Vec<f64> {
        let along: f64 = scores.iter().zip(&self.along).map(|(z, a)| z * a).sum();
        for ((z, a), centre) in scores.iter_mut().zip(&self.along).zip(&self.centre) {
            *z = centre + WIDTHS[0] * (*z - along * a) + self.width * along * a;
        }
        scores
    }

    fn log_density(&self, scores: &[f64]) -> f64 {
        let (mut along, mut square) = (0.0, 0.0);
        for ((z, a), centre) in scores.iter().zip(&self.along).zip(&self.centre) {
            along += (z - centre) * a;
            square += (z - centre).powi(2);
        }
        let across = (square - along * along).max(0.0);
        let d = self.centre.len() as f64;
        -0.5 * (along / self.width).powi(2)
            - 0.5 * across / WIDTHS[0].powi(2)
            - self.width.ln()
            - (d - 1.0) * WIDTHS[0].ln()
            - 0.5 * d * (2.0 * PI).ln()
    }
}
