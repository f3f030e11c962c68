//! Shares that are too small to be counted among plain samples.
//!
//! Points are standard normal scores, one for each parameter; the caller turns them into parameters and runs the model.
//! [`share`] takes these steps, and every set of points that it asks for depends on the answers to the earlier ones only:
//!
//! 1. Plain points. Where the event is frequent, counting is the better method.
//! 2. Searches that know nothing of each other look for the event by levels that come nearer to it (`explore`), or, where
//!    the model says only whether the event happens, by points drawn wider (`widen`), until neither the last one nor walks
//!    that only go down (`descend`) come upon anything that the others do not know (`gather`).
//! 3. A mixture of normal distributions is fitted to what they found and improved by trials, and its independent draws give
//!    the share with its interval (`weigh`). Draws that lie outside of what the mixture follows are searched from anew.
//!
//! Where searches or draws still come upon something new, further searches tell which part of the event the mixture follows,
//! and the interval is wide (`bridge`). A region that none has reached is not counted, and nothing can tell that there is
//! none.

mod bridge;
mod descend;
mod draws;
mod explore;
mod gather;
mod mixture;
mod moves;
mod runs;
mod scatter;
#[cfg(test)]
mod tests;
mod weigh;
mod widen;

use crate::random::{Purpose, Random};
use gather::gather;
use runs::Runs;

/// The result of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// How far the point is from the event: smaller is nearer, in any unit.
    pub level: f64,
    /// Whether the event happens.
    pub met: bool,
    /// Whether the run failed, so that it has no level.
    pub failed: bool,
}

impl Judged {
    /// The level for the search: that of the event is below all others, that of a failed run above.
    fn rank(&self) -> f64 {
        if self.met {
            f64::NEG_INFINITY
        } else if self.failed || self.level.is_nan() {
            f64::INFINITY
        } else {
            self.level.clamp(f64::MIN, f64::MAX)
        }
    }
}

/// Runs points, given as standard normal scores, and tells what came of them, in their order.
pub type Ask<'a, E> = &'a mut dyn FnMut(&[Vec<f64>]) -> Result<Vec<Judged>, E>;

/// The event whose probability is wanted, and the runs that may be spent.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Parameters that vary.
    pub dimensions: usize,
    /// The largest number of runs; at least [`FEWEST_RUNS`].
    pub runs: u64,
    /// The seed of the points.
    pub seed: u64,
    /// The probability with which the interval shall hold the share.
    pub confidence: f64,
    /// Whether runs tell only whether the event happens, not how far it is.
    pub is_binary: bool,
}

/// With fewer runs nothing rare is found.
pub const FEWEST_RUNS: u64 = 5000;
/// Counting is the better method from this share on.
pub const FREQUENT: f64 = 1e-3;

/// How a share was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Plain points were counted.
    Counted,
    /// Weighted draws from a mixture.
    Weighted,
    /// Weighted draws for a part of the event, and searches that tell which part that is.
    Bridged,
}

/// Points that were drawn from the parameters' own distribution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plain {
    /// How many.
    pub runs: u64,
    /// In how many of them the event happened.
    pub met: u64,
    /// How many failed.
    pub failed: u64,
}

/// A part of the event.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RegionShare {
    /// Its share of the space.
    pub share: f64,
    /// Its point that is nearest to the mean of all of them, in standard normal scores.
    pub centre: Vec<f64>,
}

/// A point at which the event happens.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighted {
    /// The point.
    pub scores: Vec<f64>,
    /// The share that it stands for. All together are the share of the event.
    pub weight: f64,
}

/// A share and how sure it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// The estimate.
    pub value: f64,
    /// Its interval; none where plain points are counted ([`Answer::plain`]), whose interval is that of a count.
    pub interval: Option<[f64; 2]>,
    /// The relative standard error.
    pub error: f64,
    /// As many independent points that meet the event would tell as much.
    pub effective: f64,
    /// How it was found.
    pub method: Method,
}

