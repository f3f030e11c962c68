//! The methods: each is a folder with its options, what it asks of a study, the file of its result, and the document of it. To add
//! one, add its folder and its line in `methods!` below; its command and the page follow from that.

pub(crate) mod asking;
pub(crate) mod known;
pub mod rare;
pub(crate) mod setup;

use clap::Subcommand;

use crate::error::Result;
use asking::Delivery;
use known::Finished;
use result_document::Document;

macro_rules! methods {
    ($($(#[$about:meta])* $name:ident = $module:ident;)*) => {
        $(pub mod $module;)*

        /// The commands of the methods, with their options.
        #[derive(Debug, Subcommand)]
        pub enum Method {
            $($(#[$about])* $name($module::Options),)*
        }

        impl Method {
            /// Runs the command.
            ///
            /// # Errors
            /// With one clear line, for a mistake in what was asked for.
            pub(crate) fn run(self) -> Result<Delivery> {
                match self {
                    $(Self::$name(options) => $module::run(&options),)*
                }
            }
        }

        /// The methods' results in a study's folder, as its page shows them.
        pub(crate) fn shown(study: &Finished) -> Vec<Document> {
            let of_methods = [$(study.result($module::FILE).map(|result| $module::document(&result))),*];
            [rare::shown(study)].into_iter().chain(of_methods).flatten().collect()
        }
    };
}

methods! {
    /// Finds the parameters that make the measured values most probable
    Identify = identify;
    /// Finds the widest tolerances of the parameters at which the wanted share of points is still accepted, or conforms
    Tolerances = tolerances;
    /// Tells which parameter matters: Sobol indices, Shapley effects, Morris screening
    Sensitivity = sensitivity;
    /// Tells how far parameters may move: maps, largest box, margins
    Robustness = robustness;
    /// Shows the trade-off between criteria: Pareto front, best compromise
    Pareto = pareto;
}
