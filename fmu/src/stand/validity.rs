//! Limits of the stand's laws: beyond them a run goes on, and `status.validity` and the log say so.

use super::{Stand, State};
use crate::{
    bearing::{Feeding, FilmModel, Press, Situation, Strain},
    multirate::Departure,
    sensors::Worst,
    thermal::Temperatures,
};
use fmu_export::model::{Fault, Log};
use journal_bearing::{
    contact::{Contact, f_5_2},
    mobility::FINEST,
};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// The log category.
pub const VALIDITY: &str = "validity";

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
const OFF_TABLE: i32 = 64;
const ALL_AROUND: i32 = 128;

/// A film of a smallest gap `h` lies in an angle of some `sqrt(2 h/c)`. Columns wider than half of that do not follow it: friction and
/// gap are then off by a tenth and more.
const COLUMNS_ACROSS: f64 = 2.0;

/// The mean planes may cross by so many roughnesses: beyond, hardly any height of the surfaces is left, and the tables end.
const HEIGHT: f64 = 3.0;

/// Asperities matter that carry this share of the load.
const TOUCHING: f64 = 0.01;

/// The mobility film's map ends at bearings that are so many diameters wide.
const WIDEST: f64 = 4.0;

/// The pressure of a contact over half of the bush, as the cosine of the angle, is this multiple of its resultant, the load.
/// A contact that presses more than that presses from the other side, too.
const WRAPPED: f64 = 1.0 / FRAC_PI_4;

/// The mean gap of rough surfaces is a little above the distance of their mean planes. In the centre it exceeds the clearance
/// by less than this part where only the tails of the roughness touch.
const WIDER: f64 = 1e-3;

/// What the limits are about at one instant: that of the latest evaluation of the rates, which writes it in place. After a step that is
/// taken it is its end.
#[derive(Clone, Copy, Debug, Default)]
pub struct SeenByLimits {
    /// Its time within the step, s.
    pub tau: Option<f64>,
    /// The film's situation.
    pub at: Situation,
    /// The temperatures.
    pub temperatures: Temperatures,
    /// How film and asperities press.
    pub press: Press,
}

/// Limits that are passed: their bits, and for each of them when and how it was passed first.
#[derive(Clone, Debug, Default)]
pub struct Passing {
    bits: i32,
    said: Vec<(i32, f64, String)>,
}

/// Says how a limit is passed, where it is.
type Passed = fn(&Stand, &SeenByLimits, &Strain) -> Option<String>;

/// The limits: the bit of each, and what says how it is passed.
pub static LIMITS: [(i32, Passed); 8] = [
    (TURBULENT, Stand::turbulent),
    (OIL, Stand::beyond_the_oil),
    (PRESSURE, Stand::overpressed),
    (LEVER, Stand::lifted),
    (CONTACT, Stand::beyond_contact),
    (COARSE, Stand::coarse),
    (OFF_TABLE, Stand::off_the_table),
    (ALL_AROUND, Stand::touches_all_around),
];

impl Stand {
    /// The limits that have been passed since the start, as a sum of bits.
    pub fn validity(&self) -> i32 {
        self.state.validity
    }

    /// The limits that are passed so far, none of them in this step.
    pub(super) fn passing(&self) -> Passing {
        Passing { bits: self.state.validity, said: Vec::new() }
    }

    /// Looks for limits that are passed at an instant and were not before. Returns what counts in a check of the operation.
    pub(super) fn look_at(&self, seen: &SeenByLimits, time: f64, passing: &mut Passing) -> Worst {
        let strain = self.film.strain(&self.bearing, &seen.at, &seen.press);
        let suspects = self.suspects(seen, &strain) & !passing.bits;
        if suspects != 0 {
            for (bit, passed) in LIMITS.iter().filter(|(bit, _)| suspects & bit != 0) {
                if let Some(how) = passed(self, seen, &strain) {
                    passing.bits |= bit;
                    passing.said.push((*bit, time, how));
                }
            }
        }
        self.worst(seen, strain.min_film_thickness)
    }

    /// The limits that may be passed at an instant: all that are, and few that are not. Every internal step of the mobility film
    /// asks, so it takes no powers and makes no text.
    #[inline]
    pub fn suspects(&self, seen: &SeenByLimits, strain: &Strain) -> i32 {
        /// Oil of the density's law, `exp(-x (1 + 0.8 x))`, is at most so many times as dense as at 15 degC.
        const DENSEST: f64 = 1.37;
        /// `F_5/2` of asperities whose mean planes have not crossed is at most this.
        const UNCROSSED: f64 = 0.617;
        if self.film.is_transient() {
            return !0;
        }
        let SeenByLimits { at, temperatures, .. } = seen;
        let (surface, load) = (&self.bearing.surface, at.load_magnitude());
        let Contact { force, normal } = strain.contact;
        let asperities = if normal > 0.0 { UNCROSSED * surface.pressure_scale() } else { 0.0 };
        let finest = surface.roughness / at.clearance < FINEST;
        let wide = strain.min_film_thickness > (1.0 + WIDER) * at.clearance;
        let [number, limit] = self.reynolds_number(at, DENSEST * self.fluid.density_15);
        let suspects = [
            (TURBULENT, number > limit),
            (OIL, temperatures.array().into_iter().any(|temperature| !self.fluid.holds(temperature))),
            (PRESSURE, strain.most_film_pressure() + asperities > self.bearing.pressure_limit || strain.distance < 0.0),
            (LEVER, self.load.least_force(at.speed) < 0.0),
            (CONTACT, strain.contact_reach > HEIGHT || finest && force > TOUCHING * load),
            (OFF_TABLE, self.bearing.width > WIDEST * self.bearing.diameter),
            (ALL_AROUND, normal > WRAPPED * load || wide && normal > TOUCHING * load),
        ];
        suspects.into_iter().map(|(bit, suspect)| bit * i32::from(suspect)).sum()
    }

