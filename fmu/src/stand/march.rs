//! Communication steps: turn by turn, or with a leap over whole turns, in whole [cycles](super::cycle).

use super::{
    EVENTS, SCALES, Stand, State, Unknowns,
    inputs::INPUTS,
    scout::Turn,
    temperatures, unknowns,
    validity::{Passing, SeenByLimits},
    worn,
};
use crate::{
    Result,
    bearing::{FilmEnergy, Flows, Interval, Passed},
    multirate::{self, Departure, NoLeap, TwoScales},
    oil::Nearby,
    sensors::{SENSORS, Sensed, TurnMeans},
    solver::{Budget, DormandPrince, Passage},
    thermal::Temperatures,
};
use fmu_export::model::{Fault, Log};
use journal_bearing::reynolds::{HeatExchange, HeatGiven};
use std::cell::RefCell;

/// Cycles that are resolved after a leap.
const CYCLES_AT_THE_END: usize = 1;
/// Factor on the solver's tolerance in the turns before a leap, of which only their heat matters later.
const SETTLING_SLACK: f64 = 1000.0;
/// Factor on the solver's tolerance in the turns after a leap, whose start is not known any better.
const LANDING_SLACK: f64 = 10.0;
/// Factors loosen the tolerance up to this value.
const LOOSEST: f64 = 1e-3;
/// Least number of steps of a transient film in a turn: load and speed vary linearly within one.
const FILM_STEPS_PER_TURN: f64 = 100.0;
/// The steps in the turns that lead a leap are longer by this factor. It changes their heat by 5e-5 and the journal's place by
/// 3e-5 of the clearance (the rig, and Table 3).
const ROUGH_STEPS: f64 = 3.0;
/// The longest step of a transient film, s.
const LONGEST_FILM_STEP: f64 = 2e-3;
/// In a shorter step, s, rounding moves a journal more than the film does: nothing changes but time, angle and inputs.
const SHORTEST_FILM_STEP: f64 = 1e-13;
/// Internal steps that may be taken before any time has passed. The rig takes some tens to get going.
const STEPS_AT_ONCE: usize = 30_000;
/// Further internal steps per second and per turn. The rig takes some 60 a turn.
const STEPS_PER_SECOND: f64 = 1e6;
const STEPS_PER_TURN: f64 = 1e3;
/// Internal steps in one communication step at most: some minutes of work.
const MOST_STEPS: f64 = 5e7;
/// Most steps of a transient film in one communication step: some hours.
const MOST_FILM_STEPS: f64 = 1e7;
/// A transient film's internal steps that may be taken at once, and further ones per step; ordinary steps need a few.
const FILM_STEPS_AT_ONCE: usize = 5_000;
const FILM_STEPS_PER_STEP: usize = 50;
/// Most steps of the temperatures within one of a transient film.
const WARMING_STEPS: usize = 5_000;

/// The unknowns, the inputs' values, the shaft's angle and, where the rates depend on it, the time.
type RatesPlace = (Unknowns, [f64; INPUTS], [f64; 2]);

/// The rates where the last step ended: the last stage that it took is the first one of the next step.
#[derive(Debug)]
pub struct Arrival {
    at: RatesPlace,
    rates: (Unknowns, Sensed),
}

impl Stand {
    /// Lets `span` seconds pass with every turn resolved.
    pub(super) fn resolve(&mut self, span: f64) -> Result {
        self.resolve_within(1.0, span)
    }

