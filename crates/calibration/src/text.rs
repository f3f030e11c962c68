//! The result of an identification in sentences, and as parameters for the next study.

use super::{
    failures::words,
    fit::FitVerdict,
    influence::Influence,
    local::End,
    optima::Approximation,
    outcome::{DirectionOutcome, FreeOutcome, IdentificationOutcome, Residual},
    problem::{SharedKind, Spacing},
    shared::SharedOutcome,
};
use result_document::format::{shown, significant};

/// A number with six significant digits.
pub fn digits(number: f64) -> String {
    significant(number, 6)
}

/// The free parameters as the section `[fixed]` of a study, but for those that are no parameters of the model.
pub fn fixed_section(study: &str, place: usize, outcome: &IdentificationOutcome, others: &[String]) -> String {
    let misses = outcome.fit() == FitVerdict::Misses;
    let mut text = match outcome.optima.len() {
        0 | 1 => format!(
            "# The optimum of {study}{}.\n[fixed]\n",
            if misses { ", which misses the measured values" } else { "" }
        ),
        of => format!(
            "# Optimum {} of {of} of {study}: {}.\n[fixed]\n",
            place + 1,
            if misses { "all miss the measured values" } else { "the data do not tell which" }
        ),
    };
    for free in
        outcome.optima.get(place).iter().flat_map(|optimum| &optimum.free).filter(|free| !others.contains(&free.name))
    {
        let (name, number) = (&free.name, digits(free.value));
        if free.of_case {
            text += "# under `fixed` of this case alone: ";
        }
        text += &match shown(&free.unit) {
            "" => format!("\"{name}\" = {number}\n"),
            unit => format!("\"{name}\" = \"{number} {unit}\"\n"),
        };
    }
    text
}

/// How many sets of parameters fit, where no single one is the value.
pub fn several(outcome: &IdentificationOutcome) -> Option<String> {
    let found = outcome.optima.len();
    outcome.has_several().then(|| match outcome.fit() {
        FitVerdict::Misses => format!("None of the {found} distinct sets of parameters found fits the measured values"),
        _ => format!("{found} distinct sets of parameters fit the measured values"),
    })
}

/// The parameters that the data do not tell from others: those of a combination that they leave open.
fn on_ridges(outcome: &IdentificationOutcome) -> Vec<&str> {
    outcome
        .directions
        .iter()
        .filter(|d| d.undetermined)
        .filter(|direction| strong(direction).count() > 1)
        .flat_map(strong)
        .map(|(name, _)| name.as_str())
        .collect()
}

/// The parameters with a considerable part in a direction.
fn strong(direction: &DirectionOutcome) -> impl Iterator<Item = &(String, f64)> {
    direction.weights.iter().filter(|(_, weight)| weight.abs() > 0.3)
}

/// What has to be known of the intervals of single parameters.
pub fn remarks(outcome: &IdentificationOutcome) -> Vec<String> {
    let on_ridges = on_ridges(outcome);
    let alone = !outcome.has_several();
    let free = outcome.free.iter().filter(|_| alone);
    together(free.filter_map(|free| Some((free.name.clone(), remark(free, on_ridges.contains(&free.name.as_str()))?))))
}

/// The same remark on several names in a line.
fn together(remarks: impl Iterator<Item = (String, String)>) -> Vec<String> {
    let mut all: Vec<(String, String)> = Vec::new();
    for (name, remark) in remarks {
        match all.iter_mut().find(|(_, other)| *other == remark) {
            Some((names, _)) => *names += &format!(", {name}"),
            None => all.push((name, remark)),
        }
    }
    all.into_iter().map(|(names, remark)| format!("{names}: {remark}")).collect()
}

