//! Gathers points of the event from searches that know nothing of each other, until the last one comes upon nothing new.
//!
//! A search loses parts of the event by chance. Were it the same chance for all, a part that each search loses with the
//! probability e would be lost by k of them with e^k, and the last one would still show e^(k-1): so that it shows nothing
//! new tells that little is lost. Parts that all searches lose alike are looked for by walks (`descend`), and what the levels
//! lead away from by points drawn wider; chains lead from their hits to where the event is most probable.

use super::descend::descend;
use super::draws::draw;
use super::explore::{Population, explore};
use super::mixture::{Mixture, ln_standard};
use super::moves::Moves;
use super::runs::Runs;
use super::widen::widen;
use super::{Answer, Judged, Search, plain};
use crate::distribution::ln_sum;
use crate::random::Random;

/// Searches at most.
const MOST_SEARCHES: usize = 10;
/// Nothing new: a smaller part of a search's points lies outside of what the others know.
const NEW: f64 = 0.05;
/// With fewer walks little is looked for.
const FEWEST_WALKS: usize = 10;
/// Outside of a mixture is a point with a weight of so many times the share: few draws would ever come there, and each would
/// move the estimate.
const OUTSIDE: f64 = 100.0;

/// The mixture is improved by so many trials whenever it has come to know more.
const TRIALS: usize = 3;
/// The mixture cannot be trusted when fewer draws of a trial meet the event.
const FEWEST_HITS: usize = 30;

/// Fewer fresh searches do not tell how they scatter, where they take part in telling the share.
pub(super) const FEWEST: usize = 4;
/// This part of all runs is left for the draws that tell the other part.
pub(super) const DRAWS: u64 = 12;

/// The runs that must be left for both before another search is gathered, where one takes so many: with all that follows it,
/// that takes as many as two or three.
fn needed(search: &Search, of_search: u64) -> u64 {
    (FEWEST as u64 + 3) * of_search + search.runs / DRAWS
}

/// What searches have gathered.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    /// Points of the event.
    points: Vec<Vec<f64>>,
    pub(super) mixture: Mixture,
    /// The share as each search has it, by its levels.
    shares: Vec<f64>,
    /// The runs of the dearest of them.
    pub(super) dearest: u64,
    /// The plain points that the last search began with, and their levels.
    starts: (Vec<Vec<f64>>, Vec<f64>),
    /// Whether no level leads to the event.
    is_flat: bool,
    /// The part of the last search's points that lie outside of what the others know.
    new: f64,
    /// The mixtures of all trials, each with the number of its draws, and the hits of all.
    trials: Vec<(f64, Mixture)>,
    hits: Vec<Vec<f64>>,
    /// The share and the variance of the weights over its square, as each of the last trials has it; none where it met the
    /// event too seldom.
    told: Vec<Option<[f64; 2]>>,
    /// The same variance, as the last search's points have it, which the mixture knows nothing of.
    foretold: f64,
}

/// Searches with populations of so many points; the first of them begin with plain points whose results are known.
pub(super) fn gather<E>(
    search: &Search,
    size: usize,
    known: (Vec<Vec<f64>>, Vec<Judged>),
    runs: &mut Runs<'_, E>,
    random: &mut Random,
    answer: &mut Answer,
) -> Result<Gathered, E> {
    let mut gathered = Gathered { is_flat: search.is_binary, ..Gathered::default() };
    let mut known = known.0.chunks(size).zip(known.1.chunks(size));
    for number in 0..MOST_SEARCHES {
        // What is left must do for the draws, or for the bridge.
        let bridge = needed(search, gathered.dearest).min(search.runs / 5 * 3);
        let kept = bridge.max(search.runs / 4);
        if runs.left() < kept || number > 2 && gathered.shares.is_empty() {
            break;
        }
        let known = known.next();
        let Some(population) = gathered.reach(known, search, size, runs, random, answer)? else {
            // Over flat levels nothing leads to the event.
            gathered.is_flat |= gathered.shares.is_empty();
            continue;
        };
        gathered.take(population);
        // Once there is a mixture, fewer walks do.
        let is_first = gathered.shares.len() == 1;
        let walks = (size / if is_first { 25 } else { 50 }).max(FEWEST_WALKS);
        let is_wider = gathered.walk(walks, runs, random)?;
        if is_first {
            gathered.look_wide(search.dimensions, size, runs, random)?;
        }
        let is_settled = gathered.is_settled();
        if is_wider || !is_settled {
            gathered.improve(runs, random)?;
        }
        if is_settled {
            break;
        }
    }
    Ok(gathered)
}

