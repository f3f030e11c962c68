//! Shards of one run, and their points in one journal.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use super::asking::{self, Analysis, Delivery};
use super::setup::{Place, Source};
use crate::error::Error;
use crate::session::Request;
use point_journal::pipeline::folder::Earlier;
use point_journal::pipeline::{Part, Pipeline};
use point_journal::{Finished, Header, Journal, journal, lines};

/// The folders of shards, and where their points go.
#[derive(Clone, Copy, Debug)]
pub struct Shards<'a> {
    /// The folders.
    pub folders: &'a [PathBuf],
    /// The folder for the results.
    pub output: &'a Path,
    /// Whether what that holds is replaced.
    pub force: bool,
}

impl Shards<'_> {
    /// Joins the points of an analysis.
    pub(super) fn join<A: Analysis + DeserializeOwned>(&self, request: Request) -> Result<Delivery, Error> {
        let options = request.analysis.as_ref().map(|asking| &asking.options);
        let analysis = options.and_then(|options| A::deserialize(options).ok());
        let analysis = analysis.ok_or_else(|| self.unknown(&request))?;
        let source = analysis.open(request)?;
        analysis.check(&source)?;
        let header = asking::header(&source, &analysis)?;
        let named = self.check(&header)?;
        let place = Place { output: self.output, analysis: Some(A::NAME), earlier: self.earlier(false) };
        let mut taken = place.take(source.parts(), &header, || Ok(()))?;
        self.fill(&mut taken.journal)?;
        let finished = Finished::read(&place.state())?;
        let part = Part::of(None, &header);
        let model = source.parts().model;
        let mut pipeline = Pipeline::new(model, None, taken.journal, Some(finished), part);
        match analysis.find(&source, &mut pipeline, self.output) {
            Ok(mut result) => {
                pipeline.end()?;
                result.tell_validity(source.parts(), &place.state())?;
                Ok(Delivery::new(result, self.output.to_owned(), taken.kept))
            }
            Err(Error::Journal(point_journal::Error::Unknown { missing, of })) => {
                let command = format!("{} STUDY ...", A::NAME);
                Err(self.incomplete([missing, of], &named, &command))
            }
            Err(error) => Err(error),
        }
    }

    /// The request asks for what this program does not know.
    pub(super) fn unknown(&self, request: &Request) -> Error {
        let name = request.analysis.as_ref().map(|asking| &*asking.name);
        Error::Refused(format!(
            "{}: this program knows no analysis `{}` with these options",
            self.folders[0].display(),
            name.unwrap_or_default()
        ))
    }

    /// Points are missing.
    pub fn incomplete(&self, [missing, points]: [u64; 2], shards: &[String], command: &str) -> Error {
        Error::Refused(format!(
            "{missing} of {points} points are in none of the shards {}; merge all of them, or \
             compute what is missing with `{command} --output {} --resume`",
            shards.join(", "),
            self.output.display()
        ))
    }

    /// The treatment of the output folder: a merge that was interrupted goes on, one that is complete is done again.
    pub fn earlier(&self, complete: bool) -> Earlier {
        match (self.force, complete) {
            (true, _) => Earlier::Replaced,
            (_, true) => Earlier::Complete,
            _ => Earlier::Resumed,
        }
    }

    /// Adds all points of the shards to a journal.
    ///
    /// # Errors
    /// When a journal cannot be read or written.
    pub fn fill(&self, joined: &mut Journal) -> Result<(), Error> {
        for folder in self.folders {
            journal::copy(folder, joined)?;
        }
        Ok(joined.sync()?)
    }

    /// Refuses folders that are not of one study, before anything is written; names their shards.
    ///
    /// # Errors
    /// Says which folder is of another one.
    pub fn check(&self, of: &Header) -> Result<Vec<String>, Error> {
        let name = |folder: &PathBuf| {
            let then = lines::header(folder)?;
            // Only the part differs from one to the other.
            let same_part = Header { shard: then.shard.clone(), ..of.clone() };
            match same_part.difference(&then) {
                None => Ok(then.shard.unwrap_or_else(|| "1/1".to_owned())),
                // The first one gave the study file; its points are older than what stands there now.
                Some((what, then, now)) if *folder == self.folders[0] => Err(Error::Refused(format!(
                    "{} has points of another {what} ({then}) than there is now ({now}); run it again",
                    folder.display(),
                ))),
                Some((what, then, now)) => Err(Error::Refused(format!(
                    "{} has another {what} ({then}) than {} ({now}); leave it out",
                    folder.display(),
                    self.folders[0].display(),
                ))),
            }
        };
        self.folders.iter().map(name).collect()
    }
}
