//! Runs one point after another on one instance of an FMU.
//!
//! A used instance is reset for the next point; where it cannot be, it is replaced. The first point on a used instance runs on
//! a fresh one too: an FMU that forgets to reset something is found out, and gets a fresh instance for every point from then on.

mod collector;
mod gauge;
mod resampled;
mod scene;
mod steps;
mod together;
mod watched;

use std::sync::Arc;

use crate::{
    failure::{Failure, Partial},
    notices::Notices,
    system,
    task::{Case, Probe},
};
use fmu_import::{Call, Called, EarlyEnd, Instance, Library, Warnings};
use scene::Scene;

/// Runs points, reusing the instance where the FMU can be reset.
#[derive(Debug)]
pub struct Runner {
    library: Arc<Library>,
    /// The case that is simulated.
    scene: Scene,
    /// The other cases of a point.
    others: Vec<Scene>,
    used: Option<Held>,
    /// Whether each point has an instance of its own.
    renews: bool,
    /// Whether a reused instance has been compared with a fresh one.
    trusted: bool,
    /// Whether the last point failed because the FMU refused an instance, such as for want of a licence.
    pub refused: bool,
    /// The instance of a simulation that failed, until another one is wanted.
    failed: Option<Held>,
    /// The FMU's remarks in the last simulation, beside its results.
    pub notices: Notices,
    /// The version of FMI that the binary says where that is an unusual one, once it was asked.
    version: Option<Option<String>>,
}

/// An instance.
#[derive(Debug)]
struct Held {
    instance: Instance,
    /// The warnings of its creation: every point on it has them, as it would have alone.
    born: Warnings,
    /// Whether another point ran on it before.
    reused: bool,
}

