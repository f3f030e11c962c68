//! Two searches that know nothing of each other. One that has lost a part of the event states too small a share with a narrow
//! interval, and nothing in it shows that; another one seldom loses the same part.

use super::{Answer, Ask, Method, Plain, Search, Share, Weighted, search_once};

/// The share by two searches, each with half of the runs.
pub(super) fn twice<E>(search: &Search, ask: Ask<'_, E>) -> Result<Answer, E> {
    let half = Search {
        runs: search.runs / 2,
        ..*search
    };
    let first = search_once(&half, ask)?;
    if matches!(&first.share, Some(share) if share.method == Method::Counted) {
        return Ok(first);
    }
    let other = Search {
        // Another stream of random numbers, far from the seeds that people give.
        seed: search.seed ^ 0x9e37_79b9_7f4a_7c15,
        ..half
    };
    Ok(joined(first, search_once(&other, ask)?))
}

/// The joint result of both searches.
fn joined(mut first: Answer, mut second: Answer) -> Answer {
    first.runs += second.runs;
    first.plain = sum(first.plain, second.plain);
    first.wider = sum(first.wider, second.wider);
    match (first.share.take(), second.share.take()) {
        (Some(one), Some(other)) => join(&mut first, one, other, second),
        (None, None) => {
            first.rough = first.rough.into_iter().chain(second.rough).reduce(f64::max);
        }
        // What one of them did not reach, the other may have met by chance.
        (Some(one), None) | (None, Some(one)) => {
            first.sample.clear();
            first.rough = Some(one.value);
        }
    }
    first
}

fn join(answer: &mut Answer, one: Share, other: Share, second: Answer) {
    let ends = |share: &Share| share.interval.unwrap_or([share.value; 2]);
    let ([low, high], [other_low, other_high]) = (ends(&one), ends(&other));
    if low > other_high || other_low > high {
        answer.sample.clear();
        answer.regions.clear();
        answer.disagree = Some([one.value.min(other.value), one.value.max(other.value)]);
        return;
    }
    let effective = one.effective + other.effective;
    let part = one.effective / effective;
    if other.effective > one.effective {
        answer.regions = second.regions;
    }
    let scaled = |points: Vec<Weighted>, by: f64| {
        points.into_iter().map(move |point| Weighted {
            weight: by * point.weight,
            ..point
        })
    };
    let more = scaled(second.sample, 1.0 - part);
    answer.sample = scaled(std::mem::take(&mut answer.sample), part)
        .chain(more)
        .collect();
    answer.rough = None;
    answer.share = Some(Share {
        value: part * one.value + (1.0 - part) * other.value,
        // Either interval alone holds the share as often as it says, so their union does.
        interval: Some([low.min(other_low), high.max(other_high)]),
        error: (part * one.error).hypot((1.0 - part) * other.error),
        effective,
        method: Method::Weighted,
    });
}

fn sum(one: Plain, other: Plain) -> Plain {
    Plain {
        runs: one.runs + other.runs,
        met: one.met + other.met,
        failed: one.failed + other.failed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(value: f64, interval: [f64; 2], effective: f64) -> Answer {
        Answer {
            share: Some(Share {
                value,
                interval: Some(interval),
                error: 0.1,
                effective,
                method: Method::Weighted,
            }),
            runs: 10,
            sample: vec![Weighted {
                scores: vec![0.0],
                weight: value,
            }],
            ..Answer::default()
        }
    }

    #[test]
    fn searches_that_agree_are_averaged_and_their_intervals_united() {
        let joined = joined(
            answer(1e-6, [8e-7, 1.3e-6], 100.0),
            answer(2e-6, [1.2e-6, 3e-6], 300.0),
        );
        let share = joined.share.unwrap();
        assert!((share.value - 1.75e-6).abs() < 1e-18);
        assert_eq!(share.interval, Some([8e-7, 3e-6]));
        assert_eq!((share.effective, joined.runs), (400.0, 20));
        let weights: f64 = joined.sample.iter().map(|point| point.weight).sum();
        assert!(
            (weights - share.value).abs() < 1e-18,
            "all points stand for the share"
        );
    }

    #[test]
    fn searches_that_disagree_tell_nothing_but_that() {
        let joined = joined(
            answer(1e-6, [8e-7, 1.3e-6], 100.0),
            answer(2e-6, [1.4e-6, 3e-6], 300.0),
        );
        assert_eq!((joined.share, joined.disagree), (None, Some([1e-6, 2e-6])));
        assert!(joined.sample.is_empty() && joined.regions.is_empty());
    }

    #[test]
    fn what_only_one_search_reaches_is_rough() {
        let joined = joined(answer(1e-6, [8e-7, 1.3e-6], 100.0), Answer::default());
        assert_eq!((joined.share, joined.rough), (None, Some(1e-6)));
        assert!(joined.sample.is_empty());
    }
}
