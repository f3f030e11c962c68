//! The scout of a leap: a film's turns at a few temperatures, from which its heat is known on the whole way.
//!
//! A film that takes steps of its own has no orbit that could be integrated by itself. Its oil must be carried around until it
//! repeats itself, and a turn of it takes as long as some hundred of the mobility film. So the mobility film leads the temperatures
//! on their way, with its flows corrected to those of this film ([`Correction`]). Turns of the film are needed only where the way
//! begins, where it ends, and between them until a turn is what the correction expected. At each of these temperatures the film
//! is brought to its periodic orbit by Anderson's mixing (`journal_bearing::reynolds::PeriodicSearch`).
//!
//! Where thick oil leaves a narrow film slowly, the approach to the orbit lasts tens of turns. The resolved turns before the leap
//! show how it shrinks. The heat that the rest of it adds comes into the leap.
//!
//! Where speed and load repeat themselves only after several turns of the shaft, a turn here is all of these.

use super::Stand;
use crate::{
    Result,
    bearing::{Film, Flows},
    multirate::{self, CLOSEST, Correction, Departure, NoLeap},
    thermal::Temperatures,
};

/// Turns at the most until the film is on its orbit.
const ORBIT_TURNS: usize = 40;
/// The heat repeats itself when one turn differs from the next by less than this many relative tolerances, of its own size.
pub const SETTLED: f64 = 100.0;
/// The film is on its orbit if the search moves its next beginning by less than this: eccentricity ratio and content.
const NEAR: f64 = 5e-4;
/// The correction is known if a new temperature changes it by less than this share of the heat, at a relative tolerance of one.
const KNOWN: f64 = 1500.0;
/// These shares lie within these bounds at any tolerance: the film's own steps do not follow it.
const LEAST: f64 = 2e-5;
const MOST: f64 = 1e-2;
/// The film may lag its orbit by at most this fraction of the error that the correction may have.
const BEHIND: f64 = 0.15;
/// Temperatures at the most at which the film's turns are needed.
const PLACES: usize = 12;
/// In two turns the approach to the orbit shrinks to this share of itself at the most.
const SLOWEST: f64 = 0.97;

/// Means over a turn of the film.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turn {
    /// Its heat and flows.
    pub flows: Flows,
    /// The film's temperature, K.
    pub film: f64,
}

impl Turn {
    /// Adds a share of the turn.
    pub fn add(&mut self, flows: &Flows, film: f64, share: f64) {
        self.flows = self.flows.plus(&flows.times(share));
        self.film += share * film;
    }
}

/// The film's approach to its orbit after a departure.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// The flows in the last turn before it beyond those of the orbit.
    excess: Flows,
    /// The excess of its heat as a share of the turn's.
    pub share: f64,
    /// Turns that would have the same excess as all that follow.
    turns: f64,
}

impl Approach {
    /// A portion of its sum.
    fn heat(&self, portion: f64) -> Flows {
        self.excess.times(portion * self.turns)
    }
}

/// The film's averages during a leap.
pub struct Scout {
    /// The same stand with the mobility film.
    mobility: Stand,
    /// The same stand at constant temperatures, whose turns go ahead of the leap.
    ahead: Stand,
    correction: Correction,
    /// The film on its orbit at the viscosities, Pa.s, at which it is known.
    pub known: Vec<(f64, Film)>,
    pub approach: Option<Approach>,
    /// The temperatures where it began to look.
    departure: Temperatures,
    /// The shaft's turns ahead so far.
    pub turns: usize,
}

impl Scout {
    /// A scout that knows nothing yet, at the stand's present place.
    pub fn new(stand: &Stand) -> Result<Self> {
        let mut ahead = stand.clone();
        ahead.thermal.isothermal = true;
        Ok(Self {
            mobility: stand.clone().with_a_fast_film()?,
            ahead,
            correction: Correction::default(),
            known: Vec::new(),
            approach: None,
            departure: stand.state.temperatures,
            turns: 0,
        })
    }

    /// Resolves turns at these temperatures until the film's heat repeats itself. The correction then holds there. Returns by
    /// how much of the heat it had been wrong.
    pub fn look(&mut self, at: Temperatures) -> Result<f64, NoLeap> {
        self.ahead.state.temperatures = at;
        if let Some(film) = self.nearest(&at) {
            self.ahead.film = film;
        }
        let close = share(SETTLED, &self.ahead);
        let flows = self.orbit(close)?;
        let fast = self.mobility_flows(&at)?;
        let viscosity = self.ahead.fluid.viscosity(at.film);
        let expected = self.correction.apply(viscosity, &fast);
        let wrong = self.ahead.surprise(&expected, &flows, &at);
        self.correction.learn(viscosity, &flows, &fast);
        self.known.push((viscosity, self.ahead.film.clone()));
        Ok(wrong)
    }

