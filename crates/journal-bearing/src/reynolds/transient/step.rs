//! An internal step of the film: two implicit stages, and the mass balance over both.

use super::{
    balance::EndFlow,
    diagnostics::Diagnostics,
    evaluation::diagnose,
    landing::Landing,
    newton,
    stage::{FilmStage, JournalStage, NoSolution},
    state::State,
    warmth::{Column, HeatExchange},
    workspace::Workspace,
};
use crate::reynolds::settings::Drive;

/// `1 - 1/sqrt(2)`, the SDIRK method's coefficient.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Failed steps of an interval before [`Landing`] is tried; until then a shorter step is less work.
const PATIENCE: usize = 4;

/// The place of an internal step in its interval.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Its start, as a share of the interval.
    pub from: f64,
    /// Its length, as a share of the interval.
    pub share: f64,
    /// Its duration, s.
    pub duration: f64,
}

/// Takes the steps of an interval.
#[derive(Clone, Debug)]
pub struct Stepper {
    /// Mass per cell at the start of the first and of the second stage.
    start: Vec<f64>,
    launch: Vec<f64>,
    /// The state before the present step.
    pub kept: State,
    landing: Landing,
    /// Oil and heat of the step, by column.
    columns: Vec<Column>,
    /// Steps of the interval without a solution.
    pub failures: usize,
}

impl Stepper {
    /// Buffers for films like that of `work`.
    pub fn new(work: &Workspace) -> Self {
        let count = work.geometry.cells.count();
        Self {
            start: vec![0.0; count],
            launch: vec![0.0; count],
            kept: work.state.clone(),
            landing: Landing { trial: work.state.field.clone() },
            columns: Vec::new(),
            failures: 0,
        }
    }

    /// Takes one step. Returns its diagnostics and its error relative to the tolerance.
    pub fn step(
        &mut self,
        work: &mut Workspace,
        step: Step,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
        exchange: Option<&HeatExchange>,
    ) -> Result<(Diagnostics, f64), NoSolution> {
        self.kept.copy_from(&work.state);
        if let Some(exchange) = exchange {
            work.thin(drive, exchange);
        }
        let done = self.two_stages(work, step, drive, contact, exchange);
        self.failures += usize::from(done.is_err());
        done
    }

    fn two_stages(
        &mut self,
        work: &mut Workspace,
        step: Step,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
        exchange: Option<&HeatExchange>,
    ) -> Result<(Diagnostics, f64), NoSolution> {
        let Self { start: mass, launch, kept, landing, columns, failures } = self;
        let lands = work.geometry.cells.conserves_mass() && *failures >= PATIENCE;
        let mut solve = |work: &mut Workspace, stage: &FilmStage<'_>, task: &JournalStage<'_>| {
            let solution = newton::solve(work, stage, task);
            match solution {
                Err(NoSolution) if lands => landing.solve(work, stage, task, &kept.field),
                solution => solution,
            }
        };

        let start = work.state.eps;
        let first = GAMMA * step.duration;
        mass.copy_from_slice(&work.balance.mass);
        let mut task = JournalStage {
            start,
            guess: start + work.state.velocity * first,
            load: drive.load_at(step.from + GAMMA * step.share),
            force_scale: work.geometry.settings.force_scale(drive.viscosity),
            drive,
            contact,
        };
        work.turn(first, drive);
        let middle = solve(work, &stage(work, first, mass, drive), &task)?;
        let first_flow = work.balance.end_flow();
        if exchange.is_some() {
            work.begin_columns(mass, columns);
            work.add_flows(1.0 - GAMMA, columns);
        }

        // The second stage starts from where the rates of the first one lead at (1 - gamma) of the step.
        let ahead = (1.0 - GAMMA) / GAMMA;
        for ((launch, start), mass) in launch.iter_mut().zip(&*mass).zip(&work.balance.mass) {
            *launch = start + ahead * (mass - start);
        }
        work.extrapolate(ahead, &kept.field);
        let straight = start + (middle - start) / GAMMA;
        task.start = start + (middle - start) * ahead;
        task.guess = straight;
        task.load = drive.load_at(step.from + step.share);
        work.turn(step.duration - first, drive);
        let stage = stage(work, first, launch, drive);
        let end = solve(work, &stage, &task)?;

        work.state.eps = end;
        work.state.velocity = (end - task.start) / first;
        work.state.unit = work.geometry.settings.pressure_scale(drive.viscosity);
        // A gap that is finer than the grid resolves does not deserve finer steps.
        let resolved = work.geometry.cells.resolved_gap();
        let gap = work.geometry.gap.smallest.max(resolved);
        let error = (end - straight).norm() / (work.geometry.settings.tolerance * gap);
        let mut report = diagnose(work, &stage, drive);
        if work.geometry.cells.conserves_mass() {
            let last_flow = work.balance.end_flow();
            let mean = |first: f64, last: f64| first * (1.0 - GAMMA) + last * GAMMA;
            let flow = EndFlow {
                out: mean(first_flow.out, last_flow.out),
                into: mean(first_flow.into, last_flow.into),
                fed: mean(first_flow.fed, last_flow.fed),
            };
            report.mass_error = mass_error(work, mass, step.duration, flow, stage.rotation);
        }
        if let Some(exchange) = exchange {
            work.add_flows(GAMMA, columns);
            report.given = work.end_columns(columns, step.duration, report.heat, drive, exchange)?;
        }
        Ok((report, error))
    }
}

/// A stage that starts from the masses `mass`.
pub fn stage<'a>(work: &Workspace, duration: f64, mass: &'a [f64], drive: &Drive) -> FilmStage<'a> {
    let settings = &work.geometry.settings;
    let [side, feed] = settings.reservoirs(drive);
    // The flow of sliding rough surfaces at a shear flow factor of one (Patir & Cheng 1979).
    let shear = settings.flow_factors().map_or(0.0, |share| {
        let (roughness, excess) = (work.geometry.form.roughness, 2.0 * share - 1.0);
        0.5 * (drive.journal_speed - drive.bush_speed) * roughness * excess
    });
    FilmStage { duration, mass, rotation: drive.rotation(), shear, side, feed }
}

/// Inflow less outflow less storage over a step that began with the masses `start`, over the flow through the film.
fn mass_error(work: &Workspace, start: &[f64], duration: f64, flow: EndFlow, rotation: f64) -> f64 {
    let stored: f64 = (work.geometry.cells.area.iter())
        .zip(work.balance.mass.iter().zip(start))
        .map(|(area, (mass, start))| area * (mass - start))
        .sum();
    let through = work.through(&flow, rotation, duration);
    (stored / duration + flow.out - flow.into - flow.fed).abs() / through
}
