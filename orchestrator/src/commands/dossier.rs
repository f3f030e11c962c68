//! The verdict for other tools: meta data of the summary and of the whole task, after SSP Traceability.

use crate::error::Error;
use crate::results::Summary;
use crate::results::traceability::{self, criteria, dossier, origin, parameters, verdict};
use number_tables::files;
use point_journal::files::write_text;
use std::path::Path;

const SUMMARY: &str = "summary.json";
const RESOURCE: &str = "verdict.srmd";
const TASK: &str = "verdict.stmd";

/// Writes `verdict.srmd` and `verdict.stmd` beside the summary that they are about.
pub(super) fn write(folder: &Path, summary: &Summary) -> Result<(), Error> {
    let path = folder.join(SUMMARY);
    let digest = files::digest(&path).map_err(Error::io(&path))?;
    let parts = [verdict, dossier, origin, parameters, criteria];
    let mut entries: Vec<_> = parts.iter().flat_map(|part| part(summary)).collect();
    entries.push(("data.sha256".to_owned(), digest));
    let title = summary.title.as_deref();
    let name = format!("{}: verdict", title.unwrap_or(&summary.provenance.study));
    let resource = traceability::resource(&name, SUMMARY, &entries);
    for (file, text) in [(RESOURCE, resource), (TASK, traceability::task(summary))] {
        write_text(&folder.join(file), text)?;
    }
    Ok(())
}
