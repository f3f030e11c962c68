//! Names in sentences: suggestions for mistyped ones, units behind numbers.

/// Names here, each with those that other programs use for the same thing.
const ELSEWHERE: &str = include_str!("synonyms.txt");

/// Whether other programs use a name for what is called `own` here.
fn means(name: &str, own: &str) -> bool {
    let mut lines = ELSEWHERE.lines().filter_map(|line| line.split_once(": "));
    lines.any(|(here, elsewhere)| here == own && elsewhere.split(' ').any(|other| other == name))
}

/// The candidate that looks most like `name`, or that means the same, if any comes close.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    let candidates: Vec<&str> = candidates.into_iter().collect();
    if let Some(meant) = candidates.iter().find(|candidate| means(&wanted, candidate)) {
        return Some(meant);
    }
    candidates
        .into_iter()
        .map(|candidate| (closeness(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|(closeness, _)| *closeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// 1 for equal names; a name's last component counts like the whole name, so that
/// `clearance` finds `bearing.radialClearance`.
fn closeness(wanted: &str, candidate: &str) -> f64 {
    let last = candidate.rsplit('.').next().unwrap_or(candidate);
    let contained = if wanted.len() >= 4 && candidate.contains(wanted) { 0.9 } else { 0.0 };
    strsim::jaro_winkler(wanted, candidate).max(0.97 * strsim::jaro_winkler(wanted, last)).max(contained)
}

/// The half-sentence `; did you mean ...?`, or nothing.
pub fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}

/// A unit as it stands behind a number, with a blank; nothing where there is none.
pub fn behind(unit: Option<&str>) -> String {
    unit.map(|unit| format!(" {unit}")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_typing_errors_and_short_names() {
        let names = ["bearing.radialClearance", "load.preload", "load.damping"];
        assert_eq!(nearest("bearing.radialClearence", names), Some(names[0]));
        assert_eq!(nearest("clearance", names), Some(names[0]));
        assert_eq!(nearest("load.dampping", names), Some(names[2]));
        assert_eq!(nearest("zzz", names), None);
        assert_eq!(nearest("Gauss", ["uniform", "normal"]), Some("normal"));
        assert_eq!(nearest("gauss", names), None);
    }
}