/// The instance of a simulation that is over: it is freed with this.
#[derive(Debug)]
pub struct Last(#[allow(dead_code)] Option<Held>);

impl Runner {
    /// A runner of points of these cases, with the first one chosen; none where there is no case.
    pub fn new(library: Arc<Library>, cases: &[Case]) -> Option<Box<Self>> {
        let mut scenes = cases.iter().zip(0..).map(|(case, number)| Scene::new(number, case.task.clone()));
        Some(Box::new(Self {
            used: None,
            failed: None,
            renews: false,
            // Where there can be one instance only, there is none to compare with.
            trusted: library.is_for_one_instance(),
            refused: false,
            library,
            scene: scenes.next()?,
            others: scenes.collect(),
            notices: Notices::default(),
            version: None,
        }))
    }

    /// Chooses the case that is simulated next, by its number.
    pub fn turn_to(&mut self, case: usize) {
        let mut others = self.others.iter_mut();
        if let Some(other) = others.find(|other| other.number == case) {
            std::mem::swap(&mut self.scene, other);
        }
    }

    /// Simulates one point on an instance of its own, which is ended only after `tell` has got the answer:
    /// what the FMU does at its end costs no result. The instance is freed when what is returned is dropped.
    pub fn alone(&mut self, values: &[f64], tell: impl FnOnce(&Self, Result<&[f64], &Failure>)) -> Last {
        let begun = self.allow(values).and_then(|()| self.prepared());
        let mut held = match begun {
            Ok(held) => held,
            Err(failure) => {
                tell(self, Err(&failure));
                return Last(None);
            }
        };
        let simulated = self.simulate(&mut held, values);
        let failed = simulated.is_err();
        let simulated = simulated.map_err(|call| Failure::from_call(&call));
        self.notices.held = system::held();
        match simulated.and_then(|()| self.finite()) {
            Ok(()) => tell(self, Ok(&self.scene.results)),
            Err(failure) => tell(self, Err(&failure)),
        }
        // The answer has been told; what becomes of the instance changes no result.
        if !failed {
            self.terminate(&mut held.instance);
            self.note_version();
        }
        Last(Some(held))
    }

    /// Ends a simulation; whether the FMU could.
    fn terminate(&mut self, instance: &mut Instance) -> bool {
        let ended = instance.terminate();
        if let Err(call) = &ended {
            self.notices.cannot_end(call);
        }
        ended.is_ok()
    }

    /// Notes the version of FMI that the binary says, where it is another than that of its description.
    fn note_version(&mut self) {
        let version = self.version.get_or_insert_with(|| self.library.odd_version());
        self.notices.version.clone_from(version);
    }

    /// Refuses values that the FMU's description does not allow.
    fn allow(&self, values: &[f64]) -> Result<(), Failure> {
        let varied = &self.scene.task.varied;
        assert_eq!(varied.len(), values.len(), "a point has a value of every varied parameter");
        let mut slots = varied.iter().zip(values).filter(|(slot, _)| !slot.idle);
        slots.try_for_each(|(slot, &value)| slot.check(value).map_err(Failure::OutOfRange))
    }

    /// Refuses results that are no numbers.
    fn finite(&self) -> Result<(), Failure> {
        match self.scene.results.iter().position(|value| !value.is_finite()) {
            Some(index) => {
                let mut variable = self.scene.task.observed[index].name.clone();
                variable += &self.scene.why_none(index).unwrap_or_default();
                if let Some(time) = self.notices.ended {
                    variable += &format!(" (the FMU ended the simulation at {time} s)");
                }
                let partial = Partial::new(&variable, &self.scene.results);
                Err(Failure::NotFinite(partial))
            }
            None => Ok(()),
        }
    }

    /// The results of the last simulation, if it succeeded.
    pub fn results(&self) -> &[f64] {
        &self.scene.results
    }

    /// Simulates one point. The values are in the FMU's units, one for each of
    /// [`Task::varied`]; so are the results, one for each of [`Task::observed`].
    ///
    /// # Errors
    /// When a value is not allowed, or the simulation fails.
    pub fn run(&mut self, values: &[f64]) -> Result<&[f64], Failure> {
        self.refused = false;
        self.notices = Notices::default();
        self.allow(values)?;
        let held = self.prepared()?;
        let compare = held.reused && !self.trusted;
        let outcome = self.once(held, values);
        if compare {
            self.compare(values, outcome)?;
        } else {
            outcome?;
        }
        self.finite()?;
        self.note_version();
        Ok(&self.scene.results)
    }

    /// Simulates a point on an instance, and keeps that.
    fn once(&mut self, mut held: Held, values: &[f64]) -> Result<(), Failure> {
        if let Err(call) = self.simulate(&mut held, values) {
            // It is not used again, and freed when its failure has been told: what loops then costs no answer.
            self.failed = Some(held);
            return Err(Failure::from_call(&call));
        }
        // The results stand, but an instance that cannot end properly is not used again.
        if self.terminate(&mut held.instance) {
            self.used = Some(held);
        }
        Ok(())
    }

    /// Simulates a point again on a fresh instance, whose results count.
    fn compare(&mut self, values: &[f64], reused: Result<(), Failure>) -> Result<(), Failure> {
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let before = reused.as_ref().map(|()| bits(&self.scene.results));
        if self.used.as_ref().is_some_and(|used| used.instance.is_dead()) {
            return reused;
        }
        self.used = None;
        let fresh = self.prepared().and_then(|held| self.once(held, values));
        let after = fresh.as_ref().map(|()| bits(&self.scene.results));
        if before != after {
            self.renews = true;
        }
        self.trusted = true;
        fresh
    }

    /// Simulates one point and lets `read` see the instance at every communication point. The instance is kept
    /// until [`end`](Self::end).
    ///
    /// # Errors
    /// As [`run`](Self::run), and where `read` fails.
    pub fn trajectory(
        &mut self,
        values: &[f64],
        mut read: impl FnMut(f64, &mut Instance) -> Called,
    ) -> Result<(), Failure> {
        self.allow(values)?;
        let mut held = self.prepared()?;
        held.instance.forget_warnings();
        let instance = &mut held.instance;
        let schedule = self.scene.task.schedule;
        let mut ended = None;
        let mut run = || -> Called {
            self.scene.start(instance, values)?;
            read(schedule.start, instance)?;
            let (points, mut time) = (schedule.points(), schedule.start);
            for index in 1..=points.steps {
                let next = points.at(index);
                if let Err(call) = self.scene.step(instance, [time, next]) {
                    // An end that the FMU chose is no failure; its last values count.
                    let end = call.ended.ok_or(call)?;
                    ended = Some(end.at);
                    return read(end.at, instance);
                }
                read(next, instance)?;
                time = next;
            }
            Ok(())
        };
        let result = run();
        self.notices = Notices { ended, ..Notices::default() };
        result.map_err(|call| Failure::from_call(&call))?;
        self.hear_warnings(&held);
        self.used = Some(held);
        Ok(())
    }

    /// Ends the instance of a trajectory that went to its end.
    pub fn end(&mut self) {
        if let Some(mut held) = self.used.take() {
            self.terminate(&mut held.instance);
        }
    }

    /// An instance in its initial state.
    fn prepared(&mut self) -> Result<Held, Failure> {
        self.failed = None;
        if let Some(mut used) = self.used.take() {
            if used.instance.is_dead() {
                return Err(Failure::Fatal("the FMU cannot go on in this process".to_owned()));
            }
            if !self.renews && used.instance.reset().is_ok() {
                used.reused = true;
                return Ok(used);
            }
            self.renews = true;
            // Before there is another one.
            drop(used);
        }
        let instance = Instance::new(&self.library, "point");
        self.refused = instance.is_err();
        let instance = instance.map_err(|call| Failure::from_call(&call))?;
        Ok(Held { born: instance.warnings(), instance, reused: false })
    }

    fn simulate(&mut self, held: &mut Held, values: &[f64]) -> Called {
        self.notices = Notices::default();
        // Those of `fmi2Reset` are none of a point alone.
        held.instance.forget_warnings();
        let simulated = self.simulate_on(&mut held.instance, values);
        self.hear_warnings(held);
        simulated
    }

    /// Notes the warnings of a simulation, after those of its instance's creation.
    fn hear_warnings(&mut self, held: &Held) {
        self.notices.warn(held.born.clone());
        self.notices.warn(held.instance.warnings());
    }

    fn simulate_on(&mut self, instance: &mut Instance, values: &[f64]) -> Called {
        let (scene, notices) = (&mut self.scene, &mut self.notices);
        scene.start(instance, values)?;
        let points = scene.task.schedule.points();
        if scene.watched.probes.is_empty() && scene.gauges.is_empty() {
            if let Err(call) = scene.advance::<false>(instance, &points, 0..points.steps) {
                notices.ended = Some(call.ended.ok_or(call)?.at);
            }
            return scene.finish(instance, 0.0, notices);
        }
        scene.forget();
        let from = if scene.has_windows { 0 } else { points.from(scene.task.schedule.window_start) };
        scene.advance::<false>(instance, &points, 0..from).map_err(before_the_window)?;
        scene.watch(instance, [points.at(from); 2])?;
        let mut stop = points.at(points.steps);
        if let Err(call) = scene.advance::<true>(instance, &points, from..points.steps) {
            // An end that the FMU chose is no failure, unless it comes before a window. The part of a step that was
            // computed counts, too.
            let Some(end) = call.ended else { return Err(call) };
            scene.watch(instance, [end.from, end.at])?;
            if scene.gauges.iter().any(|gauge| gauge.seen.is_none()) {
                return Err(before_the_window(call));
            }
            notices.ended = Some(end.at);
            stop = end.at;
        }
        scene.finish(instance, stop - points.at(from), notices)
    }
}

/// Statistics over a window cannot be taken where the FMU ends the simulation before it.
fn before_the_window(mut call: Call) -> Call {
    if let Some(EarlyEnd { at, .. }) = call.ended {
        let message = format!("the FMU ended the simulation at {at} s, before the window of the statistics");
        call.message = Some(message);
    }
    call
}

impl Probe {
    /// The variable's present value as a number.
    pub fn read(&self, instance: &mut Instance) -> Called<f64> {
        instance.value(self.handle).map(|value| value.number())
    }
}
