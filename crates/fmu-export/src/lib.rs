#![doc = include_str!("../README.md")]
//!
//! ## Without FMI
//!
//! [`Model`](model::Model) knows nothing of FMI, and whoever has a model can simulate it:
//!
//! ```
//! use fmu_export::declare::{input, output};
//! use fmu_export::description::{self, Interface, Version};
//! use fmu_export::model::{Experiment, Fault, Info, Log, Model, Variable, faults};
//! use fmu_export::{field, units};
//!
//! /// Counts metres.
//! #[derive(Clone, Default, serde::Serialize, serde::Deserialize)]
//! struct Odometer {
//!     speed: f64,
//!     distance: f64,
//! }
//!
//! static VARIABLES: [Variable<Odometer>; 2] = [
//!     input("speed", &units::METRE_PER_SECOND, field!(Odometer: speed), "Speed").shown_in("km/h"),
//!     output("distance", &units::METRE, |car| car.distance, "Distance since the start"),
//! ];
//!
//! impl Model for Odometer {
//!     const INFO: Info = fmu_export::info!();
//!
//!     fn variables() -> &'static [Variable<Self>] {
//!         &VARIABLES
//!     }
//!
//!     fn initialise(&mut self, _: &Experiment, _: &mut dyn Log) -> Result<(), Fault> {
//!         self.distance = 0.0;
//!         Ok(())
//!     }
//!
//!     fn advance(&mut self, _time: f64, step: f64, _: &mut dyn Log) -> Result<(), Fault> {
//!         self.distance += self.speed * step;
//!         Ok(())
//!     }
//! }
//!
//! assert_eq!(faults::<Odometer>(), Vec::<String>::new());
//! let mut car = Odometer { speed: 10.0, ..Odometer::default() };
//! car.initialise(&Experiment::default(), &mut ())?;
//! for step in 0..60 {
//!     car.advance(f64::from(step), 1.0, &mut ())?;
//! }
//! assert_eq!(car.distance, 600.0);
//! let xml = description::xml::<Odometer>(Version::Two, Interface::CoSimulation);
//! assert!(xml.contains(r#"<ScalarVariable name="speed" valueReference="0""#));
//! # Ok::<(), Fault>(())
//! ```

mod boundary;
pub mod declare;
pub mod fmi2;
pub mod fmi3;
pub mod model;
#[cfg(feature = "package")]
pub mod package;
pub mod units;

pub use boundary::description;
