//! The command that computes a result again.

use crate::results::Summary;
use crate::session::Request;
use std::path::{Component, Path, PathBuf};

/// The command with the study's path, as it is called from the folder that holds both study and results.
pub(super) fn command(folder: &Path, summary: &Summary) -> String {
    let p = &summary.provenance;
    let request = Request::read(folder).ok();
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let study = request.as_ref().map(|request| request.own_study());
    let [study, output] = match study {
        Some(study) => below_common_folder(study, &folder).map(|path| quoted(&path)),
        None => [p.study.clone(), String::new()],
    };
    let output = match output.as_str() {
        "" => String::new(),
        output => format!(" --output {output}"),
    };
    let table = request
        .and_then(|request| request.points_from)
        .and_then(|table| Some(quoted(Path::new(table.file_name()?))))
        .unwrap_or_else(|| "TABLE.csv".to_owned());
    match (&p.fmu, p.method.as_str()) {
        (None, _) => format!("orchestrator judge {study} {table}{output}"),
        (_, "table") => format!("orchestrator verify {study} --points-from {table}{output}"),
        _ => {
            let seed = p.seed.map(|seed| format!(" --seed {seed}"));
            format!("orchestrator verify {study} --points {}{}{output}", summary.points, seed.unwrap_or_default())
        }
    }
}

/// Both paths as seen from the deepest folder that holds both.
fn below_common_folder(a: &Path, b: &Path) -> [PathBuf; 2] {
    let parts = |path: &Path| -> Vec<String> {
        let named = path.components().filter_map(|part| match part {
            Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
            _ => None,
        });
        named.collect()
    };
    let (a, b) = (parts(a), parts(b));
    let most = a.len().min(b.len()).saturating_sub(1);
    let same = (0..most).take_while(|&k| a[k] == b[k]).count();
    [&a, &b].map(|parts| parts[same..].iter().collect())
}

/// A path for a shell.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "-_./".contains(c);
    if text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_those_below_the_common_folder() {
        let paths = |a: &str, b: &str| below_common_folder(Path::new(a), Path::new(b)).map(|path| quoted(&path));
        let expected = ["studies/a.toml", "results/a"].map(String::from);
        assert_eq!(paths("/home/x/studies/a.toml", "/home/x/results/a"), expected);
        assert_eq!(paths("/x/a.toml", "/x/a"), ["a.toml", "a"].map(String::from));
        assert_eq!(paths("/x/my study.toml", "/x/o")[0], "'my study.toml'");
    }
}
