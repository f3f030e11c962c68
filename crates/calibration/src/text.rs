//! The result of an identification as text: for people, and as parameters for the next study.

use std::fmt::Write;

use super::digits::shown;
pub use super::digits::{Digits, digits};
use super::failures::words;
use super::local::End;
use super::outcome::{DirectionOutcome, FreeOutcome, IdentificationOutcome, Residual};
use super::rounds::ROUNDS;
use super::surrogate;

/// The free parameters as the section `[fixed]` of a study.
pub fn fixed_section(study: &str, place: usize, outcome: &IdentificationOutcome) -> String {
    let mut text = match outcome.optima.len() {
        0 | 1 => format!("# The optimum of {study}.\n[fixed]\n"),
        of => format!(
            "# Optimum {} of {of} of {study}: the data do not tell which.\n[fixed]\n",
            place + 1
        ),
    };
    for free in outcome.optima.get(place).iter().flat_map(|own| &own.free) {
        let number = digits(free.value);
        let _ = match shown(&free.unit) {
            "" => writeln!(text, "\"{}\" = {number}", free.name),
            unit => writeln!(text, "\"{}\" = \"{number} {unit}\"", free.name),
        };
    }
    text
}

/// A summary for people.
pub fn summary(outcome: &IdentificationOutcome) -> String {
    let mut text = String::new();
    if outcome.ambiguous {
        several(&mut text, outcome);
    } else {
        parameters(&mut text, &outcome.free, &on_ridges(outcome));
    }
    undetermined(&mut text, outcome);
    excluded(&mut text, outcome);
    if let Some(told) = &outcome.surrogate {
        text += &surrogate::text::summary(told);
    }
    discrepancies(&mut text, outcome);
    residuals(&mut text, outcome);
    goodness(&mut text, outcome);
    text
}