    /// Lets `span` seconds pass at `slack` times the solver's tolerance.
    fn resolve_within(&mut self, slack: f64, span: f64) -> Result {
        let slack = slack.min(LOOSEST / self.solver.tolerance).max(1.0);
        if self.film.is_transient() {
            return self.resolve_transient(span, 1.0).map(|_| ());
        }
        let integrator = DormandPrince {
            allowed: SCALES.map(|scale| slack * self.solver.tolerance * scale),
            budget: Budget {
                at_once: STEPS_AT_ONCE,
                per_second: STEPS_PER_SECOND + STEPS_PER_TURN / self.turn(),
                most: MOST_STEPS,
            },
        };
        let mut y = unknowns(&self.state);
        let mut next_step = self.state.next_step;
        let mut oil = self.nearby;
        let known = self.arrival.0.take();
        let known = known.filter(|known| known.at == self.place());
        let mut last = (f64::NAN, <(Unknowns, Sensed)>::default());
        // The last stage of a step that is taken is at its end.
        let seen = &RefCell::new(SeenByLimits::default());
        let course = |tau: f64, y: &Unknowns, rates: &mut Unknowns, sensed: &mut Sensed| {
            (*rates, *sensed) = match &known {
                Some(known) if tau == 0.0 => known.rates,
                _ => self.course_at(tau, y, &mut oil, &mut seen.borrow_mut()),
            };
            last.0 = tau;
            if tau == span {
                last.1 = (*rates, *sensed);
            }
        };
        let (mut means, mut passing) = (self.state.means, self.passing());
        let mut observe = self.observing(&mut means, &mut passing);
        let watch = move |passage: &Passage<SENSORS>| observe(passage, &seen.borrow());
        let done = integrator.integrate_observed(course, &mut y, [], span, &mut next_step, watch);
        let arrived = done.is_ok() && last.0 == span;
        if let Err(failure) = done {
            (means, passing) = (self.state.means, self.passing());
            let observe = self.observing(&mut means, &mut passing);
            let anew = self.resolve_stiffly(span, &integrator.allowed, observe);
            y = anew.map_err(|_| self.explain(failure, &y, 0..7))?;
        }
        self.nearby = oil;
        self.state.means = means;
        self.pass(passing);
        // The step size is proportional to the fifth root of the allowed error.
        self.state.next_step = next_step * slack.powf(-0.2);
        self.state.worn = worn(&y);
        self.arrive(span, [y[0], y[1]], temperatures(&y));
        if arrived {
            let (at, rates) = (self.place(), last.1);
            self.arrival.0 = Some(Arrival { at, rates });
        }
        self.check_clearance()
    }

    /// All that the rates follow from besides the parameters.
    fn place(&self) -> RatesPlace {
        let State { angle, time, .. } = self.state;
        let time = if self.drive.fluctuates() { time } else { 0.0 };
        let inputs = self.inputs.all().map(|input| input.value);
        (unknowns(&self.state), inputs, [angle, time])
    }