impl Gathered {
    /// The points of the event that another search comes to; none where it does not arrive. It begins with plain points
    /// whose results are known, or with new ones.
    pub(super) fn reach<E>(
        &mut self,
        known: Option<(&[Vec<f64>], &[Judged])>,
        search: &Search,
        size: usize,
        runs: &mut Runs<'_, E>,
        random: &mut Random,
        answer: &mut Answer,
    ) -> Result<Option<Population>, E> {
        let before = runs.made;
        let population = if self.is_flat {
            let wider = &mut answer.wider;
            widen(search.dimensions, size as u64, runs, random, wider)?
        } else {
            self.starts = match known {
                Some((points, results)) => (points.to_vec(), results.iter().map(Judged::rank).collect()),
                None => {
                    let points = plain(search, size as u64, random);
                    let levels = runs.levels(&points)?;
                    (points, levels)
                }
            };
            let mut levels = Vec::new();
            let starts = self.starts.clone();
            let population = explore(starts, search.runs / 3, runs, random, &mut levels)?;
            if answer.levels.len() < levels.len() {
                answer.levels = levels;
            }
            population
        };
        self.dearest = self.dearest.max(runs.made - before);
        Ok(population)
    }

    /// The share as all searches have it; none where none has arrived.
    pub(super) fn share(&self) -> Option<f64> {
        let count = self.shares.len() as f64;
        let sum = self.shares.iter().sum::<f64>();
        (count > 0.0).then(|| sum / count)
    }

    /// Whether the last search came upon nothing new.
    pub(super) fn is_settled(&self) -> bool {
        // More draws than there are would be needed: what lies outside has large weights.
        const HOPELESS: f64 = 200.0;
        self.shares.len() > 1 && self.new < NEW && self.foretold < HOPELESS
    }

    /// The variance of the weights over the square of their mean, as the trials and the last search have it. A single one
    /// may have missed the largest weights.
    pub(super) fn scatter(&self) -> Option<f64> {
        let told: Option<Vec<[f64; 2]>> = self.told.iter().copied().collect();
        let told = told.filter(|told| !told.is_empty())?;
        Some(told.iter().fold(self.foretold, |most, [_, scatter]| most.max(*scatter)))
    }

    /// The same from points of the event that the mixture does not know: the mean of p / (P q) over them, less 1.
    fn foretell(&mut self, points: &[Vec<f64>]) {
        let shares: Vec<f64> = self.told.iter().flatten().map(|[share, _]| *share).collect();
        if shares.is_empty() {
            return;
        }
        let share = shares.iter().sum::<f64>() / shares.len() as f64;
        let from = self.proposal();
        let ratio = |point: &Vec<f64>| (ln_standard(point) - from.ln_density(point)).exp() / share;
        self.foretold = points.iter().map(ratio).sum::<f64>() / points.len() as f64 - 1.0;
    }

    /// Takes the points of another search.
    fn take(&mut self, population: Population) {
        self.shares.push(population.share);
        let outside = match self.mixture.len() {
            0 => population.points.clone(),
            _ => self.outside(&population.points),
        };
        self.new = outside.len() as f64 / population.points.len() as f64;
        if self.shares.len() > 1 {
            self.foretell(&population.points);
        }
        self.points.extend_from_slice(&population.points);
        self.add(&outside);
    }

    /// Adds components for points that lie outside.
    fn add(&mut self, outside: &[Vec<f64>]) {
        if outside.is_empty() {
            return;
        }
        let more = Mixture::of_chains(outside);
        let part = outside.len() as f64 / self.points.len().max(outside.len()) as f64;
        self.mixture.add(more, part);
    }

    /// The weight of a point from which on it lies outside of a mixture.
    pub(super) fn limit(&self) -> f64 {
        OUTSIDE * self.share().unwrap_or(1.0)
    }

    /// The points that lie outside of the mixture.
    fn outside(&self, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let all = self.mixture.widened();
        let limit = self.limit().ln();
        let is_outside = |point: &&Vec<f64>| ln_standard(point) - all.ln_density(point) > limit;
        points.iter().filter(is_outside).cloned().collect()
    }

    /// The mixture to draw from.
    pub(super) fn proposal(&self) -> Mixture {
        self.mixture.defended(&self.points)
    }

    /// Improves the mixture by trials. Their hits are independent of each other, and count as if drawn from the mean of all
    /// mixtures that were tried (Veach and Guibas 1995, "Optimally combining sampling techniques").
    pub(super) fn improve<E>(&mut self, runs: &mut Runs<'_, E>, random: &mut Random) -> Result<(), E> {
        const FEWEST_DRAWS: u64 = 1000;
        self.told.clear();
        for _ in 0..TRIALS {
            let count = FEWEST_DRAWS.min(runs.most / 50).max(50 * self.mixture.len() as u64);
            if runs.left() < count {
                break;
            }
            let from = self.proposal();
            let drawn = draw(&from, count, runs, random)?;
            let told = [drawn.mean(), drawn.scatter()];
            self.trials.push((count as f64, from));
            let (hits, _) = drawn.hits();
            self.told.push((hits.len() >= FEWEST_HITS).then_some(told));
            self.hits.extend(hits);
            if self.hits.len() >= FEWEST_HITS {
                self.refit(random);
            }
        }
        Ok(())
    }

