//! How a worker gets a child.
//!
//! On Unix that is a fork, which has all that the worker has. Windows has no forks: there a child is this program once
//! more, and is told what it needs.

use std::io;

use fmu_import::isolation::{Child, Keeper};

use crate::{child::Estate, wire::Order};

/// Forks a child.
///
/// # Safety
/// This process has a single thread.
#[cfg(unix)]
pub unsafe fn child(keeper: &mut Keeper, estate: &mut Estate, order: &Order) -> io::Result<Child> {
    // SAFETY: the caller promises that this process has a single thread.
    unsafe {
        keeper.fork(&mut |place| {
            let estate = Estate {
                setup: &mut *estate.setup,
                package: estate.package.as_deref_mut(),
                runner: &mut *estate.runner,
            };
            crate::child::Child { place, estate }.obey(order);
        })
    }
}

/// Starts a child.
///
/// # Safety
/// None is needed: it is there as on Unix.
#[cfg(windows)]
pub unsafe fn child(keeper: &mut Keeper, estate: &mut Estate, order: &Order) -> io::Result<Child> {
    let mut command = std::process::Command::new(crate::system::program()?);
    command.arg(CHILD);
    let mut child = keeper.start(&mut command)?;
    child.send(&serde_json::to_vec(&*estate.setup)?)?;
    child.send(&crate::wire::bytes(order))?;
    Ok(child)
}

/// The argument that makes this program a worker's child.
#[cfg(windows)]
pub const CHILD: &str = "fmu-points-child";

/// Works for the worker that has started this process.
///
/// # Errors
/// When the worker cannot be understood or reached.
#[cfg(windows)]
pub fn serve() -> io::Result<()> {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use fmu_import::isolation::ChildEnd;
    use fmu_import::isolation::keeper::leave;

    use crate::wire::Setup;

    let mut place = ChildEnd::take()?;
    let missing = || io::Error::other("the worker has gone");
    let mut setup: Setup = serde_json::from_slice(&place.receive().ok_or_else(missing)?)?;
    let order: Order = crate::wire::read(&place.receive().ok_or_else(missing)?)
        .ok_or_else(|| io::Error::other("an order is damaged"))?;
    let mut package = setup.open().map_err(io::Error::other)?;
    let estate = Estate { setup: &mut setup, package: Some(&mut package), runner: &mut None };
    let child = crate::child::Child { place, estate };
    // A panic ends this process as it would end a fork.
    if catch_unwind(AssertUnwindSafe(|| child.obey(&order))).is_err() {
        std::process::abort()
    }
    leave()
}
