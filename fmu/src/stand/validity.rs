//! Limits of the stand's laws: beyond them a run goes on, and `status.validity` and the log say so.

use super::Stand;
use fmu_export::model::Log;
use journal_bearing::mobility::FINEST;
use std::f64::consts::TAU;

/// The log category.
pub(super) const VALIDITY: &str = "validity";

/// The laminar film ends at this Reynolds number over the root of R/c: the root of 1,708, the Taylor number at which vortices begin
/// in a narrow gap between concentric cylinders (Taylor 1923, Phil. Trans. R. Soc. A 223, 289-343),
const TAYLOR: f64 = 41.3;
/// and in narrower gaps, before vortices begin, at about this Reynolds number: a usual figure, no sharp limit.
const REYNOLDS: f64 = 2000.0;

/// Bits of `status.validity`.
const TURBULENT: i32 = 1;
const OIL: i32 = 2;
const PRESSURE: i32 = 4;
const LEVER: i32 = 8;
const CONTACT: i32 = 16;
const COARSE: i32 = 32;

/// A film of a smallest gap `h` lies in an angle of some `sqrt(2 h/c)`. Columns wider than half of that do not follow it: friction and
/// gap are then off by a tenth and more.
const COLUMNS_ACROSS: f64 = 2.0;

/// The mean planes may cross by so many roughnesses: beyond, hardly any height of the surfaces is left, and the tables end.
const HEIGHT: f64 = 3.0;

/// Asperities matter that carry this share of the load.
const TOUCHING: f64 = 0.01;

/// Says how a limit is passed, where it is.
type Passed = fn(&Stand) -> Option<String>;

impl Stand {
    /// The limits that have been passed since the start, as a sum of bits.
    pub fn validity(&self) -> i32 {
        self.state.validity
    }

    /// Sets the bits of the limits that are passed now, and logs each that was not passed before.
    pub(super) fn check_validity(&mut self, log: &mut dyn Log) {
        let limits: [(i32, Passed); 6] = [
            (TURBULENT, Self::turbulent),
            (OIL, Self::beyond_the_oil),
            (PRESSURE, Self::overpressed),
            (LEVER, Self::lifted),
            (CONTACT, Self::beyond_contact),
            (COARSE, Self::coarse),
        ];
        for (bit, passed) in limits {
            if self.state.validity & bit != 0 {
                continue;
            }
            if let Some(passed) = passed(self) {
                self.state.validity |= bit;
                log.log(VALIDITY, format_args!("at {:?} s: {passed}", self.state.time));
            }
        }
    }

    fn turbulent(&self) -> Option<String> {
        let now = &self.readings;
        let (radius, clearance) = (self.bearing.radius(), now.hot_radial_clearance);
        let density = self.fluid.density(now.film_temperature);
        let number = density * now.shaft_speed.abs() * radius * clearance / now.film_viscosity;
        let limit = REYNOLDS.min(TAYLOR * (radius / clearance).sqrt());
        (number > limit).then(|| {
            format!("the film's Reynolds number {number:.0} is beyond {limit:.0}: it is not laminar, and its friction is larger")
        })
    }

    fn beyond_the_oil(&self) -> Option<String> {
        let supply = &self.bearing.supply;
        let fed = supply.feeds().then_some(supply.temperature);
        let all = self.state.temperatures.array().into_iter();
        let all = all.chain(self.film.hottest()).chain(fed);
        let mut beyond = all.filter_map(|temperature| Some((temperature, self.fluid.beyond(temperature)?)));
        let (temperature, why) = beyond.next()?;
        Some(format!("a temperature of {temperature:.1} K is beyond the oil's data: {why}"))
    }

    fn overpressed(&self) -> Option<String> {
        let (pressure, limit) = (self.readings.max_film_pressure, self.bearing.pressure_limit);
        (pressure > limit)
            .then(|| format!("a film pressure of {pressure:.3e} Pa is beyond bearing.pressureLimit, {limit:.3e} Pa"))
    }

    fn beyond_contact(&self) -> Option<String> {
        let reach = self.readings.contact_reach;
        let roughness = self.bearing.surface.roughness / self.readings.hot_radial_clearance;
        let map = self.film.columns().is_none() && self.readings.contact_share > TOUCHING;
        if map && roughness < FINEST {
            return Some(format!(
                "asperities touch whose roughness is {roughness:.2e} of the clearance, finer than the mobility film's table, which ends at \
                 {FINEST:.2e}: friction and gap may be a third off; set bearing.film = Reynolds"
            ));
        }
        (reach > HEIGHT).then(|| {
            format!(
                "the mean planes of journal and bush cross by {reach:.1} roughnesses, beyond the surfaces' own height of {HEIGHT:.0}: the surfaces' law ends there"
            )
        })
    }

    fn coarse(&self) -> Option<String> {
        let columns = self.film.columns()?;
        let gap = self.readings.min_film_thickness;
        let angle = (2.0 * gap / self.readings.hot_radial_clearance).sqrt();
        let needed = (TAU * COLUMNS_ACROSS / angle).ceil();
        (columns as f64 <= needed).then(|| {
            format!(
                "a film of {gap:.3e} m is thinner than {columns} columns follow: gap and friction are only rough; take {needed:.0} \
                 or more (bearing.filmColumns)"
            )
        })
    }

    fn lifted(&self) -> Option<String> {
        let force = self.load.least_force(self.readings.shaft_speed);
        (force < 0.0).then(|| format!("the lever would have to pull with {:.0} N, so it lifts off once a turn", -force))
    }
}