    /// The film's flows on its periodic orbit.
    fn orbit(&mut self, close: f64) -> Result<Flows, NoLeap> {
        let ahead = &mut self.ahead;
        let temperatures = ahead.state.temperatures;
        if let Some(film) = ahead.film.transient() {
            film.seek_orbit();
        }
        let mut before: Option<Flows> = None;
        for _ in 0..ORBIT_TURNS {
            let turn = ahead.resolve_cycle()?;
            self.turns += ahead.turns_of_a_cycle();
            let Some(film) = ahead.film.transient() else {
                break;
            };
            let moved = film.end_turn();
            ahead.state.eccentricity = film.eccentricity();
            let change = before.map_or(f64::INFINITY, |before| ahead.surprise(&before, &turn.flows, &temperatures));
            if change < close && moved < NEAR {
                return Ok(turn.flows);
            }
            before = Some(turn.flows);
        }
        Err(NoLeap::Untold(format!(
            "the film's heat does not repeat itself after {} turns",
            ORBIT_TURNS * self.ahead.turns_of_a_cycle()
        )))
    }

    /// Of the films that have settled on their orbits, the one at the viscosity nearest to that at these temperatures.
    pub fn nearest(&self, to: &Temperatures) -> Option<Film> {
        let viscosity = self.ahead.fluid.viscosity(to.film);
        let distance = |(known, _): &&(f64, Film)| (known / viscosity).ln().abs();
        let known = self.known.iter();
        let nearest = known.min_by(|one, other| distance(one).total_cmp(&distance(other)));
        nearest.map(|(_, film)| film.clone())
    }

    /// The mobility film's flows at these temperatures.
    fn mobility_flows(&self, at: &Temperatures) -> Result<Flows, NoLeap> {
        let state = &self.ahead.state;
        let at = Departure::at(state.eccentricity, *at, state.worn);
        multirate::flows(&self.mobility, self.ahead.solver.tolerance, &at)
    }

    /// Takes over the rest of the film's approach to its orbit, after some resolved turns. It shrinks from turn to turn as it did between
    /// these. Turns count in pairs, since a whirl at half the shaft's speed alternates from turn to turn.
    pub fn see_the_approach(&mut self, resolved: &[Turn]) -> Result<(), NoLeap> {
        let [.., a, b, c, d] = resolved else {
            return Ok(());
        };
        let now = self.ahead.state.temperatures;
        let excess = |turn: &Turn| -> Result<Flows, NoLeap> {
            let at = Temperatures { film: turn.film, ..now };
            let viscosity = self.ahead.fluid.viscosity(turn.film);
            let expected = self.correction.apply(viscosity, &self.mobility_flows(&at)?);
            Ok(turn.flows.minus(&expected))
        };
        let before = excess(a)?.plus(&excess(b)?);
        let last = excess(c)?.plus(&excess(d)?).times(0.5);
        let ratio = 2.0 * last.heat() / before.heat();
        let shrinking = ratio.clamp(0.0, SLOWEST).sqrt();
        let small = last.heat().abs() < share(SETTLED, &self.ahead) * d.flows.heat();
        self.approach = (!small).then_some(Approach {
            excess: last,
            share: last.heat().abs() / d.flows.heat(),
            turns: shrinking / (1.0 - shrinking),
        });
        Ok(())
    }

    /// Turns until what is left of the approach warms or cools the film by less than this, K; `None` if it does already.
    pub fn turns_until_left(&self, warming: f64) -> Option<usize> {
        let approach = self.approach.as_ref()?;
        let now = &self.ahead.state.temperatures;
        let left = (self.warmed(now, &approach.heat(1.0)).film - now.film).abs();
        // Its sum shrinks by this share in a turn.
        let share = 1.0 / (1.0 + approach.turns);
        (left > warming).then(|| ((left / warming).ln() / -(-share).ln_1p()).ceil() as usize)
    }

    /// Turns before `end`, `turns` after the departure, that have to be resolved because the film is behind its orbit: as the orbit
    /// moves, the film follows it as slowly as it came near it in its first approach. What is left of the heat that it is off
    /// shrinks with each of them.
    pub fn landing(&self, first: Option<Approach>, turns: usize, end: &Temperatures) -> Result<usize, NoLeap> {
        let Some(approach) = first else {
            return Ok(0);
        };
        let heat = |at: &Temperatures| -> Result<f64, NoLeap> {
            let viscosity = self.ahead.fluid.viscosity(at.film);
            let fast = self.mobility_flows(at)?;
            Ok(self.correction.apply(viscosity, &fast).heat())
        };
        let moves = (heat(end)? / heat(&self.departure)?).ln().abs() / turns as f64;
        let behind = approach.share * moves * approach.turns;
        let close = BEHIND * share(KNOWN, &self.ahead);
        Ok((approach.turns * (behind / close).ln()).max(0.0).ceil() as usize)
    }

