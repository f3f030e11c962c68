//! Parameters that vary from case to case: each case's value comes from a normal distribution whose mean and standard
//! deviation are unknown, too.
//!
//! In the coordinates of the sample a case's value is its distance from the mean in standard deviations: then the
//! distribution has no funnel where the spread is small (Papaspiliopoulos, Roberts & Sköld 2007, A general framework for the
//! parametrization of hierarchical models, Statistical Science 22, 59-73). Where the data determine the values well, mean
//! and spread mix badly in these coordinates; so they are also moved with the values as they are, which costs no runs (Yu &
//! Meng 2011, To center or not to center, J. Computational and Graphical Statistics 20, 531-570).

use sampling::{distribution::Distribution, random::Random, statistics::moments::variance};

use super::super::problem::{Population, Problem};

/// The largest spread, in standard deviations of its prior: a half-normal distribution.
const LARGEST: f64 = 5.0;

/// A case's value lies within so many standard deviations of the mean.
const FARTHEST: f64 = 6.0;

/// Moves of mean and spread for each move of the values.
const MOVES: usize = 8;

/// A population in the coordinates of the sample.
pub struct PopulationPlaces {
    members: Vec<usize>,
    /// The coordinate of the mean; that of the spread is the next one.
    at: usize,
    mean: Distribution,
    spread: Distribution,
    /// The largest spread of the members' places.
    largest: f64,
}

impl PopulationPlaces {
    /// The mean has the prior of a single value. The spread has a half-normal prior with the standard deviation of that.
    pub fn new(problem: &Problem, population: &Population, at: usize) -> Self {
        let prior = problem.free[population.members[0]].prior_place();
        let deviation = population.scale(problem);
        Self {
            members: population.members.clone(),
            at,
            mean: before(prior),
            spread: before(Some((0.0, LARGEST.recip()))),
            largest: LARGEST * deviation,
        }
    }

    /// Whether a coordinate is that of a member.
    pub fn has(&self, coordinate: usize) -> bool {
        self.members.contains(&coordinate)
    }

    /// The spread of the members' places.
    pub fn deviation(&self, coordinates: &[f64]) -> f64 {
        self.largest * coordinates[self.at + 1]
    }

    /// Turns the members' coordinates into their places, and the spread's into the standard deviation of these.
    pub fn place(&self, coordinates: &mut [f64]) {
        let (mean, deviation) = (coordinates[self.at], self.deviation(coordinates));
        for &member in &self.members {
            let scores = (2.0 * coordinates[member] - 1.0) * FARTHEST;
            coordinates[member] = mean + deviation * scores;
        }
        coordinates[self.at + 1] = deviation;
    }

    /// The distribution of a member's place.
    fn of_member(mean: f64, deviation: f64) -> Distribution {
        let reach = FARTHEST * deviation;
        Distribution::TruncatedNormal {
            mean,
            deviation,
            min: Some((mean - reach).max(0.0)),
            max: Some((mean + reach).min(1.0)),
        }
    }

    /// The logarithm of the density of the members' places, given mean and spread.
    fn log_members(&self, mean: f64, deviation: f64, places: &[f64]) -> f64 {
        if !(deviation > 0.0 && (0.0..=1.0).contains(&mean)) {
            return f64::NEG_INFINITY;
        }
        let member = Self::of_member(mean, deviation);
        places.iter().map(|&place| member.ln_density(place)).sum()
    }

    /// The members' places.
    fn places(&self, coordinates: &[f64]) -> Vec<f64> {
        let mut places = coordinates.to_vec();
        self.place(&mut places);
        self.members.iter().map(|&member| places[member]).collect()
    }

    /// The logarithm of the prior density of the coordinates of members, mean and spread.
    pub fn log_prior(&self, coordinates: &[f64]) -> f64 {
        let (mean, deviation) = (coordinates[self.at], self.deviation(coordinates));
        let volume = self.members.len() as f64 * (2.0 * FARTHEST * deviation).ln();
        let common = self.log_common(mean, coordinates[self.at + 1]);
        common + self.log_members(mean, deviation, &self.places(coordinates)) + volume
    }

    fn log_common(&self, mean: f64, spread: f64) -> f64 {
        self.mean.ln_density(mean) + self.spread.ln_density(spread)
    }

    /// Draws mean, spread and members from the prior.
    pub fn draw(&self, coordinates: &mut [f64], random: &mut Random) {
        coordinates[self.at] = self.mean.quantile(random.unit());
        coordinates[self.at + 1] = self.spread.quantile(random.unit());
        let (mean, deviation) = (coordinates[self.at], self.deviation(coordinates));
        let member = Self::of_member(mean, deviation);
        for &index in &self.members {
            self.put(coordinates, index, member.quantile(random.unit()));
        }
    }

    /// Gives a member this place.
    fn put(&self, coordinates: &mut [f64], member: usize, place: f64) {
        let (mean, deviation) = (coordinates[self.at], self.deviation(coordinates));
        coordinates[member] = 0.5 + 0.5 * (place - mean) / (FARTHEST * deviation);
    }

    /// Moves mean and spread by Metropolis steps and leaves the members' places as they are.
    pub fn refresh(&self, coordinates: &mut [f64], random: &mut Random) {
        let places = self.places(coordinates);
        let count = places.len() as f64;
        // Steps hang on the places alone, so each can be undone.
        let far = 1.7 / count.sqrt();
        let scale = variance(&places, 0).sqrt();
        let log = |mean: f64, spread: f64| {
            let members = self.log_members(mean, self.largest * spread, &places);
            // The spread goes by factors.
            self.log_common(mean, spread) + members + spread.ln()
        };
        let (mut mean, mut spread) = (coordinates[self.at], coordinates[self.at + 1]);
        let mut here = log(mean, spread);
        for _ in 0..MOVES {
            let to = (
                mean + far * scale * random.normal(),
                spread * (far * std::f64::consts::FRAC_1_SQRT_2 * random.normal()).exp(),
            );
            let there = log(to.0, to.1);
            if random.unit().ln() < there - here {
                ((mean, spread), here) = (to, there);
            }
        }
        coordinates[self.at] = mean;
        coordinates[self.at + 1] = spread;
        for (&member, &place) in self.members.iter().zip(&places) {
            self.put(coordinates, member, place);
        }
    }
}

/// The prior of a place, given its centre and deviation where there are any.
pub fn before(prior: Option<(f64, f64)>) -> Distribution {
    let [min, max] = [0.0, 1.0];
    match prior {
        None => Distribution::Uniform { min, max },
        Some((mean, deviation)) => Distribution::TruncatedNormal { mean, deviation, min: Some(min), max: Some(max) },
    }
}
