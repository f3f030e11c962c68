//! The criteria as text for a study.

use super::recording::{DerivedCriterion, Synchronised};
use std::fmt::Write as _;

/// The `[criteria]` of a study, with the uncertainty budget as comments. The uncertainty is expanded
/// (coverage factor 2); a recording cannot know how far the model may be off, so the tolerance is left to the user.
pub fn to_toml(result: &Synchronised, amplitudes: bool) -> String {
    let shift = match &result.delay.delay {
        Some(d) => format!(
            "torque shifted by {:.3} ms ({:.3} to {:.3} ms, 95 %)",
            1e3 * d.value,
            1e3 * d.low,
            1e3 * d.high
        ),
        None => "torque not shifted".to_owned(),
    };
    let [before, after] = result.friction_scatter.map(|part| 100.0 * part);
    let friction = result.mean_friction;
    let mut out = format!(
        "# From measured signals: {shift}, which leaves {after:.2} % scatter of\n\
         # the friction coefficient (before: {before:.2} %). Friction coefficient {} +- {} (k = 2).\n\
         # Uncertainties are expanded (k = 2) after the GUM. Add the tolerances: how far the model may be from the true\n\
         # values.\n",
        rounded(friction.value, friction.expanded()),
        rounded(friction.expanded(), friction.expanded()),
    );
    for warning in &result.warnings {
        let _ = writeln!(out, "# Note: {warning}.");
    }
    for finding in result
        .findings
        .iter()
        .filter(|f| amplitudes || f.statistic != "amplitude")
    {
        out.push_str(&criterion(finding));
    }
    out
}

fn criterion(finding: &DerivedCriterion) -> String {
    let m = &finding.measured;
    let uncertainty = m.expanded();
    let mut out = format!("\n[criteria.{}]\n", finding.name);
    let _ = writeln!(
        out,
        "# standard uncertainties: scatter {:.2e}, sensor {:.2e} {}",
        m.scatter, m.sensor, finding.unit
    );
    if let Some(s) = &finding.stationarity {
        let _ = writeln!(
            out,
            "# {}: change over the window {:.2e} ({:.2e} to {:.2e}) {}, from {} blocks",
            if s.steady() { "steady" } else { "NOT steady" },
            s.change.value,
            s.change.low,
            s.change.high,
            finding.unit,
            s.blocks
        );
    }
    let _ = writeln!(
        out,
        "variable = \"{}\"\nstatistic = \"{}\"",
        finding.variable, finding.statistic
    );
    let _ = writeln!(
        out,
        "nominal = {}\n# tolerance = \nuncertainty = \"{} {}\"\nunit = \"{}\"",
        rounded(m.value, uncertainty),
        rounded(uncertainty, uncertainty),
        finding.unit,
        finding.unit
    );
    if let Some(group) = &finding.group {
        let _ = writeln!(out, "group = \"{group}\"");
    }
    out
}

/// A value to two digits of its uncertainty, as a TOML float.
fn rounded(value: f64, uncertainty: f64) -> String {
    let digits = if uncertainty > 0.0 {
        (1.0 - uncertainty.log10().floor()).clamp(1.0, 12.0) as usize
    } else {
        6
    };
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
