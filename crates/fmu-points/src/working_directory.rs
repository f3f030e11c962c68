//! Which working directory the FMU has.
//!
//! What one point leaves in the working directory, such as a log, the next one may read. So each process has an empty
//! one. But a study may name a file by a relative path, which the FMU then looks for where the user is: there points
//! keep the user's own working directory.

use std::{
    env,
    ffi::{OsStr, OsString},
    path::{self, Component, Path, PathBuf},
};

use crate::task::Task;
use fmu_import::{Description, Kind, Value};

/// Whether points of these tasks keep the user's working directory, since they name a file in it.
pub fn is_kept<'t>(fmu: &Description, tasks: impl IntoIterator<Item = &'t Task>) -> bool {
    tasks.into_iter().any(is_named_in) || named_by(fmu)
}

/// Whether a text that the study sets is the relative path of something that exists.
pub fn is_named_in(task: &Task) -> bool {
    is_named_among(&task.fixed)
}

/// The same of values of an FMU's variables.
pub fn is_named_among(values: &[(u32, Value)]) -> bool {
    values.iter().any(|(_, value)| matches!(value, Value::String(text) if is_here(text)))
}

/// Whether the start value of a text is the relative path of something that exists.
pub(crate) fn named_by(description: &Description) -> bool {
    let mut variables = description.variables.values();
    variables.any(|variable| match &variable.kind {
        Kind::String { start: Some(text) } => is_here(text),
        _ => false,
    })
}

fn is_here(text: &str) -> bool {
    let path = Path::new(text);
    !text.is_empty() && path.is_relative() && path.exists()
}

/// Lists of files and folders in the environment, by which libraries, programs and modules are found.
const LISTS: [&str; 4] = ["LD_LIBRARY_PATH", "LD_PRELOAD", "PATH", "PYTHONPATH"];

/// These lists for a process in another working directory: what they name relative to this one, it would not find.
pub(crate) fn lists_for_elsewhere() -> impl Iterator<Item = (&'static str, OsString)> {
    LISTS
        .into_iter()
        .filter_map(|name| Some((name, env::var_os(name)?)))
        .map(|(name, list)| (name, from_here(name, &list)))
}

/// A list with absolute paths.
fn from_here(name: &str, list: &OsStr) -> OsString {
    let absolute = |entry: PathBuf| {
        // The loader looks for a library without a slash by itself.
        let mut parts = entry.components();
        let one = matches!(parts.next(), None | Some(Component::Normal(_)));
        if name == "LD_PRELOAD" && one && parts.next().is_none() {
            return entry;
        }
        // Elsewhere an empty entry means the working directory.
        let empty = entry.as_os_str().is_empty();
        let named = if empty { Path::new(".") } else { &entry };
        path::absolute(named).unwrap_or(entry)
    };
    env::join_paths(env::split_paths(list).map(absolute)).unwrap_or_else(|_| list.to_owned())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_become_absolute() {
        let here = env::current_dir().unwrap();
        let here = here.to_str().unwrap();
        let made = |name: &str, list: &str| from_here(name, list.as_ref()).into_string().unwrap();
        assert_eq!(made("PATH", "/bin:own::/x/../y"), format!("/bin:{here}/own:{here}:/x/../y"));
        assert_eq!(made("LD_PRELOAD", "libm.so.6:own/a.so"), format!("libm.so.6:{here}/own/a.so"));
        assert_eq!(made("LD_PRELOAD", ""), "");
    }
}
