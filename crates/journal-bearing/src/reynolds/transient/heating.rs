//! The film's oil and heat, column by column, for its [temperature around the bearing](super::warmth).

use std::f64::consts::TAU;

use super::{
    stage::NoSolution,
    warmth::{self, Column, HeatExchange, HeatGiven, Warm},
    workspace::Workspace,
};
use crate::reynolds::{lanes::dot, settings::Drive};

impl Workspace {
    /// Gives each column its viscosity; a film without temperatures begins with the exchange's.
    pub fn thin(&mut self, drive: &Drive, exchange: &HeatExchange) {
        let columns = self.geometry.cells.grid.columns();
        let begins = Warm { temperature: exchange.start, fluidity: 1.0 };
        self.state.warm.resize(columns, begins);
        for warm in &mut self.state.warm {
            warm.fluidity = drive.viscosity / (exchange.viscosity)(warm.temperature);
        }
    }

    /// The film's temperature, K: the mean of its oil's. `None` where it has none of its own.
    pub fn temperature(&self) -> Option<f64> {
        let (mut held, mut heat) = (0.0, 0.0);
        for ((_, range), warm) in self.geometry.cells.columns().zip(&self.state.warm) {
            let oil = dot(&self.geometry.cells.area[range.clone()], &self.balance.mass[range]);
            held += oil;
            heat += oil * warm.temperature;
        }
        (held > 0.0).then(|| heat / held)
    }

    /// Volume of a dimensionless one, m3.
    fn volume(&self) -> f64 {
        let settings = &self.geometry.settings;
        0.5 * settings.clearance * settings.diameter * settings.width
    }

    /// Begins a step that starts from the masses `start` per cell.
    pub fn begin_columns(&self, start: &[f64], columns: &mut Vec<Column>) {
        let (cells, volume) = (&self.geometry.cells, self.volume());
        columns.clear();
        columns.extend(cells.columns().map(|(_, range)| Column {
            held: [volume * dot(&cells.area[range.clone()], &start[range]), 0.0],
            ..Column::default()
        }));
    }

    /// Adds the flows of the present stage, a `share` of the step.
    pub fn add_flows(&self, share: f64, columns: &mut [Column]) {
        let by = share * self.volume();
        for ((_, range), column) in self.geometry.cells.columns().zip(columns) {
            let flows = self.balance.flows(range);
            column.around += by * flows.around;
            for k in 0..2 {
                column.ends[k] += by * flows.ends[k];
                column.feed[k] += by * flows.feed[k];
            }
        }
    }

    /// Ends a step of `duration` seconds in which the film has turned `heat` watts into heat.
    pub fn end_columns(
        &mut self,
        columns: &mut [Column],
        duration: f64,
        heat: f64,
        drive: &Drive,
        exchange: &HeatExchange,
    ) -> Result<HeatGiven, NoSolution> {
        let volume = self.volume();
        let heats = self.heats(drive);
        let all: f64 = heats.iter().sum();
        let cells = &self.geometry.cells;
        let resolved = cells.resolved_gap();
        for (((_, range), column), part) in cells.columns().zip(&mut *columns).zip(heats) {
            let mass = &self.balance.mass[range.clone()];
            column.held[1] = volume * dot(&cells.area[range.clone()], mass);
            // Where nothing heats, there is no heat to share.
            column.heat = if all > 0.0 { heat * part / all } else { 0.0 };
            // Conduction goes through the oil, and with the reciprocal of the gap.
            let of = |c: usize| cells.area[c] * self.state.field.content[c] / self.geometry.gap.cell[c].max(resolved);
            let share: f64 = range.map(of).sum::<f64>() / TAU;
            column.conductance = exchange.conductance.map(|all| all * share);
        }
        let mut temperatures: Vec<f64> = (self.state.warm.iter()).map(|warm| warm.temperature).collect();
        let given = warmth::step(columns, &mut temperatures, duration, exchange)?;
        for (warm, temperature) in self.state.warm.iter_mut().zip(temperatures) {
            warm.temperature = temperature;
        }
        Ok(given)
    }

    /// What each column's share of the heat goes with: shear, and losses of the pressure flow.
    fn heats(&self, drive: &Drive) -> Vec<f64> {
        let (cells, gap, field) = (&self.geometry.cells, &self.geometry.gap, &self.state.field);
        let settings = &self.geometry.settings;
        let radius = 0.5 * settings.diameter;
        let sliding = drive.journal_speed - drive.bush_speed;
        let viscous = drive.viscosity * radius.powi(3) * settings.width / settings.clearance;
        let moment = settings.force_scale(drive.viscosity) * settings.clearance;
        let resolved = cells.resolved_gap();
        let shear = |c: usize| {
            let slow = gap.cell[c].max(resolved) * self.liquid.fluidity[c];
            cells.land[c] * field.content[c] / slow
        };
        let lost = |conductance: f64, a: usize, b: usize| conductance * (field.pressure[a] - field.pressure[b]).powi(2);
        let mut heats = vec![0.0; cells.grid.columns()];
        for (i, range) in cells.columns() {
            let (before, first) = (cells.before(i), range.start);
            let sheared: f64 = range.clone().map(shear).sum();
            let over = |c: usize| lost(self.balance.across[c], c - 1, c);
            let across: f64 = range.clone().skip(1).map(over).sum();
            let along: f64 = range.map(|c| lost(self.balance.along[c], before * cells.stride + c - first, c)).sum();
            heats[i] += viscous * sliding * sliding * sheared + moment * (across + 0.5 * along);
            heats[before] += 0.5 * moment * along;
        }
        heats
    }
}