/// All optima, where no single one is the value.
fn several(text: &mut String, outcome: &IdentificationOutcome) {
    let _ = writeln!(
        text,
        "{} distinct sets of parameters fit the measured values, and none of them is \"the\" value: further \
         measurements must decide.",
        outcome.optima.len()
    );
    for (place, own) in outcome.optima.iter().enumerate() {
        let _ = writeln!(
            text,
            "\noptimum {}: {:.3} % of the posterior, sum of squares {}, reached by {} searches",
            place + 1,
            100.0 * own.weight,
            digits(own.cost),
            own.reached
        );
        parameters(text, &own.free, &[]);
    }
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

fn parameters(text: &mut String, parameters: &[FreeOutcome], on_ridges: &[&str]) {
    let width = parameters
        .iter()
        .map(|free| free.name.len())
        .max()
        .unwrap_or(0);
    let _ = writeln!(
        text,
        "{:width$}  {:>11}  95 % interval",
        "parameter", "value"
    );
    for free in parameters {
        let unit = shown(&free.unit);
        let [low, high] = free.interval.map(digits);
        let _ = writeln!(
            text,
            "{:width$}  {:>11}  {low} .. {high} {unit}{}",
            free.name,
            digits(free.value),
            remark(free, on_ridges.contains(&free.name.as_str()))
        );
    }
}

fn remark(free: &FreeOutcome, on_ridge: bool) -> String {
    const LITTLE: f64 = 0.5;
    if free.surrounded {
        let text = "; runs fail next to it on every side, so the interval is that of the prior";
        return text.to_owned();
    }
    let bound = free.at_bound.map(|side| match on_ridge {
        false => format!("; at its {side} bound"),
        // All places along the ridge fit alike, and the search has to end at one.
        true => format!(
            "; the search ended at its {side} bound, but the data do not determine it, see below"
        ),
    });
    let prior = (free.left > LITTLE).then(|| {
        format!(
            "; the data leave {:.0} % of the prior's uncertainty",
            100.0 * free.left
        )
    });
    [bound, prior].into_iter().flatten().collect()
}

fn undetermined(text: &mut String, outcome: &IdentificationOutcome) {
    let open: Vec<_> = outcome
        .directions
        .iter()
        .filter(|d| d.undetermined)
        .collect();
    let which = if outcome.ambiguous {
        " at optimum 1"
    } else {
        ""
    };
    if open.is_empty() {
        // Around each of several optima they may do so; which one is right they do not tell. And a search that has not
        // converged tells of no optimum.
        let clear = outcome.optima.iter().all(|own| own.edge.is_clear());
        if !outcome.ambiguous && clear && outcome.end == End::Converged {
            let _ = writeln!(text, "\nThe data determine every parameter.");
        }
        return;
    }
    let _ = writeln!(text, "\nThe data do not determine{which}:");
    for direction in open {
        let left = 100.0 * direction.left;
        let names: Vec<String> = strong(direction)
            .map(|(name, weight)| format!("{} {name}", if *weight < 0.0 { '-' } else { '+' }))
            .collect();
        let _ = match names.len() {
            1 => writeln!(
                text,
                "  {}: {left:.0} % of the prior's uncertainty is left",
                &names[0][2..]
            ),
            _ => writeln!(
                text,
                "  {}: the data tell these parameters only together; where they change by these signs at once, {left:.0} % of \
                 the prior's uncertainty is left",
                names.join(" ")
            ),
        };
    }
    if outcome.posterior.is_none() {
        let _ = writeln!(
            text,
            "  the intervals above are normal approximations, which may hold less often than 95 % then; --posterior 1000 \
             samples the posterior"
        );
    }
}

/// Places where runs failed, and what that leaves open at the optima.
fn excluded(text: &mut String, outcome: &IdentificationOutcome) {
    let Some(own) = &outcome.excluded else { return };
    let [starts, lost] = own.starts;
    let _ = writeln!(
        text,
        "\nRuns failed at {} of {} places, among them {lost} of {starts} starts, which are spread evenly between the bounds: \
         about {:.0} % of the space is excluded. An optimum may lie there; nothing is known of it.",
        own.failed,
        own.asked,
        100.0 * lost as f64 / starts.max(1) as f64
    );
    let _ = writeln!(
        text,
        "  all of them lie within {}; last: {}",
        words(&own.within),
        own.message
    );
    for (place, optimum) in outcome.optima.iter().enumerate() {
        let name = match outcome.ambiguous {
            true => format!("optimum {}", place + 1),
            false => "the optimum".to_owned(),
        };
        if optimum.free.iter().any(|free| free.surrounded) {
            let _ = writeln!(
                text,
                "  runs fail all around {name}: it is the best place at which runs end, and no minimum is known"
            );
        } else if optimum.edge.blocked {
            let _ = writeln!(
                text,
                "  {name} lies at the edge of these places: the sum of squares falls towards them, so it is no minimum, and \
                 its intervals do not hold"
            );
        } else if optimum.edge.failed > 0 {
            let _ = writeln!(
                text,
                "  runs fail at {} of {} ends of the 95 % region of {name}: its intervals reach where nothing is known",
                optimum.edge.failed, optimum.edge.asked
            );
        }
    }
}

/// What the data say of the model's discrepancies.
fn discrepancies(text: &mut String, outcome: &IdentificationOutcome) {
    for own in &outcome.discrepancies {
        let unit = match shown(&own.unit) {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let name = &own.quantity;
        let deviation = Digits(own.deviation, 3);
        let sampled = own.sampled.map_or_else(String::new, |(_, [low, high])| {
            format!("; 95 %: {} .. {}{unit}", Digits(low, 3), Digits(high, 3))
        });
        let _ = match own.told {
            _ if !own.settled => writeln!(
                text,
                "\nthe discrepancy of the model in {name} is NOT determined: it still changed in the last of {ROUNDS} searches, to \
                 {deviation}{unit}{sampled}"
            ),
            true => writeln!(
                text,
                "\nthe model misses {name} by a discrepancy of its own: {deviation}{unit}, one standard deviation{sampled}"
            ),
            false => writeln!(
                text,
                "\nthe data cannot tell a discrepancy of the model in {name} from the accuracy of the measurement; most \
                 probable {deviation}{unit}{sampled}"
            ),
        };
    }
    if !outcome.discrepancies.is_empty() && outcome.posterior.is_none() {
        let _ = writeln!(
            text,
            "the intervals take it as known; --posterior 1000 counts how uncertain it is"
        );
    }
}

/// The measured value that is missed most, where there are too many for a table.
fn largest(text: &mut String, outcome: &IdentificationOutcome) {
    let all = outcome.cases.iter().flat_map(|case| &case.residuals);
    let missed = |residual: &&Residual| (residual.difference / residual.accuracy).abs();
    let count = all.clone().count();
    let Some(worst) = all.max_by(|a, b| missed(a).total_cmp(&missed(b))) else {
        return;
    };
    let _ = writeln!(
        text,
        "\n{count} measured values; the largest misfit is {} standard uncertainties, of {}",
        Digits(missed(&worst), 3),
        worst.quantity
    );
}

fn residuals(text: &mut String, outcome: &IdentificationOutcome) {
    const MANY: usize = 12;
    if outcome.worst.len() > MANY {
        return largest(text, outcome);
    }
    if outcome.ambiguous {
        let _ = write!(text, "\nAt optimum 1:");
    }
    let _ = write!(text, "\n{:>8}", "case");
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
            let _ = write!(
                text,
                "  {:>12} {:>+9}",
                digits(residual.predicted),
                Digits(residual.difference, 3)
            );
        }
    }
    let _ = writeln!(text);
    for worst in &outcome.worst {
        let unit = shown(&worst.unit);
        // A measured value of 0 has no percentage.
        let relative = worst.relative.is_finite().then_some(100.0 * worst.relative);
        let percent = relative.map_or_else(String::new, |percent| format!(" ({percent:.2} %)"));
        let _ = writeln!(
            text,
            "largest misfit of {}: {} {unit}{percent}",
            worst.quantity,
            Digits(worst.difference, 3),
        );
    }
}

