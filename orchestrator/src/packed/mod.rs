//! Studies that an FMU carries, with their results: files after the layered standard FMI-LS-REF, tied to the FMU by digests.

mod manifest;

use std::{
    fs,
    path::{Component, Path, PathBuf},
};

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{
    error::{Error, Result},
    results::Summary,
    session::Request,
};
use fmu_import::{Package, digest, percent_encoded};
use manifest::Related;
use point_journal::files::{draft, keep, make_folder, make_output, write_text};
use study::Study;
use tempfile::TempDir;

/// The folder of the related files in an FMU.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref/";
/// The manifest of the related files.
const MANIFEST: &str = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml";
/// The folder of a study's results.
const RESULT: &str = "results/";
/// The file that ties a study to the FMU.
const TIES: &str = "ties.json";
/// The largest size of all files of a study, bytes: what is larger is no study but an archive that fills a disk.
const MOST_UNPACKED: usize = 1 << 30;
/// The results of a study that travel with it: the file, its role, its type, and what it is.
const RESULTS: [(&str, &str, &str, &str); 5] = [
    ("points.csv", "result", "text/csv", "the points"),
    ("summary.json", "result", "application/json", "the verdict, with all that it rests on"),
    ("best.ssv", "parameter", "application/x-ssp-parameter-set", "the parameters nearest to the measurement"),
    ("best-point.csv", "result", "text/csv", "the trajectory with these parameters"),
    ("report.html", "report", "text/html", "the page"),
];

/// How a study was run, and which files of the FMU it was run with.
#[derive(Serialize, Deserialize)]
pub struct Ties {
    /// The study, below its folder in the FMU.
    pub study: String,
    /// How many points; none where the study or its table says it.
    pub points: Option<u64>,
    /// The design's seed, where it is another one than the study's.
    pub seed: Option<u64>,
    /// The table of points, where there is one.
    pub points_from: Option<String>,
    /// Whether the numerical uncertainty is stated.
    pub validation: bool,
    /// The SHA-256 digests of the files that a simulation depends on.
    pub files: IndexMap<String, String>,
    /// Those of the files that were packed, by their paths below the study's folder.
    #[serde(default)]
    pub packed: IndexMap<String, String>,
}

/// A study that an FMU carries.
pub struct Carried {
    /// Its name.
    pub name: String,
    /// How it was run.
    pub ties: Ties,
}

/// The digests of the files that a simulation depends on: description, binaries, resources.
///
/// # Errors
/// When one of them cannot be read.
pub fn digests(package: &mut Package) -> Result<IndexMap<String, String>> {
    let mut entries = package.entries();
    entries.retain(|entry| {
        let within = ["binaries/", "resources/"].iter().any(|folder| entry.starts_with(folder));
        !entry.ends_with('/') && (within || entry == "modelDescription.xml")
    });
    entries.sort_unstable();
    entries
        .into_iter()
        .map(|entry| {
            let bytes = package.bytes_of(&entry)?;
            Ok((entry, digest(&bytes)))
        })
        .collect()
}

/// What became of the files that a study was run with, in words.
pub fn changed(then: &IndexMap<String, String>, now: &IndexMap<String, String>) -> Vec<String> {
    let gone = then.iter().filter_map(|(file, digest)| match now.get(file) {
        None => Some(format!("{file} is gone")),
        Some(now) if now != digest => Some(format!("{file} is another one")),
        Some(_) => None,
    });
    let new = now.keys().filter(|file| !then.contains_key(*file));
    gone.chain(new.map(|file| format!("{file} is new"))).collect()
}

/// Which of the files that were packed with a study are other ones now, in words; none where their digests were not packed.
///
/// # Errors
/// When one of them cannot be read.
pub fn altered(package: &mut Package, carried: &Carried) -> Result<Vec<String>> {
    let mut now = IndexMap::new();
    for (entry, below) in files_of(package, &carried.name) {
        now.insert(below, digest(&package.bytes_of(&entry)?));
    }
    now.shift_remove(TIES);
    Ok(if carried.ties.packed.is_empty() { Vec::new() } else { changed(&carried.ties.packed, &now) })
}

/// The files of a study that a package carries: each entry, and its path within the study's folder.
fn files_of(package: &Package, name: &str) -> Vec<(String, String)> {
    let prefix = format!("{FOLDER}{name}/");
    let below = |entry: String| {
        let below = entry.strip_prefix(&prefix)?.to_owned();
        (!below.is_empty() && !below.ends_with('/')).then_some((entry, below))
    };
    package.entries().into_iter().filter_map(below).collect()
}