    /// Takes the parts of the way from the present state over into the means, and the limits that are passed at their ends.
    fn observing<'a>(
        &'a self,
        means: &'a mut TurnMeans,
        passing: &'a mut Passing,
    ) -> impl FnMut(&Passage<SENSORS>, &SeenByLimits) + 'a {
        let command = self.command();
        let mut before = 0.0;
        move |passage, seen| {
            let turned = self.drive.turned(&command, passage.to);
            means.add(passage, turned - before);
            before = turned;
            means.notice(self.look_at(seen, self.state.time + passage.to, passing));
        }
    }

    /// Lets a cycle pass with a transient film, in longer steps than those of other cycles: its mean heat hardly depends on them.
    pub(super) fn resolve_cycle(&mut self) -> Result<Turn> {
        self.resolve_transient(self.cycle(), ROUGH_STEPS)
    }

    /// Lets `span` seconds pass with a transient film, in steps that are `longer` by a factor: in each of them first the film
    /// advances, then the temperatures. Returns means over the span.
    fn resolve_transient(&mut self, span: f64, longer: f64) -> Result<Turn> {
        if span < SHORTEST_FILM_STEP {
            self.arrive(span, self.state.eccentricity, self.state.temperatures);
            return Ok(Turn::default());
        }
        let steps = self.film_steps(span, longer);
        if steps > MOST_FILM_STEPS {
            return Err(Fault::Failed(format!(
                "some {steps:.0e} steps of the Reynolds film would be needed: take shorter communication steps"
            )));
        }
        let step = span / steps;
        let mut spare = FILM_STEPS_AT_ONCE;
        let mut oil = self.nearby;
        let mut before = self.sense(&mut oil);
        let mut mean = Turn::default();
        for done in 0..steps as usize {
            let load = [0.0, step].map(|tau| self.driven(tau).1);
            let speed = self.drive.speed(&self.command(), 0.5 * step);
            let viscosity = self.fluid.viscosity(self.state.temperatures.film);
            let interval = Interval {
                duration: step,
                load,
                speed,
                bush_speed: self.inputs.bush_speed.at(0.5 * step),
                clearance: self.clearance(&self.state.temperatures, self.state.worn),
                viscosity,
            };
            let viscosity = |temperature: f64| self.fluid.viscosity(temperature);
            let exchange = self.has_warm_film().then(|| self.exchange(interval.clearance, &viscosity));
            let film = self.film.transient();
            let film = film.expect("only a transient film takes steps of its own");
            let Passed { flows, steps: taken, warm } = film.advance(&self.bearing, &interval, exchange.as_ref())?;
            let eccentricity = film.eccentricity();
            spare = (spare + FILM_STEPS_PER_STEP).checked_sub(taken).ok_or_else(|| {
                let passed = done as f64 * step;
                Fault::Failed(format!(
                    "the Reynolds film's internal step collapsed after {passed:.1e} of {span:?} s; {}",
                    self.advice()
                ))
            })?;
            mean.add(&flows, self.state.temperatures.film, 1.0 / steps);
            let temperatures = match warm {
                Some((given, film)) => self.warm_beside(step, &flows, &given, film)?,
                None => self.warm(step, &flows)?,
            };
            self.state.worn += step * self.bearing.wear_rate(flows.boundary, speed - interval.bush_speed);
            let angle = self.state.angle;
            self.arrive(step, eccentricity, temperatures);
            self.check_clearance()?;
            let now = self.sense(&mut oil);
            let part = Passage::between(0.0, step, [before, now]);
            self.state.means.add(&part, self.state.angle - angle);
            before = now;
            let worst = self.look();
            self.state.means.notice(worst);
        }
        self.nearby = oil;
        Ok(mean)
    }

    /// The number of steps of a transient film in `span` seconds, `longer` by a factor than they should be.
    fn film_steps(&self, span: f64, longer: f64) -> f64 {
        (span / (longer * self.longest_film_step())).ceil().max(1.0)
    }

    fn longest_film_step(&self) -> f64 {
        LONGEST_FILM_STEP.min(self.turn() / FILM_STEPS_PER_TURN)
    }

    /// The first inner step of a communication step of `span` seconds, s: one of the film or of the time integration. Where that
    /// takes tiny steps, some of them are one: each inner step may take as much work as a communication step. A leap passes over
    /// its turns, so that there is nothing to see within it.
    pub(super) fn inner_step(&self, span: f64) -> f64 {
        if self.is_long(span) && self.hindrance().is_none() {
            span
        } else if self.film.is_transient() {
            span / self.film_steps(span, 1.0)
        } else {
            self.state.next_step.max(self.longest_film_step())
        }
    }

    /// The present readings of the physical stand's sensors.
    fn sense(&self, oil: &mut Nearby) -> Sensed {
        self.course_at(0.0, &unknowns(&self.state), oil, &mut SeenByLimits::default()).1
    }

    /// The temperatures after `span` seconds under constant flows.
    fn warm(&self, span: f64, flows: &Flows) -> Result<Temperatures> {
        let integrator =
            DormandPrince { allowed: [100.0 * self.solver.tolerance; 4], budget: Budget::of(WARMING_STEPS) };
        let mut t = self.state.temperatures.array();
        let worn = self.state.worn;
        let rates = |tau: f64, t: &[f64; 4]| {
            let t = Temperatures::of(*t);
            let clearance = self.clearance(&t, worn);
            (self.thermal_rates(tau, &t, clearance, flows).array(), [])
        };
        let done = integrator.integrate_along(rates, &mut t, [], span, &mut span.clone());
        let [ex, ey] = self.state.eccentricity;
        let y = [ex, ey, t[0], t[1], t[2], t[3], worn];
        done.map_err(|failure| self.explain(failure, &y, 2..6))?;
        Ok(Temperatures::of(t))
    }

    /// Whether the film has a temperature around the bearing.
    pub(super) fn has_warm_film(&self) -> bool {
        let energy = self.bearing.resolution.energy;
        energy == FilmEnergy::Circumferential && !self.thermal.isothermal
    }

    /// Refuses a temperature around the bearing in a stand whose temperatures stay as they are.
    pub(super) fn check_energy(&self) -> Result {
        let around = self.bearing.resolution.energy == FilmEnergy::Circumferential;
        if around && self.thermal.isothermal {
            return Err(Fault::Invalid(
                "bearing.filmEnergy = Circumferential: an isothermal stand has no heat to carry around; set \
                 thermal.isothermal = false, or bearing.filmEnergy = Lumped"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// What a film with a temperature around the bearing exchanges heat with.
    fn exchange<'a>(&self, clearance: f64, viscosity: &'a dyn Fn(f64) -> f64) -> HeatExchange<'a> {
        let Temperatures { film, bush, shaft, oil } = self.state.temperatures;
        HeatExchange {
            bush,
            shaft,
            bath: oil,
            feed: self.bearing.supply.temperature,
            start: film,
            conductance: self.thermal.film_conductances(clearance),
            fresh: self.thermal.fresh_oil,
            capacity: self.fluid.density(film) * self.fluid.heat_capacity(film),
            viscosity,
        }
    }

    /// The temperatures after `span` seconds beside a film that gave this heat away and is now as warm as this, K. The surfaces
    /// change far more slowly than a step, so that its heat stays as it was at their temperatures before.
    fn warm_beside(&self, span: f64, flows: &Flows, given: &HeatGiven, film: f64) -> Result<Temperatures> {
        let before = self.state.temperatures;
        let clearance = self.clearance(&before, self.state.worn);
        let heat = self.heat_of(0.0, &before, clearance, flows);
        let given = [given.bush, given.shaft, given.bath];
        let rates = self.thermal.rates_beside(&before, &heat, given);
        let later = multirate::vector(&before) + multirate::vector(&rates) * span;
        Ok(Temperatures { film, ..multirate::temperatures(&later) })
    }

    /// Ends a part of the step: takes the unknowns over, and moves time, angle and inputs on by `span` seconds.
    pub(super) fn arrive(&mut self, span: f64, eccentricity: [f64; 2], temperatures: Temperatures) {
        self.state.angle += self.drive.turned(&self.command(), span);
        self.state.time += span;
        self.state.eccentricity = eccentricity;
        self.state.temperatures = temperatures;
        self.inputs.each(|input| input.value = input.at(span));
    }

    /// Lets `span` seconds pass with a leap over most of its cycles: cycles until the journal is near its orbit are
    /// resolved, then it leaps, and the last cycles are resolved. If there is no leap, the log says why, and all turns
    /// are resolved.
    pub(super) fn leap(&mut self, span: f64, log: &mut dyn Log) -> Result {
        if self.film.is_transient() {
            return self.leap_with_film(span, log);
        }
        let before = self.state;
        let cycle = self.cycle();
        let mut slack = 1.0;
        let mut left = (span / cycle) as usize;
        // One cycle shows how fast the journal comes to its orbit.
        let mut settling = 1;
        while left > CYCLES_AT_THE_END {
            let start = self.state.eccentricity;
            self.resolve_within(SETTLING_SLACK, cycle)?;
            left -= 1;
            settling -= 1;
            if settling > 0 || left <= CYCLES_AT_THE_END {
                continue;
            }
            let cycles = left - CYCLES_AT_THE_END;
            let from = Departure { before: start, ..self.state.departure() };
            let steady = self.check_swing();
            let mut way = Vec::new();
            let pass = |temperatures: Temperatures, worn: f64| way.push((temperatures, worn));
            match steady.and_then(|()| multirate::leap(self, self.solver.tolerance, cycles, from, pass)) {
                Ok(landing) => {
                    self.look_along(&way, &landing)?;
                    self.state.worn = landing.worn;
                    let span = cycles as f64 * cycle;
                    self.arrive(span, landing.eccentricity, landing.temperatures);
                    self.state.means.restart();
                    slack = LANDING_SLACK;
                }
                Err(NoLeap::Closed(at)) => {
                    self.state.temperatures = at;
                    self.check_clearance()?;
                }
                Err(NoLeap::Far(approach)) if approach < cycles as f64 => {
                    settling = approach.ceil() as usize;
                    continue;
                }
                Err(reason) => {
                    let turns = cycles * self.turns_of_a_cycle();
                    log.log(EVENTS, format_args!("no leap over {turns} turns, they are resolved: {reason}"));
                }
            }
            break;
        }
        self.resolve_within(slack, span - (self.state.time - before.time))
    }
}

impl TwoScales for Stand {
    fn period(&self) -> f64 {
        self.cycle()
    }

    fn turns(&self) -> usize {
        self.turns_of_a_cycle()
    }

    fn journal(&self, clearance: f64) -> impl Fn(f64, [f64; 2], f64) -> ([f64; 2], Flows) {
        let drift = self.film.drift_at(&self.bearing, clearance);
        let (felt, seen) = (self.feels_side_flow(), RefCell::new(SeenByLimits::default()));
        move |tau, eccentricity, viscosity| {
            let seen = &mut *seen.borrow_mut();
            self.instant(tau, eccentricity, viscosity, clearance, seen);
            let drift = drift(&seen.at, felt, &mut seen.press);
            (drift.velocity, drift.flows)
        }
    }

    fn viscosity(&self, film_temperature: f64) -> f64 {
        self.fluid.viscosity(film_temperature)
    }

    fn clearance(&self, temperatures: &Temperatures, worn: f64) -> f64 {
        self.clearance(temperatures, worn)
    }

    fn is_closed(&self, temperatures: &Temperatures, worn: f64) -> bool {
        self.seizure(temperatures, worn).is_some()
    }

    fn thermal_rates(&self, temperatures: &Temperatures, clearance: f64, flows: &Flows) -> Temperatures {
        self.thermal_rates(0.0, temperatures, clearance, flows)
    }

    fn wears(&self) -> bool {
        self.bearing.wear.coefficient > 0.0
    }

    fn wear_rate(&self, flows: &Flows) -> f64 {
        let sliding = self.inputs.speed.value - self.inputs.bush_speed.value;
        self.bearing.wear_rate(flows.boundary, sliding)
    }
}
