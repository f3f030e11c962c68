//! An internal step of the film: two implicit stages, and how well mass is conserved over both.

use nalgebra::Vector2;

use super::balance::{EndFlow, Stage};
use super::cells::Cavitation;
use super::diagnostics::{Diagnostics, diagnose};
use super::film::ReynoldsFilm;
use super::newton::{NoSolution, STILL, Task};
use super::settings::Drive;

/// `1 - 1/sqrt(2)`, the SDIRK method's coefficient.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// An internal step: its place in the interval and its duration (shares of the interval, and s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) from: f64,
    pub(super) share: f64,
    pub(super) duration: f64,
}

impl ReynoldsFilm {
    /// One step; the result's error is relative to the tolerance.
    pub(super) fn step(
        &mut self,
        step: Step,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
    ) -> Result<(Diagnostics, f64), NoSolution> {
        let start = self.state.eps;
        let first = GAMMA * step.duration;
        self.start.copy_from_slice(&self.balance.mass);
        let mut task = Task {
            start,
            guess: start + self.state.velocity * first,
            load: drive.load_at(step.from + GAMMA * step.share),
            drive,
            contact,
        };
        self.turn(first, drive);
        let middle = self.stage(first, &task, |film| &mut film.start)?;
        let first_flow = self.balance.end_flow();

        // The second stage starts from where the first one's rates lead at (1 - gamma) of the step.
        let ahead = (1.0 - GAMMA) / GAMMA;
        for ((launch, start), mass) in self
            .launch
            .iter_mut()
            .zip(&self.start)
            .zip(&self.balance.mass)
        {
            *launch = start + ahead * (mass - start);
        }
        self.extrapolate(ahead);
        let straight = start + (middle - start) / GAMMA;
        task.start = start + (middle - start) * ahead;
        task.guess = straight;
        task.load = drive.load_at(step.from + step.share);
        self.turn(step.duration - first, drive);
        let end = self.stage(first, &task, |film| &mut film.launch)?;

        self.state.velocity = (end - task.start) / first;
        self.state.eps = end;
        self.state.unit = self.settings.pressure_scale(drive.viscosity);
        // A gap finer than what the grid resolves is not worth finer steps.
        let gap = self.gap.smallest.max(self.resolved_gap());
        let error = (end - straight).norm() / (self.settings.tolerance * gap);
        let stage = self.stage_over(first, &self.launch, drive);
        let mut report = diagnose(self, &stage, drive);
        if self.cells.conserves_mass() {
            let last_flow = self.balance.end_flow();
            let flow = first_flow
                .weighted(1.0 - GAMMA)
                .and(last_flow.weighted(GAMMA));
            report.mass_error = self.mass_error(step.duration, flow, stage.rotation);
        }
        Ok((report, error))
    }

    /// Leads the pressures on from the step's start over the first stage, as a guess.
    fn extrapolate(&mut self, ahead: f64) {
        let field = &mut self.state.field;
        let pressures = field.pressure.iter_mut().zip(&self.kept.field.pressure);
        for ((pressure, start), &full) in pressures.zip(&field.full) {
            *pressure += if full {
                ahead * (*pressure - start)
            } else {
                0.0
            };
        }
    }

    /// Solves a stage that starts from the masses in one of the buffers.
    fn stage(
        &mut self,
        duration: f64,
        task: &Task<'_>,
        buffer: fn(&mut Self) -> &mut Vec<f64>,
    ) -> Result<Vector2<f64>, NoSolution> {
        let mass = std::mem::take(buffer(self));
        let stage = self.stage_over(duration, &mass, task.drive);
        let result = self
            .settle(&stage, task)
            .or_else(|NoSolution| self.land(&stage, task));
        *buffer(self) = mass;
        result
    }

    fn stage_over<'a>(&self, duration: f64, mass: &'a [f64], drive: &Drive) -> Stage<'a> {
        let side = match self.settings.cavitation {
            Cavitation::NonNegative => 0.0,
            Cavitation::MassConserving => {
                self.settings.side_pressure / self.settings.pressure_scale(drive.viscosity)
            }
        };
        Stage {
            duration,
            mass,
            rotation: drive.rotation(),
            shear: self.shear_flow(drive),
            side,
        }
    }

    /// What the sliding of rough surfaces carries at a shear flow factor of one (Patir & Cheng 1979).
    fn shear_flow(&self, drive: &Drive) -> f64 {
        self.settings.flow_factors().map_or(0.0, |share| {
            let excess = 2.0 * share - 1.0;
            0.5 * (drive.journal_speed - drive.bush_speed) * self.form.roughness * excess
        })
    }

    /// What a step's inflow, outflow and storage differ by, over the flow.
    fn mass_error(&self, duration: f64, flow: EndFlow, rotation: f64) -> f64 {
        let stored: f64 = (self.cells.area.iter())
            .zip(self.balance.mass.iter().zip(&self.start))
            .map(|(area, (mass, start))| area * (mass - start))
            .sum();
        let moved = flow.out + flow.into + self.circulating(rotation);
        let still = STILL * self.balance.held(&self.cells) / duration;
        (stored / duration + flow.out - flow.into).abs() / moved.max(still)
    }

    /// The flow that the mean rotation carries around, averaged over the columns.
    fn circulating(&self, rotation: f64) -> f64 {
        rotation.abs() * self.balance.held(&self.cells) / std::f64::consts::TAU
    }

    /// The flow through the film by which a stage's residuals are judged.
    pub(super) fn flow(&self, stage: &Stage<'_>) -> f64 {
        let ends = self.balance.end_flow();
        let still = STILL * self.balance.held(&self.cells) / stage.duration;
        (ends.out + ends.into + self.circulating(stage.rotation)).max(still)
    }
}