    /// The temperatures `turns` whole turns later, from where the scout began to look.
    pub fn lead(&mut self, turns: usize, from: &Departure) -> Result<Temperatures, NoLeap> {
        let close = share(KNOWN, &self.ahead);
        while self.known.len() < PLACES {
            let way = self.way(turns, from)?;
            let end = *way.last().expect("a way has an end");
            let Some(at) = self.farthest(&way) else {
                return Ok(end);
            };
            if self.look(at)? < close {
                let way = self.way(turns, from)?;
                return Ok(*way.last().expect("a way has an end"));
            }
        }
        Err(NoLeap::Untold(format!("after {PLACES} temperatures the film's heat is still not known between them")))
    }

    /// The temperatures on the way over so many turns. The heat of the approach comes in two portions, so that its sum, its
    /// middle and its spread are right (Gauss-Laguerre quadrature).
    fn way(&self, turns: usize, from: &Departure) -> Result<Vec<Temperatures>, NoLeap> {
        const ROOT: f64 = std::f64::consts::SQRT_2;
        const PORTIONS: [(f64, f64); 2] = [(2.0 - ROOT, 0.25 * (2.0 + ROOT)), (2.0 + ROOT, 0.25 * (2.0 - ROOT))];
        let (mut from, mut done, mut way) = (*from, 0, Vec::new());
        for (time, portion) in self.approach.iter().flat_map(|_| PORTIONS) {
            let Some(approach) = &self.approach else {
                break;
            };
            let until = ((time * approach.turns).round() as usize).clamp(done, turns);
            way.extend(self.part(until - done, &from)?);
            let here = *way.last().expect("a way has an end");
            from.temperatures = self.warmed(&here, &approach.heat(portion));
            done = until;
        }
        way.extend(self.part(turns - done, &from)?);
        Ok(way)
    }

    /// Temperatures after heat and flows of one turn, W and m3/s, that come at once and in addition.
    fn warmed(&self, t: &Temperatures, flows: &Flows) -> Temperatures {
        let clearance = self.mobility.clearance(t, self.ahead.state.worn);
        let rates = |flows: &Flows| multirate::vector(&self.mobility.thermal_rates(0.0, t, clearance, flows));
        let added = rates(flows) - rates(&Flows::default());
        multirate::temperatures(&(multirate::vector(t) + added * self.mobility.cycle()))
    }

    fn part(&self, turns: usize, from: &Departure) -> Result<Vec<Temperatures>, NoLeap> {
        if turns == 0 {
            return Ok(vec![from.temperatures]);
        }
        let (mobility, tolerance) = (&self.mobility, self.ahead.solver.tolerance);
        multirate::way(mobility, &self.correction, tolerance, turns, from)
    }

    /// The temperatures on the way that are farthest from those at which the film is known; `None` if all of them are next to
    /// these.
    fn farthest(&self, way: &[Temperatures]) -> Option<Temperatures> {
        const PARTS: i32 = 8;
        let between = |ends: &[Temperatures]| {
            let [from, to] = [&ends[0], &ends[1]].map(multirate::vector);
            (1..=PARTS).map(move |part| {
                let share = f64::from(part) / f64::from(PARTS);
                multirate::temperatures(&(from + (to - from) * share))
            })
        };
        let distance = |t: &Temperatures| {
            let viscosity = self.mobility.fluid.viscosity(t.film);
            self.correction.distance(viscosity)
        };
        let places = way.windows(2).flat_map(between);
        places.filter(|t| distance(t) > CLOSEST).max_by(|one, other| distance(one).total_cmp(&distance(other)))
    }
}

impl Stand {
    /// How far flows are from those that were expected, as a share of the heat.
    fn surprise(&self, expected: &Flows, flows: &Flows, at: &Temperatures) -> f64 {
        let oil = &self.fluid;
        let carried = |flows: &Flows| {
            let heat = oil.density(at.film) * oil.heat_capacity(at.film) * (at.film - at.oil);
            self.thermal.fresh_oil * flows.side_flow * heat
        };
        let change = (flows.viscous - expected.viscous).abs()
            + (flows.boundary - expected.boundary).abs()
            + (carried(flows) - carried(expected)).abs();
        change / flows.heat()
    }
}

/// A share of the heat, from its value at a relative tolerance of one.
pub fn share(at_one: f64, stand: &Stand) -> f64 {
    (at_one * stand.solver.tolerance).clamp(LEAST, MOST)
}
