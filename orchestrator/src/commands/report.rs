//! `report`: the page that tells the result of a study.

use std::process::ExitCode;

use super::output;
use crate::cli;
use crate::error::Error;
use crate::report::Report;
use crate::report::live::Live;
use crate::session::Verification;

pub(super) fn run(options: &cli::Report) -> Result<ExitCode, Error> {
    let mut report = Report::from_folder(&options.folder)?;
    if options.live {
        report.live = Some(live(options, &report)?);
    }
    let page = report.write(&options.folder)?;
    output::print(&format!("{}\n", page.display()));
    Ok(ExitCode::SUCCESS)
}

/// The FMU's module and a point's simulation, for the page.
fn live(options: &cli::Report, report: &Report) -> Result<Live, Error> {
    let cannot = |message: String| Error::option("live", message);
    match &report.whatif {
        None => return Err(cannot("the points cannot be judged in the page".to_owned())),
        Some(study) => study.can_be_drawn().map_err(cannot)?,
    }
    let verification = Verification::reopen(&options.folder, options.fmu.clone())?;
    let mut session = verification.session;
    Live::new(&session.plan, &mut session.package, &report.table).map_err(cannot)
}
