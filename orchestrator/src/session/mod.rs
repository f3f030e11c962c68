//! A study with everything that its run needs: tied to its FMU, its points known.

mod finale;
mod request;
mod until;
mod verification;

use thiserror::Error;

use crate::files::unusable;
use crate::judge::Judge;
use crate::pipeline::Model;
use crate::results::{Header, Outcome, ResultsError};
use crate::study::plan::Plan;
use crate::study::points;
use crate::study::{Study, StudyError};
use crate::table::TableError;
use fmu_import::{FmuError, Package};
use fmu_points::{Answer, RunError};

pub use finale::{FileSet, provenance};
pub use request::{Asking, Request};
pub use until::{Ending, Front, Until};
pub use verification::Verification;

/// Why a study cannot be run.
#[derive(Debug, Error)]
pub enum SessionError {
    /// The FMU cannot be used.
    #[error("{}", unusable(.0))]
    Fmu(#[from] FmuError),
    /// The study cannot be used.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A table cannot be used.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The results cannot be written or read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The points cannot be run.
    #[error(transparent)]
    Engine(#[from] RunError),
}

/// A study that is tied to its FMU.
#[derive(Debug)]
pub struct Session {
    /// The request: all options of the command.
    pub request: Request,
    /// The study.
    pub study: Study,
    /// The FMU.
    pub package: Package,
    /// The study, tied to the FMU.
    pub plan: Plan,
    /// The criteria.
    pub judge: Judge,
}

impl Session {
    /// Reads the study and the FMU.
    ///
    /// # Errors
    /// When either cannot be used.
    pub fn open(request: Request) -> Result<Self, SessionError> {
        let mut session = Self::open_with_risk(request)?;
        session.plan.forget_resampling();
        Ok(session)
    }

    /// The same, with the draws of measured curves: the risk of a verdict needs them, and they take time.
    ///
    /// # Errors
    /// When either cannot be used.
    pub fn open_with_risk(request: Request) -> Result<Self, SessionError> {
        let mut study = Study::read(&request.study)?;
        if let Some(folder) = &request.base {
            study.rebase(folder.clone());
        }
        study.design.points = request.points.unwrap_or(study.design.points);
        study.design.seed = request.seed.unwrap_or(study.design.seed);
        let package = study.open_fmu::<SessionError>(request.fmu.as_deref())?;
        let judge = Judge::new(&study, Some(package.description()))?;
        let plan = Plan::new(&study, package.description())?;
        points::varies(&study)?;
        plan.tell_of_inputs();
        Ok(Self {
            request,
            study,
            package,
            plan,
            judge,
        })
    }

    /// The journal's header: this study and FMU, the number of points and the seed.
    ///
    /// # Errors
    /// When the FMU cannot be read any more.
    pub fn header(&self, seed: u64, points: Option<u64>) -> Result<Header, SessionError> {
        Ok(Header {
            orchestrator: env!("CARGO_PKG_VERSION").to_owned(),
            study: self.study.digest(),
            fmu: self.package.digest()?,
            table: None,
            seed,
            points,
            shard: self.request.shard.map(|shard| shard.to_string()),
            analysis: None,
        })
    }
}

impl Model for Session {
    fn values(&self, point: &[f64]) -> Vec<f64> {
        let mut values = Vec::new();
        self.plan.to_fmu(point, &mut values);
        values
    }

    fn outcome(&self, answer: Answer) -> Outcome {
        match answer {
            Ok(mut values) => {
                self.plan.to_study(&mut values);
                Ok(values)
            }
            Err(failure) => Err(failure.converted(|values| self.plan.to_study(values))),
        }
    }

    fn is_verified(&self, outcome: &Outcome) -> bool {
        self.judge.verdict(outcome.as_deref().ok()).verified()
    }
}
