//! Which causality, variability and `initial` go together: the tables of FMI 2.0.5, section 2.2.7, and FMI 3.0.2, section
//! 2.4.7, which hardly differ.

use fmu_import::Version;

/// Those of FMI 3.0; the first one is unknown to FMI 2.0.
const CAUSALITIES: [&str; 7] =
    ["structuralParameter", "parameter", "calculatedParameter", "input", "output", "local", "independent"];

const VARIABILITIES: [&str; 5] = ["constant", "fixed", "tunable", "discrete", "continuous"];

/// Whether the words are known. The reader remarks on others, and nothing follows from them.
pub fn are_known(version: Version, causality: &str, variability: &str) -> bool {
    let causalities = match version {
        Version::Two => &CAUSALITIES[1..],
        Version::Three => &CAUSALITIES,
    };
    causalities.contains(&causality) && VARIABILITIES.contains(&variability)
}

/// The variabilities that a variable of a causality may have.
pub fn variabilities(causality: &str) -> &'static [&'static str] {
    match causality {
        "parameter" | "calculatedParameter" | "structuralParameter" => &["fixed", "tunable"],
        "input" => &["discrete", "continuous"],
        "output" => &["constant", "discrete", "continuous"],
        "independent" => &["continuous"],
        _ => &VARIABILITIES,
    }
}

/// The values of `initial` that are allowed, the usual one first.
pub fn initials(version: Version, causality: &str, variability: &str) -> &'static [&'static str] {
    match (causality, variability) {
        ("independent", _) => &[],
        ("input", _) if version == Version::Two => &[],
        ("parameter" | "structuralParameter" | "input", _) | (_, "constant") => &["exact"],
        ("calculatedParameter", _) | ("local", "fixed" | "tunable") => &["calculated", "approx"],
        _ => &["calculated", "exact", "approx"],
    }
}

/// The remedy for an `initial` that is none of those allowed.
pub fn remedy(initials: &[&str]) -> String {
    match initials {
        [] => "remove it".to_owned(),
        some => format!("set it to {}", some.join(" or ")),
    }
}