fn remark(free: &FreeOutcome, on_ridge: bool) -> Option<String> {
    if free.surrounded {
        return Some("runs fail next to it on every side, so the interval is that of the prior".to_owned());
    }
    // All places along a ridge fit alike, and the search has to end at one.
    let bound = free
        .at_bound
        .filter(|_| on_ridge)
        .map(|side| format!("the search ended at its {side} bound, but the data do not determine it, see below"));
    let ends = match free.approximation {
        Approximation::Holds => None,
        Approximation::Lengthened => Some("lengthened to where the sum of squares has risen enough".to_owned()),
        Approximation::Bends => Some("its valley bends, so it may reach farther".to_owned()),
    };
    let all: Vec<String> = bound.into_iter().chain(ends).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// What the data leave open, and whether a sample confirms the intervals.
pub fn open(outcome: &IdentificationOutcome) -> Vec<String> {
    let open: Vec<_> = outcome.directions.iter().filter(|d| d.undetermined).collect();
    if open.is_empty() {
        return confirmed(outcome).into_iter().collect();
    }
    let which = if outcome.has_several() { " at optimum 1" } else { "" };
    let mut said = vec![format!("The data do not determine{which}:")];
    said.extend(together(open.into_iter().map(|direction| {
        let left = 100.0 * direction.left;
        let names: Vec<String> = strong(direction)
            .map(|(name, weight)| format!("{} {name}", if *weight < 0.0 { '-' } else { '+' }))
            .collect();
        match &names[..] {
            [name] => (name[2..].to_owned(), format!("{left:.0} % of the prior's spread is left")),
            names => {
                let remark = format!(
                    "the data tell these parameters only together; where they change by these signs at once, {left:.0} % of the \
                     prior's spread is left"
                );
                (names.join(" "), remark)
            }
        }
    })));
    let approximate = match &outcome.posterior {
        None => Some(
            "the intervals above are normal approximations, which may hold less often than 95 % then; --posterior 1000 samples the \
             posterior",
        ),
        Some(sample) if sample.trusted => {
            Some("the intervals above are normal approximations: take those of the sample")
        }
        Some(_) => None,
    };
    said.extend(approximate.map(str::to_owned));
    said
}

/// Whether a sample of the posterior confirms the intervals of a search that has converged to a single optimum.
fn confirmed(outcome: &IdentificationOutcome) -> Option<String> {
    let clear = outcome.optima.iter().all(|optimum| optimum.edge.is_clear());
    if outcome.has_several() || !clear || outcome.end != End::Converged || outcome.is_too_narrow() {
        return None;
    }
    let Some(sample) = &outcome.posterior else {
        return Some("If the model is right, these intervals hold; they are normal approximations, which --posterior 1000 checks.".to_owned());
    };
    if !sample.populations.is_empty() {
        // The sample is of another problem: one with a common mean and spread.
        return None;
    }
    let apart: Vec<(&str, f64)> = outcome
        .free
        .iter()
        .zip(&sample.free)
        .map(|(free, marginal)| (&free.name[..], apart(free, &marginal.intervals)))
        .collect();
    let other: Vec<&str> = apart.iter().filter(|(_, apart)| *apart > OFF).map(|(name, _)| *name).collect();
    match (sample.trusted, &other[..]) {
        (false, _) => None,
        (true, []) => Some(format!(
            "A second calculation, by sampling, gives these intervals, too: no end is off by more than {} % of their length.",
            apart.iter().fold(1.0, |most, (_, apart)| (100.0 * apart).ceil().max(most))
        )),
        (true, other) => Some(format!(
            "The normal approximation does not hold for {}: take the intervals of the sample.",
            other.join(", ")
        )),
    }
}

/// A sample's interval is another one where an end is off by more than this part of its length, which no finite sample is by
/// chance.
const OFF: f64 = 0.15;

/// By which part of a sample's interval an end is off; infinite where that is several.
fn apart(free: &FreeOutcome, sampled: &[[f64; 2]]) -> f64 {
    let place = |value: f64| match free.scale {
        Spacing::Linear => value,
        Spacing::Log => value.ln(),
    };
    let [interval] = sampled else { return f64::INFINITY };
    let [low, high] = interval.map(place);
    let ends = free.interval.map(place);
    (ends[0] - low).abs().max((ends[1] - high).abs()) / (high - low)
}

/// What the shared errors of the measured channels are, by the data.
pub fn shared(outcome: &IdentificationOutcome) -> Vec<String> {
    // The sample's, where there is one to rely on.
    let sampled = outcome.posterior.as_ref().filter(|sample| sample.trusted);
    let all = sampled.map_or(&outcome.shared, |sample| &sample.shared);
    all.iter().map(|error| of_channel(error, outcome.interval())).collect()
}

/// A shared error in a line.
fn of_channel(error: &SharedOutcome, interval: &str) -> String {
    /// Where so much of the stated uncertainty is left, the data say nothing.
    const NOTHING: f64 = 0.9;
    let (factor, unit) = match error.kind {
        SharedKind::Offset => (1.0, shown(&error.unit)),
        SharedKind::Gain => (100.0, "%"),
        SharedKind::Scaled => (1.0, "of the stated uncertainties"),
    };
    let number = |value: f64| significant(factor * value, 3);
    let limit = format!("{} {unit}", number(error.limit));
    let limit = limit.trim_end();
    if error.left > NOTHING {
        return format!(
            "These data cannot show whether the {} of {}'s sensor is off; up to +-{limit} is allowed, and the intervals include it.",
            error.kind.of_sensor(),
            error.name
        );
    }
    let side = if error.value < 0.0 { -1.0 } else { 1.0 };
    let value = format!("{} {unit}", number(side * error.value));
    let mut ends = error.interval.map(|end| side * end);
    ends.sort_by(f64::total_cmp);
    let [low, high] = ends.map(number);
    let beyond =
        if error.value.abs() > error.limit { ", which this is beyond: doubt the model or the sensor" } else { "" };
    format!(
        "The sensor of {} most likely reads {} too {}{} ({low} .. {high}, {interval}{}); {}{beyond}.",
        error.name,
        value.trim_end(),
        if side < 0.0 { "low" } else { "high" },
        if error.kind == SharedKind::Gain { ", as a part of the value" } else { "" },
        if ends[0] <= 0.0 { ", which includes 0" } else { "" },
        if (error.coverage.powi(2) - 3.0).abs() < 1e-6 {
            format!("its limits of error are +-{limit}")
        } else {
            format!("its data sheet allows +-{limit} (k = {})", significant(error.coverage, 3))
        }
    )
}

/// Places where runs failed, and what that leaves open at the optima.
pub fn excluded(outcome: &IdentificationOutcome) -> Vec<String> {
    let Some(excluded) = &outcome.excluded else { return Vec::new() };
    let [starts, lost] = excluded.starts;
    let mut said = vec![format!(
        "Runs failed at {} of {} places, among them {lost} of {starts} starts, which are spread evenly between the bounds: \
         about {:.0} % of the space is excluded. An optimum may lie there; nothing is known of it. All of them lie within \
         {}; last: {}",
        excluded.failed,
        excluded.asked,
        100.0 * lost as f64 / starts.max(1) as f64,
        words(&excluded.within),
        excluded.message
    )];
    for (place, optimum) in outcome.optima.iter().enumerate() {
        let name = if outcome.has_several() { format!("optimum {}", place + 1) } else { "the optimum".to_owned() };
        let edge = optimum.edge;
        if optimum.free.iter().any(|free| free.surrounded) {
            said.push(format!(
                "runs fail all around {name}: it is the best place at which runs end, and no minimum is known"
            ));
        } else if edge.blocked {
            said.push(format!(
                "{name} lies at the edge of these places: the sum of squares falls towards them, so it is no minimum, and its \
                 intervals do not hold"
            ));
        } else if edge.failed > 0 {
            said.push(format!(
                "runs fail at {} of {} ends of the 95 % region of {name}: its intervals reach where nothing is known",
                edge.failed, edge.asked
            ));
        }
    }
    said
}

/// The largest misfit, where the values are too many for a table.
pub fn largest(outcome: &IdentificationOutcome) -> Option<String> {
    let all = outcome.cases.iter().flat_map(|case| &case.residuals);
    let missed = |residual: &Residual| residual.missed().abs();
    let worst = all.max_by(|a, b| missed(a).total_cmp(&missed(b)))?;
    Some(format!(
        "The largest misfit is {} standard uncertainties{}, of {}.",
        significant(missed(worst), 3),
        if outcome.shared.is_empty() { "" } else { ", shared errors taken out" },
        worst.quantity
    ))
}

/// The largest parts of each parameter's variance.
pub fn influence(outcome: &IdentificationOutcome) -> Vec<String> {
    /// A smaller part is not worth a word.
    const SMALL: f64 = 0.05;
    outcome
        .influence
        .iter()
        .map(|Influence { parameter, budget }| {
            let parts: Vec<String> = budget
                .iter()
                .filter(|part| part.share >= SMALL)
                .map(|part| format!("{:.0} % {}", 100.0 * part.share, part.from))
                .collect();
            format!("variance of {parameter}: {}", parts.join(", "))
        })
        .collect()
}

/// What speaks against the fit, a sentence each, once the search has converged. What one cause explains speaks against nothing else.
pub fn doubts(outcome: &IdentificationOutcome) -> Vec<String> {
    let converged = outcome.end == End::Converged;
    let doubts = (converged && !outcome.is_explained()).then(|| outcome.doubts()).into_iter().flatten();
    // A model is blamed where the search is sure of its optimum.
    let [lowest, searches] = [outcome.search.lowest(), outcome.search.minima.len()];
    let is_unsure =
        converged && outcome.fit() == FitVerdict::Misses && searches > 1 && lowest < searches.div_ceil(2).max(2);
    let search = is_unsure.then(|| {
        format!(
            "Only {lowest} of {searches} searches ended as low as this, so a lower minimum may have been missed: give more `starts` \
             in [identify] before you blame the model."
        )
    });
    let close = outcome.is_too_close().then(|| {
        "A right model with the stated uncertainties fits so well in fewer than 1 of 1,000 tests: the uncertainties are too large, or \
         the measured values were made from a model."
            .to_owned()
    });
    search.into_iter().chain(doubts).chain(close).collect()
}

/// The searches, and how one goes on that ended too early.
pub fn searches(outcome: &IdentificationOutcome) -> Vec<String> {
    let search = &outcome.search;
    let done = format!(
        "{} starts screened ({} failed), {} followed down, {}.",
        search.screened,
        search.failed,
        search.minima.len(),
        ends(outcome)
    );
    let early = match outcome.end {
        End::Converged => None,
        End::Iterations => Some("The search ended before it converged: give it more `iterations` in [identify]."),
        End::Budget => Some("The search ended before it converged, as the runs were spent: give it more."),
    };
    [done].into_iter().chain(early.map(str::to_owned)).collect()
}

/// Where the local searches ended.
fn ends(outcome: &IdentificationOutcome) -> String {
    match &outcome.optima[..] {
        [only] => format!("{} of these to this minimum", only.reached),
        several => {
            let reached: Vec<String> = several.iter().map(|optimum| optimum.reached.to_string()).collect();
            format!("of these {} to the optima above", reached.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_true_of_several_stands_once() {
        let remarks = [("a", "90 % left"), ("b", "50 % left"), ("c", "90 % left")];
        let told = together(remarks.into_iter().map(|(name, remark)| (name.to_owned(), remark.to_owned())));
        assert_eq!(told, ["a, c: 90 % left", "b: 50 % left"]);
    }
}