    /// Takes the mixture whose weights would scatter least over the hits of all trials.
    fn refit(&mut self, random: &mut Random) {
        // More of them would take long, and tell little more.
        const MOST: usize = 2500;
        let chosen = random.choice(MOST, self.hits.len());
        let hits: Vec<Vec<f64>> = chosen.iter().map(|&k| self.hits[k].clone()).collect();
        let ln_drawn = |point: &Vec<f64>| {
            let terms = self.trials.iter();
            let terms: Vec<f64> = terms.map(|(n, m)| n.ln() + m.ln_density(point)).collect();
            ln_sum(&terms)
        };
        let weights: Vec<f64> = (hits.iter()).map(|point| ln_standard(point) - ln_drawn(point)).collect();
        let most = weights.iter().copied().fold(f64::MIN, f64::max);
        let mut weights: Vec<f64> = weights.iter().map(|w| (w - most).exp()).collect();
        cap(&mut weights);
        let scatter = |mixture: &Mixture| -> f64 {
            let from = mixture.defended(&self.points);
            let pairs = hits.iter().zip(&weights);
            pairs.map(|(point, w)| w * (ln_standard(point) - from.ln_density(point)).exp()).sum()
        };
        let candidates = [
            Mixture::fit(&hits, &weights, 1.0),
            self.mixture.fit_on(&hits, &weights),
            std::mem::take(&mut self.mixture),
        ];
        let scattered = candidates.map(|mixture| (scatter(&mixture), mixture));
        let least = scattered.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        self.mixture = least.expect("there are three").1;
    }

    /// Looks for parts of the event that the searches lose, by walks from so many of the last one's plain points; tells
    /// whether there are any. Where few walks come to one, the mixture follows it from now on; many show that there are more.
    fn walk<E>(&mut self, count: usize, runs: &mut Runs<'_, E>, random: &mut Random) -> Result<bool, E> {
        const MANY: f64 = 0.1;
        let (points, levels) = std::mem::take(&mut self.starts);
        let chosen = random.choice(count, points.len());
        let starts = chosen.iter().map(|&k| (points[k].clone(), levels[k]));
        let hits = descend(starts, runs, random)?;
        let new = self.follow(&hits, runs, random)? * hits.len() as f64 / count as f64;
        if new > MANY {
            self.new = self.new.max(new);
        }
        Ok(new > 0.0)
    }

    /// The same among points drawn wider.
    fn look_wide<E>(
        &mut self,
        dimensions: usize,
        size: usize,
        runs: &mut Runs<'_, E>,
        random: &mut Random,
    ) -> Result<(), E> {
        const SCALES: [f64; 2] = [2.0, 3.0];
        for scale in SCALES {
            let draw = |_| -> Vec<f64> {
                let scores = random.normals(dimensions);
                scores.into_iter().map(|z| scale * z).collect()
            };
            let points = (0..size / 2).map(draw).collect();
            let hits = runs.hits(points)?;
            self.follow(&hits, runs, random)?;
        }
        Ok(())
    }

    /// Follows hits that lie outside to where the event is most probable, and takes what is new there; tells which
    /// part of the hits is.
    pub(super) fn follow<E>(
        &mut self,
        hits: &[Vec<f64>],
        runs: &mut Runs<'_, E>,
        random: &mut Random,
    ) -> Result<f64, E> {
        const MOST_CHAINS: usize = 100;
        const FEWEST_CHAINS: usize = 40;
        const STEPS: usize = 20;
        const KEPT: usize = 8;
        let all = hits.len();
        let hits = self.outside(hits);
        let part = hits.len() as f64 / all as f64;
        let chains = (4 * hits.len()).clamp(FEWEST_CHAINS, MOST_CHAINS);
        if hits.is_empty() || runs.left() < (chains * STEPS) as u64 {
            return Ok(0.0);
        }
        let chosen = random.choice(hits.len(), hits.len());
        let mut points: Vec<Vec<f64>> = (0..chains).map(|k| hits[chosen[k % chosen.len()]].clone()).collect();
        let mut moves = Moves::along(&points, [0.4, 1.0]);
        let mut led = Vec::new();
        for step in 0..STEPS {
            let tried: Vec<Vec<f64>> = points.iter().map(|p| moves.from(p, 1.0, random)).collect();
            let results = runs.of(&tried)?;
            let mut accepted = 0;
            for ((point, next), result) in points.iter_mut().zip(tried).zip(results) {
                if result.met {
                    accepted += 1;
                    *point = next;
                }
            }
            moves.adapt(f64::from(accepted) / chains as f64);
            if step >= STEPS - KEPT {
                led.extend(points.iter().cloned());
            }
        }
        let outside = self.outside(&led);
        self.points.extend(outside.iter().cloned());
        self.add(&outside);
        Ok(outside.len() as f64 / led.len() as f64 * part)
    }
}

/// Lowers the few largest weights to the largest of the others, so that no fit follows a few points.
fn cap(weights: &mut [f64]) {
    let mut sorted = weights.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let few = weights.len() / 20;
    let Some(&most) = sorted.get(few.max(1)) else {
        return;
    };
    weights.iter_mut().for_each(|w| *w = w.min(most));
}
