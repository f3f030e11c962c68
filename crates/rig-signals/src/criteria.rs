//! The criteria as text for a study.

use super::recording::{DerivedCriterion, Synchronised};

/// The `[criteria]` of a study, with the uncertainty budget as comments. The uncertainty is expanded
/// (coverage factor 2); a recording cannot know how far the model may be off, so the tolerance is left to the user.
pub fn to_toml(result: &Synchronised, amplitudes: bool) -> String {
    let shift = match result.delay.words() {
        Some(delay) => format!("torque shifted by {delay}"),
        None => "torque not shifted".to_owned(),
    };
    let [before, after] = result.friction_scatter.map(|part| 100.0 * part);
    let friction = result.mean_friction;
    let [value, uncertainty] =
        [friction.value, friction.expanded()].map(|number| rounded(number, friction.expanded()));
    let mut out = format!(
        "# From measured signals: {shift}, which leaves {after:.2} % scatter of\n\
         # the friction coefficient (before: {before:.2} %). Friction coefficient {value} +- {uncertainty} (k = 2).\n\
         # Uncertainties are expanded (k = 2) after the GUM. Add the tolerances: how far the model may be from the true\n\
         # values.\n"
    );
    for warning in &result.warnings {
        out += &format!("# Note: {warning}.\n");
    }
    let findings = result.findings.iter();
    let wanted = findings.filter(|f| amplitudes || f.statistic != "amplitude");
    out.extend(wanted.map(criterion));
    out.extend(shared(result));
    out
}

/// The correlation of a value that is a product with the speed, and the one that it follows from: both have that one's error.
fn shared(result: &Synchronised) -> Option<String> {
    let product = result.findings.iter().find(|f| f.from.is_some())?;
    let (name, from) = (&product.name, product.from.as_ref()?);
    let factor = result.findings.iter().find(|f| f.name == *from)?;
    let [m, p] = [&factor.measured, &product.measured];
    let coefficient = (p.value / m.value * m.combined() / p.combined()).clamp(-1.0, 1.0);
    coefficient.is_finite().then(|| {
        format!(
            "\n# {name} is {from} times the speed, so the error of {from} is in both.\n[[uncertainty-correlations]]\n\
             between = [\"{from}\", \"{name}\"]\ncoefficient = {coefficient:.4}\n"
        )
    })
}

fn criterion(finding: &DerivedCriterion) -> String {
    let DerivedCriterion {
        name,
        variable,
        statistic,
        unit,
        ..
    } = finding;
    let m = &finding.measured;
    let [value, uncertainty] = [m.value, m.expanded()].map(|number| rounded(number, m.expanded()));
    let steady = finding.stationarity.as_ref().map_or_else(String::new, |s| {
        let (word, change) = (if s.steady() { "steady" } else { "NOT steady" }, s.change);
        format!(
            "# {word}: change over the window {:.2e} ({:.2e} to {:.2e}) {unit}, from {} blocks\n",
            change.value, change.low, change.high, s.blocks
        )
    });
    let group = finding.group.as_ref();
    let group = group.map_or_else(String::new, |group| format!("group = \"{group}\"\n"));
    format!(
        "\n[criteria.{name}]\n# standard uncertainties: scatter {:.2e}, sensor {:.2e} {unit}\n{steady}\
         variable = \"{variable}\"\nstatistic = \"{statistic}\"\nnominal = {value}\n# tolerance = \n\
         uncertainty = \"{uncertainty} {unit}\"\nunit = \"{unit}\"\n{group}",
        m.scatter, m.sensor
    )
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
