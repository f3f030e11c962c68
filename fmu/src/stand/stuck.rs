//! Reasons why a step failed: which unknown changes too fast, and which parameter makes it so.

use super::{SCALES, Stand, Unknowns, temperatures, validity::SeenByLimits, worn};
use crate::{oil::Nearby, solver::Failure};
use fmu_export::model::{Fault, Kind, Model, Quantity};
use std::ops::Range;

/// A parameter or input that explains the failure by itself.
struct Cause {
    name: &'static str,
    value: f64,
    default: f64,
    unit: &'static str,
}

/// Which parameter to look at.
fn advise(cause: Option<Cause>) -> String {
    let Some(cause) = cause else {
        return "check the parameters that are far from their defaults".to_owned();
    };
    let Cause { name, value, default, unit } = cause;
    let unit = match unit {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    format!("check {name}: it is {value:?}{unit}, by default {default:?}{unit}")
}

/// The point at which the step failed: the time into it, s, the unknowns, and the range of unknowns that were integrated.
struct FailedPlace {
    tau: f64,
    y: Unknowns,
    among: Range<usize>,
}

/// A parameter counts as the cause if its default makes the fastest unknown slower by this factor.
const TELLING: f64 = 3.0;

impl Stand {
    /// Refuses an oil that gets thicker as it warms, and a start at which it would be solid or below absolute zero.
    pub(super) fn check_oil(&self) -> Result<(), Fault> {
        /// More viscous than pitch, Pa.s.
        const SOLID: f64 = 1e6;
        let [cold, hot] = [self.oil.kinematic_viscosity_40, self.oil.kinematic_viscosity_100];
        if self.oil.properties_file.is_empty() && hot > cold {
            return Err(Fault::Invalid(format!(
                "oil.kinematicViscosity100 = {hot:?} m2/s: it must not be greater than oil.kinematicViscosity40, \
                 {cold:?} m2/s"
            )));
        }
        let initial = self.thermal.initial();
        for (what, start, rise) in
            [("film", initial.film, "thermal.initialFilmRise"), ("shaft", initial.shaft, "thermal.initialShaftRise")]
        {
            if start <= 0.0 {
                return Err(Fault::Invalid(format!(
                    "the {what} would start at {start:?} K, which is not above absolute zero: raise \
                     thermal.initialBearingTemperature or {rise}"
                )));
            }
        }
        let start = initial.film;
        let viscosity = self.fluid.viscosity(start);
        if viscosity.is_nan() || viscosity > SOLID {
            return Err(Fault::Invalid(format!(
                "the film would start at {start:?} K, where the oil's viscosity is {viscosity:.1e} Pa.s: raise \
                 thermal.initialBearingTemperature or thermal.initialFilmRise"
            )));
        }
        Ok(())
    }

    /// A failure at unknowns `y`, of which those in the range `among` were integrated, with its probable reason.
    pub(super) fn explain(&self, failure: Failure, y: &Unknowns, among: Range<usize>) -> Fault {
        if let Some(seizure) = self.seizure(&temperatures(y), worn(y)) {
            return seizure;
        }
        if let Failure::SpanTooLong { .. } = failure {
            return Fault::Failed(failure.to_string());
        }
        let at = FailedPlace { tau: failure.passed(), y: *y, among };
        let fastest = self.fastest(&at);
        let pace = fastest.map_or(f64::INFINITY, |(_, pace)| pace);
        let reason = match fastest {
            Some((name, _)) => format!("{name} settles within {:.1e} s, faster than in any bearing", 1.0 / pace),
            None => "the state's rates are not finite".to_owned(),
        };
        let (film, viscosity) = (y[2], self.fluid.viscosity(y[2]));
        let advice = advise(self.cause(&at, pace).or_else(|| self.oddest()));
        Fault::Failed(format!("{failure}: {reason} (film at {film:.1} K with {viscosity:.2e} Pa.s); {advice}"))
    }

    /// The unknown that settles fastest after a small disturbance, and its rate, 1/s; none if that is not finite.
    fn fastest(&self, at: &FailedPlace) -> Option<(&'static str, f64)> {
        const NAMES: [&str; 7] = [
            "the journal",
            "the journal",
            "the film's temperature",
            "the bush's temperature",
            "the shaft's temperature",
            "the oil bath's temperature",
            "the wear depth",
        ];
        const NUDGE: f64 = 1e-7;
        let (mut oil, mut seen) = (Nearby::default(), SeenByLimits::default());
        let (here, _) = self.course_at(at.tau, &at.y, &mut oil, &mut seen);
        let mut fastest = ("nothing", 0.0_f64);
        for i in at.among.clone() {
            let mut nudged = at.y;
            nudged[i] += NUDGE * SCALES[i];
            let (there, _) = self.course_at(at.tau, &nudged, &mut oil, &mut seen);
            let pace = ((there[i] - here[i]) / (nudged[i] - at.y[i])).abs();
            if !pace.is_finite() {
                return None;
            }
            if pace > fastest.1 {
                fastest = (NAMES[i], pace);
            }
        }
        Some(fastest)
    }

    /// The parameter or input whose default would slow the fastest unknown down most.
    fn cause(&self, at: &FailedPlace, pace: f64) -> Option<Cause> {
        let mut slowest = pace / TELLING;
        let mut culprit = None;
        for (cause, set) in self.changed() {
            let mut other = self.clone();
            set(&mut other, &cause.default);
            let anew = other.prepared_anew();
            let Some((_, pace)) = anew.and_then(|other| other.fastest(at)) else {
                continue;
            };
            if pace < slowest {
                slowest = pace;
                culprit = Some(cause);
            }
        }
        culprit
    }

    /// Which parameter or input to look at, where nothing more is known.
    pub(super) fn advice(&self) -> String {
        advise(self.oddest())
    }

    /// The parameter or input that differs from its default by the largest factor.
    fn oddest(&self) -> Option<Cause> {
        let far = |cause: &Cause| (cause.value / cause.default).ln().abs();
        self.changed()
            .map(|(cause, _)| cause)
            .filter(|cause| far(cause).is_finite())
            .max_by(|one, other| far(one).total_cmp(&far(other)))
    }

    /// Parameters and inputs that are not at their defaults, and how to set them.
    fn changed(&self) -> impl Iterator<Item = (Cause, fn(&mut Self, &f64))> {
        let usual = Self::default();
        Self::variables().iter().filter_map(move |variable| {
            let Kind::Real(Quantity { access, unit, .. }) = &variable.kind else {
                return None;
            };
            let cause = Cause {
                name: variable.name,
                value: (access.get)(self),
                default: (access.get)(&usual),
                unit: unit.name,
            };
            (cause.value != cause.default).then_some((cause, access.set?))
        })
    }

    /// Recomputes what follows from the parameters. An oil from a file stays as it was.
    fn prepared_anew(mut self) -> Option<Self> {
        if self.oil.properties_file.is_empty() {
            self.fluid = self.oil.through_two_points();
        }
        self.film.prepare(&self.bearing).ok()?;
        Some(self)
    }
}