    /// Takes over the limits that a part of a step has passed.
    pub(super) fn pass(&mut self, passing: Passing) {
        self.state.validity |= passing.bits;
        self.passed.said.extend(passing.said);
    }

    /// Looks for limits that are passed in the present state. Returns what counts in a check of the operation.
    pub(super) fn look(&mut self) -> Worst {
        let y = super::unknowns(&self.state);
        let mut seen = SeenByLimits::default();
        self.course_with(0.0, &y, self.fluid.viscosity(self.state.temperatures.film), &mut seen);
        let mut passing = self.passing();
        let worst = self.look_at(&seen, self.state.time, &mut passing);
        self.pass(passing);
        worst
    }

    /// Looks for limits that are passed along a leap, whose steps begin at these temperatures and wear depths: in a turn where the
    /// film is warmest and in one where it is coldest. The turns before and after the leap are resolved anyway.
    pub(super) fn look_along(&mut self, way: &[(Temperatures, f64)], landing: &Departure) -> Result<(), Fault> {
        /// Differences of the film's temperature that change no limit, K.
        const CLOSE: f64 = 0.1;
        let film = |at: &&(Temperatures, f64)| at.0.film;
        let ends = [self.state.temperatures.film, landing.temperatures.film];
        let [low, high] = [ends[0].min(ends[1]) - CLOSE, ends[0].max(ends[1]) + CLOSE];
        let coldest = way.iter().min_by(|a, b| film(a).total_cmp(&film(b))).filter(|at| at.0.film < low);
        let warmest = way.iter().max_by(|a, b| film(a).total_cmp(&film(b))).filter(|at| at.0.film > high);
        for (temperatures, worn) in coldest.into_iter().chain(warmest) {
            let mut there = self.clone();
            there.state = State { temperatures: *temperatures, worn: *worn, ..self.state };
            there.state.eccentricity = landing.eccentricity;
            // The first turn finds the orbit.
            there.resolve(there.cycle())?;
            there.state.validity = self.state.validity;
            there.passed = self.passed.clone();
            there.resolve(there.cycle())?;
            self.state.validity = there.state.validity;
            self.passed = there.passed;
        }
        Ok(())
    }

    /// Logs the limits that were passed for the first time.
    pub(super) fn tell(&mut self, log: &mut dyn Log) {
        let mut told = 0;
        for (bit, time, how) in std::mem::take(&mut self.passed).said {
            // A try that was given up may have told one that the run does not pass, or passes again.
            if self.state.validity & bit & !told != 0 {
                told |= bit;
                log.log(VALIDITY, format_args!("at {time:?} s: {how}"));
            }
        }
    }

    pub(super) fn turbulent(&self, seen: &SeenByLimits, _: &Strain) -> Option<String> {
        let [number, limit] = self.reynolds_number(&seen.at, self.fluid.density(seen.temperatures.film));
        (number > limit).then(|| {
            format!("the film's Reynolds number {number:.0} is beyond {limit:.0}: it is not laminar, and its friction is larger")
        })
    }

    /// The film's Reynolds number with oil of this density, kg/m³, and where it ends to be laminar.
    #[inline]
    fn reynolds_number(&self, at: &Situation, density: f64) -> [f64; 2] {
        let Situation { clearance, viscosity, .. } = *at;
        let radius = self.bearing.radius();
        let number = density * at.sliding().abs() * radius * clearance / viscosity;
        [number, REYNOLDS.min(TAYLOR * (radius / clearance).sqrt())]
    }

    fn beyond_the_oil(&self, seen: &SeenByLimits, _: &Strain) -> Option<String> {
        let supply = &self.bearing.supply;
        let fed = supply.feeds().then_some(supply.temperature);
        let all = seen.temperatures.array().into_iter();
        let all = all.chain(self.film.hottest()).chain(fed);
        let mut beyond = all.filter_map(|temperature| Some((temperature, self.fluid.beyond(temperature)?)));
        let (temperature, why) = beyond.next()?;
        Some(format!("a temperature of {temperature:.1} K is beyond the oil's data: {why}"))
    }