fn goodness(text: &mut String, outcome: &IdentificationOutcome) {
    let IdentificationOutcome {
        cost,
        degrees_of_freedom,
        search,
        ..
    } = outcome;
    let _ = writeln!(
        text,
        "\nsum of squares {} with {degrees_of_freedom} degrees of freedom",
        digits(*cost)
    );
    const DOUBTFUL: f64 = 0.001;
    let doubtful = |probability| probability < DOUBTFUL;
    if outcome.end == End::Converged && outcome.probability.is_some_and(doubtful) {
        let _ = writeln!(
            text,
            "the model misses the measurement by more than the stated accuracies allow"
        );
    }
    let _ = writeln!(
        text,
        "{} starts screened ({} failed), {} followed down, {}",
        search.screened,
        search.failed,
        search.minima.len(),
        ends(outcome)
    );
    let _ = match outcome.end {
        End::Converged => Ok(()),
        End::Rounds => writeln!(
            text,
            "the searches ended before they converged, and the values above would change further: state the model's \
             discrepancy as a number, or give more cases"
        ),
        End::Iterations => writeln!(
            text,
            "the search ended before it converged: give it more `iterations` in [identify]"
        ),
        End::Time => writeln!(
            text,
            "the search ended before it converged; --resume goes on"
        ),
    };
}

/// Where the local searches ended.
fn ends(outcome: &IdentificationOutcome) -> String {
    match &outcome.optima[..] {
        [only] => format!("{} of these to this minimum", only.reached),
        several => {
            let reached = several.iter().map(|own| own.reached.to_string());
            let reached: Vec<String> = reached.collect();
            format!("of these {} to the optima above", reached.join(", "))
        }
    }
}
