//! The risk of criteria on measured curves, by draws of the curves within their uncertainty.

use super::Summary;
use conformity::{measured::DrawnConformity, risk::Risk};
use fmu_points::notices::Replicates;
use study::judge::{Criterion, Judge};

/// The conformance probabilities of a point's curves: the shares of the draws to which it conforms, and to which it does in all
/// of them. Draws of the same number belong together: curves of one recording share their errors, those of others are drawn
/// independently.
pub fn told(judge: &Judge, conforming: &[Replicates]) -> Option<DrawnConformity> {
    let known: Vec<(usize, &Replicates)> = (0..judge.criteria.len())
        .filter(|&k| judge.criteria[k].row_correlation.is_some())
        .zip(conforming)
        .filter(|(_, bits)| !bits.is_empty())
        .collect();
    let (_, first) = known.first()?;
    let mut all = vec![u64::MAX; first.len()];
    for (_, bits) in &known {
        all.iter_mut().zip(*bits).for_each(|(all, bits)| *all &= bits);
    }
    let each = known.iter().map(|&(k, bits)| (k, share(bits)));
    Some(DrawnConformity { each: each.collect(), all: share(&all) })
}

fn share(bits: &[u64]) -> f64 {
    let ones: u32 = bits.iter().map(|bits| bits.count_ones()).sum();
    f64::from(ones) / (64 * bits.len()) as f64
}

/// Why the risk of a curve is not stated; none where it is, and of a measured number.
pub fn not_stated(criterion: &Criterion, risk: Option<&Risk>, resampled: bool) -> Option<String> {
    let reason = match (criterion.metric, criterion.row_correlation) {
        (None, _) => return None,
        _ if risk.is_some() => return None,
        (_, None) => "its reference states no uncertainty",
        (_, Some(_)) if !resampled => {
            "the points come without the model's curves: `verify` compares these with draws of the reference, a table has the \
             metric's value alone"
        }
        (_, Some(_)) => {
            "iso18571 tells it up to 1,000 samples only, and where errors of single rows are not lost between even times: thin the \
             reference, and give even times or correlation = 1"
        }
    };
    Some(reason.to_owned())
}

/// Which errors the risk of the curves presumes: a sentence for each correlation.
pub fn presumed(summary: &Summary) -> Vec<String> {
    let mut curves: Vec<(f64, Vec<&str>)> = Vec::new();
    for (name, entry) in &summary.criteria {
        let (Some(_), Some(correlation)) = (&entry.risk, entry.criterion.row_correlation) else { continue };
        match curves.iter_mut().find(|(other, _)| *other == correlation) {
            Some((_, names)) => names.push(name),
            None => curves.push((correlation, vec![name])),
        }
    }
    curves.into_iter().map(|(correlation, names)| {
        let errors = match correlation {
            1.0 => {
                "share one error, such as an offset of the sensor; the noise of the rows is in the recording and not drawn again"
                    .to_owned()
            }
            0.0 => "have independent errors".to_owned(),
            other => format!("have errors with a correlation of {other}"),
        };
        format!("The risk presumes that all measured rows of {} {errors}.", names.join(", "))
    }).collect()
}