    /// The asperities press where the film is thinnest, and the film's largest pressure is close to that place: the surfaces bear
    /// both.
    fn overpressed(&self, _: &SeenByLimits, strain: &Strain) -> Option<String> {
        let (film, limit) = (strain.film_pressure(), self.bearing.pressure_limit);
        let asperities = if strain.contact.normal > 0.0 {
            let surface = &self.bearing.surface;
            surface.pressure_scale() * f_5_2(strain.distance / surface.roughness).0
        } else {
            0.0
        };
        let pressure = film + asperities;
        (pressure > limit).then(|| {
            format!(
                "a pressure of {pressure:.3e} Pa ({film:.3e} Pa of the film, {asperities:.3e} Pa of asperities) is beyond \
                 bearing.pressureLimit, {limit:.3e} Pa"
            )
        })
    }

    fn beyond_contact(&self, seen: &SeenByLimits, strain: &Strain) -> Option<String> {
        let reach = strain.contact_reach;
        let roughness = self.bearing.surface.roughness / seen.at.clearance;
        let map = self.film.columns().is_none() && self.touches(seen, strain);
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

    /// Whether asperities bear a share of the load that matters.
    fn touches(&self, seen: &SeenByLimits, strain: &Strain) -> bool {
        strain.contact.force > TOUCHING * seen.at.load_magnitude()
    }

    fn coarse(&self, seen: &SeenByLimits, strain: &Strain) -> Option<String> {
        let columns = self.film.columns()?;
        let gap = strain.min_film_thickness;
        let angle = (2.0 * gap / seen.at.clearance).sqrt();
        let needed = (TAU * COLUMNS_ACROSS / angle).ceil();
        (columns as f64 <= needed).then(|| {
            format!(
                "a film of {gap:.3e} m is thinner than {columns} columns follow: gap and friction are only rough; take {needed:.0} \
                 or more (bearing.filmColumns)"
            )
        })
    }

    fn lifted(&self, seen: &SeenByLimits, _: &Strain) -> Option<String> {
        let force = self.load.least_force(seen.at.speed);
        (force < 0.0).then(|| format!("the lever would have to pull with {:.0} N, so it lifts off once a turn", -force))
    }

    /// What lies outside of a film's map, grid or law.
    fn off_the_table(&self, seen: &SeenByLimits, strain: &Strain) -> Option<String> {
        let wide = self.bearing.width / self.bearing.diameter;
        if self.film.model == FilmModel::Mobility {
            return (wide > WIDEST).then(|| {
                format!(
                    "the bearing is {wide:.3} diameters wide, and the mobility film's map ends at {WIDEST}: it is taken as that wide; \
                     set bearing.film = Reynolds"
                )
            });
        }
        if self.bearing.resolution.rows == 1 {
            return Some(
                "one row of cells does not follow the pressure over the width: set bearing.filmRows = 0, or more"
                    .to_owned(),
            );
        }
        let pressure = strain.film_pressure();
        if self.oil.thickening.ends_below(seen.at.viscosity, pressure) {
            return Some(format!(
                "a film pressure of {pressure:.3e} Pa is beyond the end of oil.pressureLaw, where the viscosity has risen by e^5: it \
                 rises no further"
            ));
        }
        (self.touches(seen, strain) && self.touches_a_feed(seen))
            .then(|| "asperities touch where a feed is: contact counts its surface as whole".to_owned())
    }

    /// Whether the arc over which asperities can touch reaches a feed.
    fn touches_a_feed(&self, seen: &SeenByLimits) -> bool {
        let supply = &self.bearing.supply;
        match supply.feed {
            Feeding::None => return false,
            Feeding::CircumferentialGroove => return true,
            Feeding::AxialGrooves | Feeding::Hole => {}
        }
        let [x, y] = seen.at.eccentricity;
        let open = 1.0 - HEIGHT * self.bearing.surface.roughness / seen.at.clearance;
        let arc = (open / x.hypot(y)).clamp(-1.0, 1.0).acos();
        let middle = y.atan2(x);
        (0..supply.count).any(|k| {
            let feed = supply.angle + TAU * f64::from(k) / f64::from(supply.count);
            let apart = (feed - middle + PI).rem_euclid(TAU) - PI;
            apart.abs() < arc + 0.5 * supply.extent
        })
    }

    fn touches_all_around(&self, seen: &SeenByLimits, strain: &Strain) -> Option<String> {
        let load = seen.at.load_magnitude();
        let normal = strain.contact.normal;
        if normal > WRAPPED * load {
            return Some(format!(
                "asperities press with {normal:.3e} N around the bush under a load of {load:.3e} N: they touch all around, and friction is \
                 beyond the dry limit; roughness and clearance do not fit together"
            ));
        }
        let (gap, clearance) = (strain.min_film_thickness, seen.at.clearance);
        (normal > TOUCHING * load && gap > (1.0 + WIDER) * clearance).then(|| {
            format!("the smallest mean gap, {gap:.3e} m, exceeds the clearance of {clearance:.3e} m: the surfaces touch all around")
        })
    }
}
