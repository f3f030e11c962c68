//! The criteria as text for a study.

use super::{
    case::text::quoted,
    recording::{DerivedCriterion, Synchronised},
};

/// The `[criteria]` of a study, with the uncertainty budget as comments. The uncertainty is expanded
/// (coverage factor 2); a recording cannot know how far the model may be off, so the tolerance is left to the user.
pub fn to_toml(result: &Synchronised) -> String {
    let mut out = if result.friction.is_empty() { "# From measured signals.\n".to_owned() } else { friction(result) };
    out += "# Uncertainties are expanded (k = 2) after the GUM. Add the tolerances: how far the model may be from the true\n\
            # values.\n";
    out.extend(result.warnings.iter().map(|warning| format!("# Note: {warning}.\n")));
    out.extend(result.accounts.iter().map(|account| format!("# {account}.\n")));
    out.extend(result.findings.iter().map(criterion));
    out
}

/// What the shift of the torque leaves of the scatter of the friction coefficient.
fn friction(result: &Synchronised) -> String {
    let shift = match result.delay.words() {
        Some(delay) => format!("torque shifted by {delay}"),
        None => "torque not shifted".to_owned(),
    };
    let [before, after] = result.friction_scatter.map(|part| 100.0 * part);
    let friction = result.mean_friction;
    let [value, uncertainty] = [friction.value, friction.expanded()].map(|number| rounded(number, friction.expanded()));
    format!(
        "# From measured signals: {shift}, which leaves {after:.2} % scatter of\n\
         # the friction coefficient (before: {before:.2} %). Friction coefficient {value} +- {uncertainty} (k = 2).\n"
    )
}

fn criterion(finding: &DerivedCriterion) -> String {
    let DerivedCriterion { name, variable, unit, .. } = finding;
    let m = &finding.measured;
    let [value, uncertainty] = [m.value, m.expanded()].map(|number| rounded(number, m.expanded()));
    let steady = finding
        .stationarity
        .as_ref()
        .map(|s| format!("{}, from {} blocks\n", s.comment("NOT steady", unit), s.blocks))
        .unwrap_or_default();
    let group = finding.group.as_ref();
    let group = group.map(|group| format!("group = \"{group}\"\n")).unwrap_or_default();
    format!(
        "\n[criteria.{}]\n# standard uncertainties: scatter {:.2e}, sensor {:.2e} {unit}\n{steady}\
         variable = \"{variable}\"\nstatistic = \"mean\"\nnominal = {value}\n# tolerance = \n\
         uncertainty = \"{uncertainty} {unit}\"\nunit = \"{unit}\"\n{group}",
        key(name),
        m.scatter,
        m.sensor
    )
}

/// A name as a key of TOML.
fn key(name: &str) -> String {
    if !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c)) {
        name.to_owned()
    } else {
        quoted(name)
    }
}

/// A value to two digits of its uncertainty, as a TOML float.
fn rounded(value: f64, uncertainty: f64) -> String {
    let digits = if uncertainty > 0.0 { (1.0 - uncertainty.log10().floor()).clamp(1.0, 12.0) as usize } else { 6 };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn values_have_the_digits_that_their_uncertainty_leaves() {
        assert_eq!(rounded(749.873_21, 8.66), "749.9");
        assert_eq!(rounded(0.443_123, 0.012), "0.443");
        assert_eq!(rounded(0.012, 0.012), "0.012");
    }
}