/// The manifest of a package, if it has one.
fn manifest_of(package: &mut Package) -> Result<Option<String>> {
    let is_there = package.entries().iter().any(|entry| entry == MANIFEST);
    let bytes = is_there.then(|| package.bytes_of(MANIFEST)).transpose()?;
    Ok(bytes.map(|bytes| String::from_utf8_lossy(&bytes).into_owned()))
}

/// The studies that an FMU carries, in the order in which they were packed.
///
/// # Errors
/// When what ties one of them to the FMU is damaged.
pub fn studies(package: &mut Package) -> Result<Vec<Carried>> {
    let entries = package.entries();
    let named = entries.iter().filter_map(|entry| {
        let name = entry.strip_prefix(FOLDER)?.strip_suffix(TIES)?.strip_suffix('/')?;
        (!name.contains('/')).then(|| name.to_owned())
    });
    let mut studies = Vec::new();
    for name in named.collect::<Vec<_>>() {
        let entry = format!("{FOLDER}{name}/{TIES}");
        let path = package.path().join(&entry);
        if !is_within(&name) {
            return Err(Error::content(&path, format!("`{name}` is no name of a folder on every system")));
        }
        let bytes = package.bytes_of(&entry)?;
        let ties: Ties = serde_json::from_slice(&bytes).map_err(|error| Error::content(&path, error))?;
        let named = [Some(&ties.study), ties.points_from.as_ref()];
        if let Some(file) = named.into_iter().flatten().find(|file| !is_within(file)) {
            return Err(Error::content(&path, format!("`{file}` is no path within the study's folder")));
        }
        studies.push(Carried { name, ties });
    }
    let order = manifest_of(package)?.unwrap_or_default();
    studies.sort_by_key(|study| order.find(&format!("\"{}/{TIES}\"", study.name)));
    Ok(studies)
}

/// The study of this name, or the one that was packed last.
///
/// # Errors
/// When there is none.
pub fn choose(package: &mut Package, name: Option<&str>) -> Result<(Carried, Vec<String>)> {
    let mut all = studies(package)?;
    let names: Vec<String> = all.iter().map(|study| study.name.clone()).collect();
    let path = package.path().display();
    let place = match name {
        None => all.len().checked_sub(1),
        Some(name) => names.iter().position(|known| known == name),
    };
    let Some(place) = place else {
        let message = match (name, names.is_empty()) {
            (Some(name), false) => {
                format!("{path} carries no study `{name}`, but {}", names.join(", "))
            }
            _ => format!(
                "{path}: is an FMU that carries no study; `orchestrator init {path}` writes one, `orchestrator pack` puts one \
                 into a copy"
            ),
        };
        return Err(Error::Refused(message));
    };
    let chosen = all.remove(place);
    let others = names.into_iter().filter(|name| *name != chosen.name).collect();
    Ok((chosen, others))
}

/// Whether a path of a carried file stays in the folder that it starts from, on every system: Windows takes `\\` for `/`, a
/// colon for a drive or a hidden stream, and leaves out dots and blanks at the end of a name.
fn is_within(path: &str) -> bool {
    path.split('/').all(|part| !part.is_empty() && !part.ends_with(['.', ' ']) && !part.contains(['\\', ':', '\0']))
}

/// The first file named by a carried study, which lies at `place`, that is none of those that came with it.
fn outside<'a>(study: &'a Study, place: &str) -> Option<&'a Path> {
    let depth = place.split('/').count() - 1;
    let stays = |file: &Path| {
        let foreign = file.is_absolute() || file.to_string_lossy().contains(['\\', ':']);
        !foreign && steps_up(file) <= depth
    };
    study.files().into_iter().find(|file| !stays(file))
}