/// The result of a search.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// The share; none where it could not be told.
    pub share: Option<Share>,
    /// A rough number where the share itself could not be told: it has no interval.
    pub rough: Option<f64>,
    /// The shares by draws and by levels, where they do not agree: a part of the event may be lost.
    pub disagree: Option<[f64; 2]>,
    /// Runs that were made.
    pub runs: u64,
    /// Plain points among them, with those in which the event is counted.
    pub plain: Plain,
    /// The levels on the way to the event, with the share of the space that reaches them, roughly.
    pub levels: Vec<(f64, f64)>,
    /// Draws wider than the parameters' own distribution, and how many of them met the event; for a binary event.
    pub wider: Plain,
    /// Regions that were found, the largest first.
    pub regions: Vec<RegionShare>,
    /// Points that meet the event.
    pub sample: Vec<Weighted>,
}

/// The share of the space in which an event happens.
///
/// # Errors
/// Those of `ask`.
pub fn share<E>(search: &Search, ask: Ask<'_, E>) -> Result<Answer, E> {
    /// The levels of populations of 1,000 points err by less than this factor.
    const FAR: f64 = 5.0;
    // A hundredth of the runs is a population.
    let size = (search.runs / 100).clamp(50, 1000);
    let mut runs = Runs::new(ask, search.runs);
    let mut random = Random::new(search.seed, Purpose::Search, 0);
    let mut answer = Answer::default();
    let points = plain(search, 2 * size, &mut random);
    let results = runs.of(&points)?;
    answer.count(&points, &results);
    let Plain { runs: all, met, .. } = answer.plain;
    if met >= 10 && met as f64 >= FREQUENT * all as f64 {
        return counted(search, answer, runs, &mut random);
    }
    let known = (points, results);
    let population = size as usize;
    let mut gathered = gather(search, population, known, &mut runs, &mut random, &mut answer)?;
    // Where no way leads to the event, as over flat outputs, the runs that are left tell at least how large its share may be.
    let Some(rough) = gathered.share().filter(|share| *share < FREQUENT) else {
        return counted(search, answer, runs, &mut random);
    };
    let is_told =
        gathered.is_settled() && weigh::weigh(&mut gathered, search.confidence, &mut runs, &mut random, &mut answer)?;
    let is_told = is_told || bridge::tell(&mut gathered, search, population, &mut runs, &mut random, &mut answer)?;
    if !is_told {
        answer.rough = Some(rough);
    } else if let Some(share) = answer.share.clone()
        && !search.is_binary
        && share.value < rough / (FAR * (1000.0 / size as f64).sqrt())
    {
        answer.share = None;
        answer.sample.clear();
        answer.regions.clear();
        answer.disagree = Some([share.value, rough]);
    }
    answer.runs = runs.made;
    Ok(answer)
}

/// Counts the event among fresh plain points: as many as tell a frequent one well, or all that are left.
fn counted<E>(search: &Search, mut answer: Answer, mut runs: Runs<'_, E>, random: &mut Random) -> Result<Answer, E> {
    /// So many hits leave a relative error of 5 %.
    const HITS: f64 = 400.0;
    let first = answer.plain;
    answer.plain = Plain::default();
    answer.sample = Vec::new();
    let expected = (first.met.max(1) as f64 / first.runs as f64).min(1.0);
    let count = ((HITS / expected).ceil() as u64).min(runs.left());
    let points = plain(search, count, random);
    let results = runs.of(&points)?;
    answer.count(&points, &results);
    answer.runs = runs.made;
    let Plain { runs: all, met, .. } = answer.plain;
    if met > 0 {
        let value = met as f64 / all as f64;
        answer.share = Some(Share {
            value,
            interval: None,
            error: ((1.0 - value) / met as f64).sqrt(),
            effective: met as f64,
            method: Method::Counted,
        });
        let sample = answer.sample.iter_mut();
        sample.for_each(|point| point.weight = 1.0 / all as f64);
    }
    Ok(answer)
}

fn plain(search: &Search, count: u64, random: &mut Random) -> Vec<Vec<f64>> {
    (0..count).map(|_| random.normals(search.dimensions)).collect()
}

impl Answer {
    /// Counts plain points.
    fn count(&mut self, points: &[Vec<f64>], results: &[Judged]) {
        for (point, result) in points.iter().zip(results) {
            self.plain.runs += 1;
            self.plain.met += u64::from(result.met);
            self.plain.failed += u64::from(result.failed);
            if result.met {
                self.sample.push(Weighted { scores: point.clone(), weight: 0.0 });
            }
        }
    }
}
