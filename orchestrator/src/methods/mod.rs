//! The methods: each is a folder with its options, what it asks of a study, and the document of its result. To add one, add
//! its folder and its line in [`methods!`] below; its command, `--resume`, `merge` and the page follow from that.

pub(crate) mod asking;
pub(crate) mod join;
pub(crate) mod known;
pub mod rare;
pub(crate) mod setup;

use clap::Subcommand;

use crate::error::Error;
use crate::session::Request;
use asking::{Analysis, Delivery};
use join::Shards;
use known::Finished;
use result_document::Document;

macro_rules! methods {
    (runs { $($(#[$about:meta])* $name:ident = $module:ident;)* } points { $($(#[$of:meta])* $other:ident = $reader:ident;)* }) => {
        $(pub mod $module;)*
        $(pub mod $reader;)*

        /// The commands of the methods, with their options.
        #[derive(Debug, Subcommand)]
        pub enum Method {
            $($(#[$about])* $name($module::Options),)*
            $($(#[$of])* $other($reader::Options),)*
        }

        impl Method {
            /// Runs the command.
            ///
            /// # Errors
            /// With one clear line, for a mistake in what was asked for.
            pub(crate) fn run(self) -> Result<Delivery, Error> {
                match self {
                    $(Self::$name(options) => $module::run(&options),)*
                    $(Self::$other(options) => $reader::run(&options),)*
                }
            }
        }

        /// The names of the methods with runs, which are those of the folders of their journals.
        pub(crate) const NAMES: &[&str] = &[$(<$module::Asked as Analysis>::NAME),*];

        /// Joins the shards of the analysis that a request asks for.
        ///
        /// # Errors
        /// When they do not belong together, and when points are missing.
        pub(crate) fn join(shards: &Shards<'_>, request: Request) -> Result<Delivery, Error> {
            let asking = request.analysis.clone();
            match asking.as_ref().map(|asking| asking.name.as_str()) {
                $(Some(<$module::Asked as Analysis>::NAME) => shards.join::<$module::Asked>(request),)*
                _ => Err(shards.unknown(&request)),
            }
        }

        /// The methods' results in a study's folder, as its page shows them.
        pub(crate) fn shown(study: &Finished<'_>) -> Vec<Document> {
            [rare::shown(study), $($module::shown(study),)* $($reader::shown(study)),*].into_iter().flatten().collect()
        }
    };
}

// Those that ask for points of their own, and those that read the points of a finished study alone.
methods! {
    runs {
        /// Finds the parameters that make the measured values most probable
        Identify = identify;
        /// Finds the widest tolerances of the parameters at which the wanted share of points is still accepted, or conforms
        Tolerances = tolerances;
        /// Tells which parameter matters: Sobol indices, Shapley effects, Morris screening
        Sensitivity = sensitivity;
        /// Tells how far parameters may move: maps, largest box, margins
        Robustness = robustness;
    }
    points {
        /// Shows the trade-off between criteria: Pareto front, best compromise
        Pareto = pareto;
    }
}