/// Puts a carried study into the folder `carried` of its results, in the place of what an earlier run left there, when
/// `take` has found that the results may go there. Nothing is written there before: until then the files lie in a folder of
/// their own, which is returned where `take` takes none.
///
/// # Errors
/// When a file is damaged, leads out of its folder or reads there, when there is no result to compare with, those of `take`,
/// and when the system says no.
pub fn settle<T>(
    package: &mut Package,
    carried: &Carried,
    place: &Path,
    take: impl FnOnce(&Study) -> Result<Option<T>>,
) -> Result<Option<TempDir>> {
    let aside = TempDir::new().map_err(Error::io(&std::env::temp_dir()))?;
    unpack(package, &carried.name, aside.path())?;
    let of_package = package.path().join(format!("{FOLDER}{}", carried.name));
    for result in ["summary.json", "points.csv"] {
        if !aside.path().join(RESULT).join(result).exists() {
            return Err(Error::content(
                &of_package,
                format!("carries no {RESULT}{result} to compare with; `orchestrator pack` puts study and result in"),
            ));
        }
    }
    let study = Study::read(&aside.path().join(&carried.ties.study))?;
    if let Some(file) = outside(&study, &carried.ties.study) {
        return Err(Error::content(
            &of_package,
            format!("its study reads `{}`, which is none of the files that came with it", file.display()),
        ));
    }
    let Some(_taken) = take(&study)? else { return Ok(Some(aside)) };
    if place.symlink_metadata().is_ok() {
        if !place.join(TIES).exists() {
            return Err(Error::content(place, "was there before any FMU put its study here; choose another --output"));
        }
        fs::remove_dir_all(place).map_err(Error::io(place))?;
    }
    unpack(package, &carried.name, place)?;
    Ok(None)
}

/// Writes the files of a study that an FMU carries into a folder.
///
/// # Errors
/// When one of them is damaged or has a path that leads elsewhere, and when the system says no.
fn unpack(package: &mut Package, name: &str, folder: &Path) -> Result {
    let mut total = 0;
    for (entry, below) in files_of(package, name) {
        if !is_within(&below) {
            return Err(Error::content(&package.path().join(&entry), "a path that leads out of its folder"));
        }
        let bytes = package.bytes_of(&entry)?;
        total += bytes.len();
        if total > MOST_UNPACKED {
            return Err(Error::content(
                &package.path().join(format!("{FOLDER}{name}/")),
                format!("its files have more than {} MB together", MOST_UNPACKED >> 20),
            ));
        }
        let path = folder.join(&below);
        make_folder(path.parent().unwrap_or(folder))?;
        write_text(&path, bytes)?;
    }
    Ok(())
}

/// A study on its way into an FMU.
#[derive(Default)]
struct Packing {
    name: String,
    contents: Vec<(String, Vec<u8>)>,
    related: Vec<Related>,
    /// By their paths within the study's folder.
    digests: IndexMap<String, String>,
}

