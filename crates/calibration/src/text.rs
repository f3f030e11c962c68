//! The result of an identification as text: for people, and as parameters for the next study.

use std::fmt::Write;

pub use super::digits::digits;
use super::digits::{cleared, enough, rounded, shown};
use super::failures::words;
use super::fit::{DOUBTFUL, Fit};
use super::influence::Influence;
use super::local::End;
use super::next;
use super::numerical::NumericalError;
use super::optima::Approximation;
use super::outcome::{CaseOutcome, DirectionOutcome, FreeOutcome, IdentificationOutcome, Residual};
use super::problem::{SharedKind, Spacing};
use super::rounds::ROUNDS;
use super::shared::SharedOutcome;
use super::surrogate;

/// The free parameters as the section `[fixed]` of a study, but for those that are no parameters of the model.
pub fn fixed_section(study: &str, place: usize, outcome: &IdentificationOutcome, others: &[String]) -> String {
    let misses = outcome.fit() == Fit::Misses;
    let mut text = match outcome.optima.len() {
        0 | 1 => format!(
            "# The optimum of {study}{}.\n[fixed]\n",
            if misses { ", which misses the measured values" } else { "" }
        ),
        of => format!(
            "# Optimum {} of {of} of {study}: {}.\n[fixed]\n",
            place + 1,
            match misses {
                true => "all miss the measured values",
                false => "the data do not tell which",
            }
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

/// A summary for people.
pub fn summary(outcome: &IdentificationOutcome) -> String {
    let parameters = match outcome.has_several() {
        true => several(outcome),
        false => parameters(&outcome.free, &on_ridges(outcome)),
    };
    let told = outcome.surrogate.as_ref();
    let (against, doubts) = match outcome.fit() {
        Fit::Misses => (doubts(outcome), String::new()),
        _ => (String::new(), doubts(outcome)),
    };
    [
        warning(outcome),
        against,
        parameters,
        undetermined(outcome),
        shared(outcome),
        notes(outcome),
        excluded(outcome),
        told.map(surrogate::text::summary).unwrap_or_default(),
        discrepancies(outcome),
        residuals(outcome),
        influence(outcome),
        outcome.next.as_ref().map(next::summary).unwrap_or_default(),
        goodness(outcome, &doubts),
    ]
    .concat()
}

/// What makes the parameters doubtful, however well they fit.
fn warning(outcome: &IdentificationOutcome) -> String {
    let doubt = outcome.numerical_error.as_ref().and_then(NumericalError::doubt);
    doubt.map_or_else(String::new, |doubt| format!("warning: {doubt}. {}\n\n", NumericalError::REMEDY))
}

/// All optima, where no single one is the value.
fn several(outcome: &IdentificationOutcome) -> String {
    let found = outcome.optima.len();
    let mut text = match outcome.fit() {
        Fit::Misses => format!("None of the {found} distinct sets of parameters found fits the measured values.\n"),
        _ => format!(
            "{found} distinct sets of parameters fit the measured values, and none of them is \"the\" value: further \
             measurements must decide.\n"
        ),
    };
    for (place, optimum) in outcome.optima.iter().enumerate() {
        text += &format!(
            "\noptimum {}: {:.3} % of the posterior, sum of squares {}, reached by {} searches\n",
            place + 1,
            100.0 * optimum.weight,
            digits(optimum.cost),
            optimum.reached
        );
        text += &parameters(&optimum.free, &[]);
    }
    text
}

/// The parameters that the data do not tell from others: those of a combination that they leave open.
fn on_ridges(outcome: &IdentificationOutcome) -> Vec<&str> {
    let open = outcome.directions.iter().filter(|d| d.undetermined);
    let together = open.filter(|direction| strong(direction).count() > 1);
    let names = together.flat_map(strong);
    names.map(|(name, _)| name.as_str()).collect()
}

/// The parameters with a considerable part in a direction.
fn strong(direction: &DirectionOutcome) -> impl Iterator<Item = &(String, f64)> {
    let weights = direction.weights.iter();
    weights.filter(|(_, weight)| weight.abs() > 0.3)
}

fn parameters(parameters: &[FreeOutcome], on_ridges: &[&str]) -> String {
    let names = parameters.iter().map(|free| free.name.len());
    let width = names.max().unwrap_or(0);
    let mut text = format!("{:width$}  {:>11}  95 % interval\n", "parameter", "value");
    for free in parameters {
        let (name, unit) = (&free.name, shown(&free.unit));
        let reach = free.interval[1] - free.interval[0];
        let number = |value| rounded(cleared(value, reach), enough(free.interval));
        let [value, low, high] = [free.value, free.interval[0], free.interval[1]].map(number);
        let remark = remark(free, on_ridges.contains(&name.as_str()));
        let interval = format!("{low} .. {high} {unit}");
        text += &format!("{name:width$}  {value:>11}  {}{remark}\n", interval.trim_end());
    }
    text
}

fn remark(free: &FreeOutcome, on_ridge: bool) -> String {
    if free.surrounded {
        let text = "; runs fail next to it on every side, so the interval is that of the prior";
        return text.to_owned();
    }
    let bound = free.at_bound.map_or_else(String::new, |side| match on_ridge {
        false => format!("; at its {side} bound"),
        // All places along the ridge fit alike, and the search has to end at one.
        true => format!("; the search ended at its {side} bound, but the data do not determine it, see below"),
    });
    let left = rounded(100.0 * free.left, 2);
    let ends = match free.approximation {
        Approximation::Holds => "",
        Approximation::Lengthened => "; lengthened to where the sum of squares has risen enough",
        Approximation::Bends => "; its valley bends, so it may reach farther",
    };
    format!("{bound}; the measurement has narrowed it to {left} % of what was open before{ends}")
}

/// What the data leave open, and whether a sample confirms the intervals.
fn undetermined(outcome: &IdentificationOutcome) -> String {
    let open = outcome.directions.iter().filter(|d| d.undetermined);
    let open: Vec<_> = open.collect();
    if open.is_empty() {
        return confirmed(outcome);
    }
    let which = if outcome.has_several() { " at optimum 1" } else { "" };
    let mut text = format!("\nThe data do not determine{which}:\n");
    for direction in open {
        let left = 100.0 * direction.left;
        let names: Vec<String> = strong(direction)
            .map(|(name, weight)| format!("{} {name}", if *weight < 0.0 { '-' } else { '+' }))
            .collect();
        text += &match &names[..] {
            [name] => format!("  {}: {left:.0} % of the prior's spread is left\n", &name[2..]),
            names => format!(
                "  {}: the data tell these parameters only together; where they change by these signs at once, {left:.0} % of \
                 the prior's spread is left\n",
                names.join(" ")
            ),
        };
    }
    text += match &outcome.posterior {
        None => {
            "  the intervals above are normal approximations, which may hold less often than 95 % then; --posterior 1000 samples \
             the posterior\n"
        }
        Some(sample) if sample.trusted => {
            "  the intervals above are normal approximations: take those of the sample below\n"
        }
        Some(_) => "",
    };
    text
}

/// Whether a sample of the posterior confirms the intervals of a search that has converged to a single optimum.
fn confirmed(outcome: &IdentificationOutcome) -> String {
    let clear = outcome.optima.iter().all(|optimum| optimum.edge.is_clear());
    if outcome.has_several() || !clear || outcome.end != End::Converged {
        return String::new();
    }
    let Some(sample) = &outcome.posterior else {
        return "\nIf the model is right, these intervals hold; they are normal approximations, which --posterior 1000 checks.\n".to_owned();
    };
    if !sample.populations.is_empty() {
        // The sample is of another problem: one with a common mean and spread.
        return String::new();
    }
    let pairs = outcome.free.iter().zip(&sample.free);
    let apart = pairs.map(|(free, marginal)| (&free.name[..], apart(free, &marginal.intervals)));
    let apart: Vec<(&str, f64)> = apart.collect();
    let other = apart.iter().filter(|(_, apart)| *apart > OFF);
    let other: Vec<&str> = other.map(|(name, _)| *name).collect();
    match (sample.trusted, &other[..]) {
        (false, _) => String::new(),
        (true, []) => format!(
            "\nA second calculation, by sampling, gives these intervals, too: no end is off by more than {} % of their length.\n",
            apart.iter().fold(1.0, |most, (_, apart)| (100.0 * apart).ceil().max(most))
        ),
        (true, other) => format!(
            "\nThe normal approximation does not hold for {}: take the intervals of the sample below.\n",
            other.join(", ")
        ),
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
    let [interval] = sampled else {
        return f64::INFINITY;
    };
    let [low, high] = interval.map(place);
    let ends = free.interval.map(place);
    (ends[0] - low).abs().max((ends[1] - high).abs()) / (high - low)
}

/// What is assumed beyond what is stated.
fn notes(outcome: &IdentificationOutcome) -> String {
    let lines = outcome.notes.iter().map(|note| format!("{note}\n"));
    let text: String = lines.collect();
    match text.is_empty() {
        true => text,
        false => format!("\n{text}"),
    }
}

/// What the shared errors of the measured channels are, by the data.
fn shared(outcome: &IdentificationOutcome) -> String {
    // The sample's, where there is one to rely on.
    let sampled = outcome.posterior.as_ref().filter(|sample| sample.trusted);
    let all = sampled.map_or(&outcome.shared, |sample| &sample.shared);
    let lines: Vec<String> = all.iter().map(of_channel).collect();
    let mut text = lines.concat();
    if !text.is_empty() {
        text = format!("\n{text}");
    }
    /// Without them a fit with a smaller probability of its misfit is none.
    const NONE: f64 = 0.001;
    let without = outcome.probability_without_shared;
    if outcome.probability.is_some_and(|p| p >= DOUBTFUL) && without.is_some_and(|p| p < NONE) {
        text +=
            "the fit is good only with these shared errors: without them no parameters explain the measured values\n";
    }
    text
}

/// A shared error in a line.
fn of_channel(error: &SharedOutcome) -> String {
    /// Where so much of the stated uncertainty is left, the data say nothing.
    const NOTHING: f64 = 0.9;
    let (factor, unit) = match error.kind {
        SharedKind::Offset => (1.0, shown(&error.unit)),
        SharedKind::Gain => (100.0, "%"),
        SharedKind::Scaled => (1.0, "of the stated uncertainties"),
    };
    let number = |value: f64| rounded(factor * value, 3);
    let limit = format!("{} {unit}", number(error.limit));
    let limit = limit.trim_end();
    if error.left > NOTHING {
        return format!(
            "These data cannot show whether the {} of {}'s sensor is off; up to +-{limit} is allowed, and the intervals include it.\n",
            error.kind.of_sensor(),
            error.name
        );
    }
    let side = if error.value < 0.0 { -1.0 } else { 1.0 };
    let value = format!("{} {unit}", number(side * error.value));
    let mut ends = error.interval.map(|end| side * end);
    ends.sort_by(f64::total_cmp);
    let [low, high] = ends.map(number);
    let beyond = match error.value.abs() > error.limit {
        true => ", which this is beyond: doubt the model or the sensor",
        false => "",
    };
    format!(
        "The sensor of {} most likely reads {} too {}{} ({low} .. {high}, 95 %{}); {}{beyond}.\n",
        error.name,
        value.trim_end(),
        if side < 0.0 { "low" } else { "high" },
        if error.kind == SharedKind::Gain { ", as a part of the value" } else { "" },
        if ends[0] <= 0.0 { ", which includes 0" } else { "" },
        match (error.coverage.powi(2) - 3.0).abs() < 1e-6 {
            true => format!("its limits of error are +-{limit}"),
            false => format!("its data sheet allows +-{limit} (k = {})", rounded(error.coverage, 3)),
        }
    )
}

/// Places where runs failed, and what that leaves open at the optima.
fn excluded(outcome: &IdentificationOutcome) -> String {
    let Some(excluded) = &outcome.excluded else {
        return String::new();
    };
    let [starts, lost] = excluded.starts;
    let mut text = format!(
        "\nRuns failed at {} of {} places, among them {lost} of {starts} starts, which are spread evenly between the bounds: \
         about {:.0} % of the space is excluded. An optimum may lie there; nothing is known of it.\n  all of them lie within \
         {}; last: {}\n",
        excluded.failed,
        excluded.asked,
        100.0 * lost as f64 / starts.max(1) as f64,
        words(&excluded.within),
        excluded.message
    );
    for (place, optimum) in outcome.optima.iter().enumerate() {
        let name = match outcome.has_several() {
            true => format!("optimum {}", place + 1),
            false => "the optimum".to_owned(),
        };
        let edge = optimum.edge;
        if optimum.free.iter().any(|free| free.surrounded) {
            text += &format!(
                "  runs fail all around {name}: it is the best place at which runs end, and no minimum is known\n"
            );
        } else if edge.blocked {
            text += &format!(
                "  {name} lies at the edge of these places: the sum of squares falls towards them, so it is no minimum, and \
                 its intervals do not hold\n"
            );
        } else if edge.failed > 0 {
            text += &format!(
                "  runs fail at {} of {} ends of the 95 % region of {name}: its intervals reach where nothing is known\n",
                edge.failed, edge.asked
            );
        }
    }
    text
}

/// The lines on the model's discrepancies.
fn discrepancies(outcome: &IdentificationOutcome) -> String {
    let mut text = String::new();
    for discrepancy in &outcome.discrepancies {
        let unit = match shown(&discrepancy.unit) {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let (name, deviation) = (&discrepancy.quantity, rounded(discrepancy.deviation, 3));
        let sampled = discrepancy.sampled.map_or_else(String::new, |(_, ends)| {
            let [low, high] = ends.map(|end| rounded(end, 3));
            format!("; 95 %: {low} .. {high}{unit}")
        });
        text += &match discrepancy.told {
            _ if !discrepancy.settled => format!(
                "\nthe discrepancy of the model in {name} is NOT determined: it still changed in the last of {ROUNDS} searches, to \
                 {deviation}{unit}{sampled}\n"
            ),
            true => format!(
                "\nthe model misses {name} by a discrepancy of its own: {deviation}{unit}, one standard deviation{sampled}\n"
            ),
            false => format!(
                "\nthe data cannot tell a discrepancy of the model in {name} from the accuracy of the measurement; most \
                 probable {deviation}{unit}{sampled}\n"
            ),
        };
    }
    if !outcome.discrepancies.is_empty() && outcome.posterior.is_none() {
        text += "the intervals take it as known; --posterior 1000 counts how uncertain it is\n";
    }
    text
}

/// The measured value that is missed most, where there are too many for a table.
fn largest(outcome: &IdentificationOutcome) -> String {
    let all = outcome.cases.iter().flat_map(|case| &case.residuals);
    let missed = |residual: &Residual| residual.missed().abs();
    let count = all.clone().count();
    let worst = all.max_by(|a, b| missed(a).total_cmp(&missed(b)));
    worst.map_or_else(String::new, |worst| {
        format!(
            "\n{count} measured values; the largest misfit is {} standard uncertainties{}, of {}\n",
            rounded(missed(worst), 3),
            match outcome.shared.is_empty() {
                true => "",
                false => ", shared errors taken out",
            },
            worst.quantity
        )
    })
}

fn residuals(outcome: &IdentificationOutcome) -> String {
    const MANY: usize = 12;
    if outcome.worst.len() > MANY {
        return largest(outcome);
    }
    if let ([case], false) = (&outcome.cases[..], outcome.worst.is_empty()) {
        return one_case(case, outcome);
    }
    let which = if outcome.has_several() { "\nAt optimum 1:" } else { "" };
    let mut text = format!("{which}\n{:>8}", "case");
    if let Some(first) = outcome.cases.first() {
        for latent in &first.latents {
            let short = latent.name.rsplit('.').next().unwrap_or_default();
            let _ = write!(text, "  {short:>15}");
        }
        for residual in &first.residuals {
            let _ = write!(text, "  {:>12} {:>9}", residual.quantity, "misfit");
        }
    }
    for case in &outcome.cases {
        let _ = write!(text, "\n{:>8}", case.label);
        for latent in &case.latents {
            let _ = write!(text, "  {:>15}", digits(latent.value));
        }
        for residual in &case.residuals {
            let predicted = digits(residual.predicted);
            let sign = if residual.difference >= 0.0 { "+" } else { "" };
            let difference = cleared(residual.difference, residual.accuracy);
            let misfit = sign.to_owned() + &rounded(difference, 3);
            let _ = write!(text, "  {predicted:>12} {misfit:>9}");
        }
    }
    text.push('\n');
    for worst in &outcome.worst {
        let (unit, difference) = (shown(&worst.unit), rounded(worst.difference, 3));
        // A measured value of 0 has no percentage.
        let relative = worst.relative.is_finite().then_some(100.0 * worst.relative);
        let percent = relative.map_or_else(String::new, |percent| format!(" ({percent:.2} %)"));
        text += &format!("largest misfit of {}: {difference} {unit}{percent}\n", worst.quantity);
    }
    text
}

/// The values of a single case, a line each.
fn one_case(case: &CaseOutcome, outcome: &IdentificationOutcome) -> String {
    let name = |residual: &Residual| residual.quantity.chars().count();
    let width = case.residuals.iter().map(name).max().unwrap_or(0).max(5);
    let which = match outcome.has_several() {
        true => "At optimum 1:\n",
        false => "",
    };
    let mut text = format!(
        "\n{which}{:width$}  {:>12}  {:>12}  {:>10}  in standard uncertainties\n",
        "value", "measured", "model", "misfit"
    );
    for (residual, worst) in case.residuals.iter().zip(&outcome.worst) {
        let [measured, predicted] = [residual.measured, residual.predicted].map(digits);
        let difference = cleared(residual.difference, residual.accuracy);
        text += &format!(
            "{:width$}  {measured:>12}  {predicted:>12}  {:>10}  {} {}\n",
            residual.quantity,
            rounded(difference, 3),
            rounded(cleared(residual.missed(), 1.0), 3),
            match shown(&worst.unit) {
                "" => String::new(),
                unit => format!("({unit})"),
            },
        );
    }
    let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
    lines.join("\n") + "\n"
}

/// The value that moves each parameter most, and the largest parts of its variance.
fn influence(outcome: &IdentificationOutcome) -> String {
    /// A smaller change is not worth a word.
    const LITTLE: f64 = 0.5;
    /// A smaller part is not worth a word.
    const SMALL: f64 = 0.05;
    let mut text = String::new();
    for Influence { parameter, values, budget } in &outcome.influence {
        let parts = budget.iter().filter(|part| part.share >= SMALL);
        let parts: Vec<String> = parts.map(|part| format!("{:.0} % {}", 100.0 * part.share, part.from)).collect();
        let moved = values.first().filter(|moved| moved.change.abs() >= LITTLE);
        let moved = moved.map_or_else(String::new, |moved| {
            format!(
                "; without {}{} it would change by {} of its standard deviations",
                moved.quantity,
                if outcome.cases.len() > 1 { format!(" of case {}", moved.case) } else { String::new() },
                rounded(moved.change.abs(), 2)
            )
        });
        text += &format!("\nvariance of {parameter}: {}{moved}", parts.join(", "));
    }
    if text.is_empty() { text } else { text + "\n" }
}

/// What speaks against the fit, a line each, once the search has converged.
fn doubts(outcome: &IdentificationOutcome) -> String {
    let converged = outcome.end == End::Converged;
    let doubts = converged.then(|| outcome.doubts()).into_iter().flatten();
    // A model is blamed where the search is sure of its optimum.
    let [lowest, searches] = [outcome.search.lowest(), outcome.search.minima.len()];
    let is_unsure = converged && outcome.fit() == Fit::Misses && 2 * lowest < searches;
    let search = is_unsure.then(|| {
        format!(
            "Only {lowest} of {searches} searches ended as low as this, so a lower minimum may have been missed: give more `starts` \
             in [identify] before you blame the model."
        )
    });
    let close = outcome.is_too_close().then(|| {
        "warning: a right model with the stated uncertainties fits so well in fewer than 1 of 1,000 tests: the uncertainties are too \
         large, or the measured values were made from a model."
            .to_owned()
    });
    search.into_iter().chain(doubts).chain(close).map(|doubt| doubt + "\n").collect()
}

fn goodness(outcome: &IdentificationOutcome, doubts: &str) -> String {
    let search = &outcome.search;
    format!(
        "\nsum of squares {} with {} degrees of freedom\n{doubts}{} starts screened ({} failed), {} followed down, {}\n{}",
        digits(outcome.cost),
        outcome.degrees_of_freedom,
        search.screened,
        search.failed,
        search.minima.len(),
        ends(outcome),
        match outcome.end {
            End::Converged => "",
            End::Rounds =>
                "the searches ended before they converged, and the values above would change further: state the model's \
                 discrepancy as a number, or give more cases\n",
            End::Iterations => "the search ended before it converged: give it more `iterations` in [identify]\n",
            End::Time => "the search ended before it converged; --resume goes on\n",
        }
    )
}

/// Where the local searches ended.
fn ends(outcome: &IdentificationOutcome) -> String {
    match &outcome.optima[..] {
        [only] => format!("{} of these to this minimum", only.reached),
        several => {
            let reached = several.iter().map(|optimum| optimum.reached.to_string());
            let reached: Vec<String> = reached.collect();
            format!("of these {} to the optima above", reached.join(", "))
        }
    }
}
