//! The messages between the processes of a run, over pipes.
//!
//! A supervisor has workers, each worker has children in which the FMU runs. All messages are frames with length and
//! checksum ([`frame`](fmu_import::isolation::frame)). The first frame to a worker is its [`Setup`] as JSON; then come
//! [orders](Order), and what is [said](Said) to them comes back, many points to a frame.

use std::{io, path::PathBuf};

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    as_json,
    failure::Failure,
    notices::Notices,
    points::{Job, PointLimits, Simulated},
    room,
    task::Case,
};

use fmu_import::{FmuError, Handle, Package, Value};

/// The first message to a worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Setup {
    /// The folder of the unpacked FMU.
    pub fmu: PathBuf,
    /// The FMU's path as the user gave it.
    pub name: PathBuf,
    /// Folders that are empty for each child: for temporary files, and as its working directory; the latter is none where
    /// that is the supervisor's own.
    pub temporary: Option<PathBuf>,
    pub place: Option<PathBuf>,
    /// The simulations of a point. Those of several cases are ordered one by one: see [`join`](crate::join).
    pub cases: Vec<Case>,
    /// How long a point may take, and how much memory.
    pub limits: PointLimits,
    /// The number that marks all further frames.
    pub ticket: u64,
    /// The byte that fills memory which the FMU has not written; none for memory as it comes.
    pub fill: Option<u8>,
    /// Whether what the FMU prints is shown on standard error.
    pub echo: bool,
}

impl Setup {
    /// Empties the folders.
    pub fn clear(&self) -> io::Result<()> {
        [&self.temporary, &self.place].into_iter().flatten().try_for_each(|folder| room::clear(folder))
    }

    /// Opens the FMU, with the sizes of the simulations.
    pub fn open(&self) -> Result<Package, FmuError> {
        let mut package = Package::open(&self.fmu)?;
        if let Some(case) = self.cases.first() {
            package.resize(&case.task.sizes)?;
        }
        Ok(package)
    }
}

/// An order of a supervisor to a worker, and of a worker to a child.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Order {
    /// Points in a child each, which loads the FMU itself.
    New(Vec<Job>),
    /// Points in a child each: a fork of the worker, which has loaded the FMU and never instantiated it.
    Forked(Vec<Job>),
    /// Points in one child. The worker sends them to it as they are.
    Used(Vec<Job>),
    /// A point of these values with its trajectory of some variables, in a child of its own.
    Recorded(Vec<f64>, Vec<Handle>),
    /// An [errand](crate::single::Errand) of the program, in a child of its own, which loads the FMU itself.
    Errand(Vec<u8>),
}

/// A message of a child to its worker, and of a worker to its supervisor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Said {
    /// The FMU cannot be loaded, and why.
    Unloadable(String),
    /// The child has loaded it; whether its process may be forked.
    Loaded(bool),
    /// The outcomes of points.
    Replies(Vec<Reply>),
    /// Rows of a trajectory, one after the other: the time, and a value a column.
    Rows(Vec<Value>),
    /// What an errand tells.
    Told(Vec<u8>),
    /// The trajectory or the errand has ended, and why before its time.
    Ended(#[serde(with = "as_json")] Option<Failure>),
    /// The FMU's messages on the point, now that its simulation has been ended.
    Farewell(#[serde(with = "as_json")] Notices),
}

/// The outcome of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// The index of the simulation.
    pub index: u64,
    /// Its results in the FMU's units, or why there are none.
    pub answer: SimulationOutcome,
    /// Whether the process that has loaded the FMU may be forked, where that has been looked at.
    pub forkable: Option<bool>,
}

impl Reply {
    /// An outcome of which no more is known.
    pub fn new(index: u64, answer: SimulationOutcome) -> Self {
        Self { index, answer, forkable: None }
    }
}

/// The outcome of a simulation.
pub type SimulationOutcome = Result<Simulated, Trouble>;

/// Why there are no results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trouble {
    /// Where the failure comes from.
    pub from: Origin,
    /// The failure as the results show it.
    #[serde(with = "as_json")]
    pub failure: Failure,
    /// The FMU's warnings before it failed.
    #[serde(with = "as_json")]
    pub notices: Box<Notices>,
    /// Whether another try may go otherwise, where the FMU was not loaded.
    pub passing: bool,
}

/// Where a failure comes from. Of several, the first one decides: an FMU that cannot be loaded or gives no instance is no
/// matter of one case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Origin {
    /// The FMU cannot be loaded.
    Loading,
    /// The FMU refused an instance.
    Refusal {
        /// Whether it spoke of a licence.
        licence: bool,
    },
    /// The process ended, or had to be ended.
    Process,
    /// The FMU failed, and said so.
    Fmu,
}

impl Trouble {
    /// A failure before which the FMU said nothing.
    pub fn new(from: Origin, failure: Failure) -> Self {
        Self { from, failure, notices: Box::default(), passing: false }
    }

    /// The FMU cannot be loaded.
    pub fn unloadable(reason: String) -> Self {
        Self::new(Origin::Loading, Failure::Unloadable(reason))
    }

    /// The process was lost.
    pub fn lost(failure: Failure) -> Self {
        Self::new(Origin::Process, failure)
    }
}

/// A message's bytes.
pub fn bytes(message: &impl Serialize) -> Vec<u8> {
    postcard::to_stdvec(message).expect("messages are plain data")
}

/// A message from its bytes; `None` where they are damaged.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmu_import::Value;
    use proptest::prelude::*;

    proptest! {
        /// Every bit of a number arrives, also those of what is no number.
        #[test]
        fn what_was_put_is_read(index: u64, number: u64, text: String, flag: bool) {
            let values = vec![f64::from_bits(number), -0.0, f64::INFINITY];
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            let order = bytes(&Order::Used(vec![Job { index, values: values.clone() }]));
            match read(&order) {
                Some(Order::Used(jobs)) => {
                    prop_assert_eq!(jobs[0].index, index);
                    prop_assert_eq!(bits(&jobs[0].values), bits(&values));
                }
                other => prop_assert!(false, "{:?}", other),
            }
            let notices = Some(Box::new(Notices { warnings: index, ended: Some(0.5), ..Notices::default() }));
            let failure = Failure::Error(text);
            let trouble = Trouble { notices: notices.clone().unwrap(), ..Trouble::lost(failure.clone()) };
            let good = Reply::new(index, Ok(Simulated { values: values.clone(), notices: notices.clone() }));
            let bad = Reply { forkable: Some(flag), ..Reply::new(index, Err(trouble)) };
            match read(&bytes(&Said::Replies(vec![good, bad.clone()]))) {
                Some(Said::Replies(replies)) => {
                    let simulated = replies[0].answer.as_ref().unwrap();
                    prop_assert_eq!(bits(&simulated.values), bits(&values));
                    prop_assert_eq!(&simulated.notices, &notices);
                    prop_assert_eq!(&replies[1], &bad);
                }
                other => prop_assert!(false, "{:?}", other),
            }
            let row = vec![Value::Integer(number.into()), Value::Boolean(flag), Value::String("ü".to_owned())];
            for said in [Said::Rows(row), Said::Ended(Some(failure)), Said::Ended(None), Said::Loaded(flag)] {
                prop_assert_eq!(read::<Said>(&bytes(&said)), Some(said));
            }
        }

        #[test]
        fn damage_is_no_panic(bytes: Vec<u8>) {
            let _ = read::<Said>(&bytes);
            let _ = read::<Order>(&bytes);
        }
    }
}