impl Packing {
    fn add(&mut self, below: &str, [role, kind]: [&'static str; 2], description: &str, content: Vec<u8>) {
        let source = format!("{}/{below}", self.name);
        self.digests.insert(below.to_owned(), digest(&content));
        self.contents.push((format!("{FOLDER}{source}"), content));
        let (source, description) = (percent_encoded(&source, "/"), description.to_owned());
        self.related.push(Related { kind, source, role, description });
    }
}

/// Puts a study with its results into a copy of an FMU, and returns its name. One of this name that the FMU carries is
/// replaced.
///
/// # Errors
/// When a file cannot be read or written, or lies where it cannot be packed.
pub fn pack(package: &mut Package, study: &Study, results: &Path, summary: &Summary, output: &Path) -> Result<String> {
    let stem = study.path().file_stem().unwrap_or_default().to_string_lossy();
    let name: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect();
    let request = Request::read(results)?;
    let mut packing = Packing { name, ..Packing::default() };
    let read = |path: &Path| fs::read(path).map_err(Error::io(path));
    let (place, data) = layout(study)?;
    let role = if study.parameters.is_empty() { "experiment/validation" } else { "experiment/uncertainty-analysis" };
    let title = format!("The study: {}", study.title.as_deref().unwrap_or(&stem));
    packing.add(&place, [role, "application/toml"], &title, read(study.path())?);
    for (path, below) in data {
        packing.add(&below, ["other", "text/csv"], "Data that the study names", read(&path)?);
    }
    let mut points_from = None;
    if let Some(table) = &request.points_from {
        let end = table.extension().unwrap_or("csv".as_ref());
        let below = format!("points.{}", end.to_string_lossy());
        packing.add(&below, ["other", "text/csv"], "The points' parameters", read(table)?);
        points_from = Some(below);
    }
    for (file, role, kind, what) in RESULTS {
        let path = results.join(file);
        if path.exists() {
            let about = format!("Of the study {}: {what}", packing.name);
            packing.add(&format!("{RESULT}{file}"), [role, kind], &about, read(&path)?);
        }
    }
    let counted = request.points_from.is_none();
    let ties = Ties {
        study: place,
        points: counted.then_some(summary.points),
        seed: request.seed,
        points_from,
        validation: summary.validation.values().any(|comparison| comparison.u_num.is_some()),
        files: digests(package)?,
        packed: packing.digests.clone(),
    };
    let about = "How the study was run, and the digests of the files that it was run with";
    packing.add(TIES, ["other", "application/json"], about, serde_json::to_vec_pretty(&ties)?);
    let Packing { name, mut contents, related, .. } = packing;
    let before = manifest_of(package)?;
    let own = format!("{name}/");
    let manifest = manifest::with(before.as_deref(), &own, &related)
        .map_err(|message| Error::content(&package.path().join(MANIFEST), message))?;
    contents.insert(0, (MANIFEST.to_owned(), manifest.into_bytes()));
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    make_output(folder)?;
    let copy = draft(folder).map_err(Error::io(output))?;
    let earlier = format!("{FOLDER}{own}");
    package.copy_with(copy.as_file(), |entry| entry.starts_with(&earlier), &contents)?;
    keep(copy, output)?;
    Ok(name)
}

/// Where a study and the files that it names lie in the FMU, such that it finds them as it does now: the study's place, and
/// each file's path with its place.
fn layout(study: &Study) -> Result<(String, Vec<(PathBuf, String)>)> {
    let mut files: Vec<&Path> = study.files();
    files.sort_unstable();
    files.dedup();
    let own = std::path::absolute(study.path()).map_err(Error::io(study.path()))?;
    let folder = own.parent().unwrap_or(Path::new(""));
    if let Some(file) = files.iter().find(|file| file.is_absolute()) {
        let message = "is an absolute path, which other machines do not have: name it from the study's folder";
        return Err(Error::content(study.path(), format!("{} {message}", file.display())));
    }
    let up = files.iter().map(|file| steps_up(file)).max().unwrap_or(0);
    let parts: Vec<String> = folder
        .components()
        .filter_map(|part| match part {
            Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
            _ => None,
        })
        .collect();
    let base: Vec<String> = parts[parts.len().saturating_sub(up)..].to_vec();
    let place = |file: &Path| {
        let mut below = base.clone();
        for part in file.components() {
            match part {
                Component::ParentDir => drop(below.pop()),
                Component::Normal(name) => below.push(name.to_string_lossy().into_owned()),
                _ => {}
            }
        }
        format!("study/{}", below.join("/"))
    };
    let named = files.iter().map(|file| (study.path_of(file), place(file)));
    Ok((place(Path::new(own.file_name().unwrap_or_default())), named.collect()))
}

/// How many folders a relative path leads up.
fn steps_up(file: &Path) -> usize {
    let (mut depth, mut up) = (0_usize, 0);
    for part in file.components() {
        match part {
            Component::ParentDir if depth == 0 => up += 1,
            Component::ParentDir => depth -= 1,
            Component::Normal(_) => depth += 1,
            _ => {}
        }
    }
    up
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_up_as_far_as_they_do() {
        for (path, up) in [("a.csv", 0), ("./b/a.csv", 0), ("../a.csv", 1), ("b/../../c/../../a.csv", 2)] {
            assert_eq!(steps_up(Path::new(path)), up, "{path}");
        }
    }

    #[test]
    fn only_paths_below_their_folder_are_within() {
        for (path, within) in [
            ("study/lag.toml", true),
            ("", false),
            ("/lag.toml", false),
            ("study/../../lag.toml", false),
            ("..\\lag.toml", false),
            ("study/C:lag.toml", false),
            ("study/.. /lag.toml", false),
            ("study//lag.toml", false),
            ("..", false),
        ] {
            assert_eq!(is_within(path), within, "{path}");
        }
    }

    #[test]
    fn files_that_changed_are_named() {
        let of = |files: &[(&str, &str)]| files.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
        let told = changed(&of(&[("a", "1"), ("b", "2"), ("c", "3")]), &of(&[("a", "1"), ("b", "4"), ("d", "5")]));
        assert_eq!(told, ["b is another one", "c is gone", "d is new"]);
    }
}
