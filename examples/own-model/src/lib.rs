//! A tank of water that drains through a hole in its bottom.

use fmu_export::declare::{input, output, parameter};
use fmu_export::model::{Experiment, Fault, Info, Log, Model, Variable, check_ranges};
use fmu_export::units::{CUBIC_METRE_PER_SECOND, METRE, SQUARE_METRE};
use fmu_export::{field, info};
use serde::{Deserialize, Serialize};

/// Input, parameters and state of the tank, in SI units.
#[derive(Clone, Serialize, Deserialize)]
pub struct Tank {
    inflow: f64,
    area: f64,
    hole: f64,
    initial_level: f64,
    level: f64,
}

/// The start values.
#[rustfmt::skip]
impl Default for Tank {
    fn default() -> Self {
        Self { inflow: 0.0, area: 0.5, hole: 2e-3, initial_level: 1.0, level: 1.0 }
    }
}

impl Tank {
    /// Torricelli's law: water leaves as fast as if it had fallen from the surface.
    fn outflow(&self, level: f64) -> f64 {
        self.hole * (2.0 * 9.81 * level.max(0.0)).sqrt()
    }

    fn rate(&self, level: f64) -> f64 {
        (self.inflow - self.outflow(level)) / self.area
    }
}

#[rustfmt::skip]
static VARIABLES: [Variable<Tank>; 6] = [
    input("inflow", &CUBIC_METRE_PER_SECOND, field!(Tank: inflow), "Flow into the tank").within(0.0, 1.0),
    parameter("area", &SQUARE_METRE, field!(Tank: area), "Area of the tank").within(1e-3, 1e3),
    parameter("hole", &SQUARE_METRE, field!(Tank: hole), "Area of the hole").within(0.0, 0.1).shown_in("cm2"),
    parameter("initialLevel", &METRE, field!(Tank: initial_level), "Level at the start").within(0.0, 10.0),
    output("level", &METRE, |t: &Tank| t.level, "Height of the water").derivative(|t| t.rate(t.level)),
    output("outflow", &CUBIC_METRE_PER_SECOND, |t| t.outflow(t.level), "Flow through the hole"),
];

impl Model for Tank {
    #[rustfmt::skip]
    const INFO: Info = Info { name: "Draining tank", identifier: "Tank", default_stop: 100.0, ..info!() };

    fn variables() -> &'static [Variable<Self>] {
        &VARIABLES
    }

    fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        check_ranges(self)?;
        self.level = self.initial_level;
        Ok(())
    }

    /// The midpoint rule in steps of at most 1 ms.
    fn advance(&mut self, _time: f64, step: f64, _: &mut dyn Log) -> Result<(), Fault> {
        let steps = (step / 1e-3).ceil();
        for _ in 0..steps as u64 {
            let middle = self.level + 0.5 * step / steps * self.rate(self.level);
            self.level += step / steps * self.rate(middle);
        }
        Ok(())
    }
}

fmu_export::export!(Tank);
