//! How a guard gets a child that works for it.
//!
//! On Unix that is a fork, which has all that the guard has. Windows has no forks: there a child is this program once
//! more, and is told what it needs.

use std::io;
use std::sync::Arc;

use fmu_import::isolation::{Child, Keeper};
use fmu_import::{Library, Package};

use super::servant::Work;
use super::system::Shared;
use super::wire::Setup;

/// What a guard has for its children.
#[cfg_attr(
    windows,
    expect(dead_code, reason = "only forks inherit what is loaded")
)]
pub(super) struct Estate<'a> {
    pub(super) setup: &'a Setup,
    pub(super) package: &'a mut Option<Package>,
    /// The FMU, where the guard has loaded it for them.
    pub(super) library: Option<Arc<Library>>,
    pub(super) progress: &'a Shared,
}

/// Forks a child.
///
/// # Safety
/// This process has a single thread.
#[cfg(unix)]
pub(super) unsafe fn child(
    keeper: &mut Keeper,
    estate: &mut Estate<'_>,
    work: &Work,
) -> io::Result<Child> {
    use super::servant;
    // SAFETY: the caller promises that this process has a single thread.
    unsafe {
        keeper.fork(&mut |place| {
            let (package, library) = (estate.package.as_mut(), estate.library.clone());
            servant::work(place, estate.setup, package, library, estate.progress, work);
        })
    }
}

/// Starts a child.
///
/// # Safety
/// None is needed: it is there as on Unix.
#[cfg(windows)]
pub(super) unsafe fn child(
    keeper: &mut Keeper,
    estate: &mut Estate<'_>,
    work: &Work,
) -> io::Result<Child> {
    let mut command = std::process::Command::new(super::system::program()?);
    command.arg(SERVANT).arg(estate.progress.name());
    let mut child = keeper.start(&mut command)?;
    child.send(&serde_json::to_vec(estate.setup)?)?;
    let mut order = Vec::new();
    work.put(&mut order)?;
    child.send(&order)?;
    Ok(child)
}

/// The hidden command that makes this program a guard's child.
#[cfg(windows)]
pub const SERVANT: &str = "servant";

/// Works for the guard that has started this process.
///
/// # Errors
/// When the guard cannot be understood or reached.
#[cfg(windows)]
pub fn serve(progress: &str) -> io::Result<()> {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use super::servant;
    use fmu_import::isolation::Place;
    use fmu_import::isolation::keeper::leave;

    let mut place = Place::take()?;
    let missing = || io::Error::other("the guard has gone");
    let setup: Setup = serde_json::from_slice(&place.receive().ok_or_else(missing)?)?;
    let work = Work::of(&place.receive().ok_or_else(missing)?)?;
    let progress = Shared::open(progress.to_owned())?;
    let mut package = Package::open(&setup.fmu).map_err(io::Error::other)?;
    // A panic ends this process as it would end a fork.
    let work = AssertUnwindSafe(|| {
        servant::work(place, &setup, Some(&mut package), None, &progress, &work);
    });
    if catch_unwind(work).is_err() {
        std::process::abort()
    }
    leave()
}
