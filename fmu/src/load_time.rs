//! What is the same for all instances is computed when the library is loaded. Studies load it once and fork a process for each
//! point, which would compute all of it again.

use crate::{bearing::sommerfeld, stand::Stand};
use fmu_export::{
    description::{Interface, Version, fingerprint},
    model::{Experiment, Model},
};
use std::panic::catch_unwind;

/// A function in the list of those that the system calls after it has mapped the library.
#[used]
#[cfg_attr(target_os = "linux", unsafe(link_section = ".init_array"))]
#[cfg_attr(target_os = "macos", unsafe(link_section = "__DATA,__mod_init_func"))]
#[cfg_attr(windows, unsafe(link_section = ".CRT$XCU"))]
// SAFETY: each of these sections holds pointers to C functions without a result. This one starts no thread, waits for none, loads
// nothing and opens no file, so it may run under the loader's lock.
static AT_LOAD: extern "C" fn() = at_load;

/// Runs an instance with start values. A failure is the host's to see, when it runs one.
extern "C" fn at_load() {
    let _ = catch_unwind(|| {
        for version in [Version::Two, Version::Three] {
            fingerprint::<Stand>(version, Interface::CoSimulation);
        }
        let mut stand = Stand::default();
        let _ = stand.initialise(&Experiment::default(), &mut ());
        // They make the rows of the mobility film's map that most journals visit.
        for tenths in 1..10 {
            sommerfeld(1.0, 0.1 * f64::from(tenths));
        }
    });
}
