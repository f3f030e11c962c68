//! A study with everything that its run needs: tied to its FMU, its points known.

pub mod account;
mod accounts;
pub mod budget;
mod finale;
mod request;
mod until;
mod verification;

use crate::error::Result;
use fmu_import::Package;
use fmu_points::PointResult;
use point_journal::{Header, PointOutcome, pipeline::Model};
use study::{Study, judge::Judge, plan::Plan, points};

pub use finale::{FileSet, provenance};
pub use request::{Request, absolute};
pub use until::{Ending, Front, Until};
pub use verification::Verification;

/// A study that is tied to its FMU.
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
    pub fn open(request: Request) -> Result<Self> {
        let mut session = Self::open_with_risk(request)?;
        session.plan.forget_resampling();
        Ok(session)
    }

    /// The same, with the draws of measured curves: the risk of a verdict needs them, and they take time.
    ///
    /// # Errors
    /// When either cannot be used.
    pub fn open_with_risk(mut request: Request) -> Result<Self> {
        let mut study = Study::read(&request.study)?;
        // A design that needs all its points keeps those of the study, and so does a table.
        let goes_on = request.points_from.is_none() && study.design.method.is_extensible();
        request.points = request.points.or(request.most.filter(|_| goes_on));
        if let Some(folder) = &request.base {
            study.rebase(folder.clone());
        }
        study.design.points = request.points.unwrap_or(study.design.points);
        study.design.seed = request.seed.unwrap_or(study.design.seed);
        let package = study.open_fmu(request.fmu.as_deref())?;
        let judge = Judge::new(&study, Some(package.description()))?;
        let plan = Plan::new(&study, package.description())?;
        points::varies(&study)?;
        plan.tell_of_inputs();
        Ok(Self { request, study, package, plan, judge })
    }
}

/// The journal's header: this study and FMU, the number of points and the seed.
///
/// # Errors
/// When the FMU cannot be read any more.
pub fn header(study: &Study, package: &Package, seed: u64, points: Option<u64>) -> Result<Header> {
    Ok(Header {
        orchestrator: env!("CARGO_PKG_VERSION").to_owned(),
        study: study.digest(),
        fmu: package.digest()?,
        seed,
        points,
        ..Header::default()
    })
}

impl Model for Session {
    fn values(&self, point: &[f64]) -> Vec<f64> {
        let mut values = Vec::new();
        self.plan.to_fmu(point, &mut values);
        values
    }

    fn outcome(&self, answer: PointResult) -> PointOutcome {
        match answer {
            Ok(mut values) => {
                self.plan.to_study(&mut values);
                Ok(values)
            }
            Err(failure) => Err(failure.converted(|values| self.plan.to_study(values))),
        }
    }

    fn is_verified(&self, outcome: &PointOutcome) -> bool {
        self.judge.verdict(outcome.as_deref().ok()).verified()
    }
}
