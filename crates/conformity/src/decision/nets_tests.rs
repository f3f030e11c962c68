//! How often intervals of a share hold where coordinates of a net hang together: the worst pairs and triples that a search
//! finds among 60 of them.

use super::*;
use sampling::design::cube;

const DIMENSIONS: usize = 60;

/// The coordinates of a band about the middle of their sum, and its half-width.
type Band = (Vec<usize>, f64);

fn pair(a: usize, b: usize) -> Band {
    (vec![a, b], 0.1)
}

fn triple(a: usize, b: usize, c: usize) -> Band {
    (vec![a, b, c], 0.13)
}

fn is_in((coordinates, half): &Band, point: &[f64]) -> bool {
    let sum: f64 = coordinates.iter().map(|&k| point[k]).sum();
    (sum - 0.5 * coordinates.len() as f64).abs() <= *half
}

/// By the density of a sum of two or three uniform numbers.
fn exact((coordinates, half): &Band) -> f64 {
    match coordinates.len() {
        1 => 2.0 * half,
        2 => 2.0 * half - half * half,
        _ => 1.5 * half - 2.0 / 3.0 * half.powi(3),
    }
}

/// The bands whose share in single nets of so many points scatters most, of all pairs and of some triples.
fn worst(points: u64, keep: usize) -> Vec<Band> {
    let nets: Vec<_> = (0..6).map(|seed| cube(DIMENSIONS, points, 900 + seed, 1).unwrap()).collect();
    let scatter = |band: &Band| -> f64 {
        let share = |net: &Vec<Vec<f64>>| net.iter().filter(|point| is_in(band, point)).count() as f64 / points as f64;
        nets.iter().map(|net| (share(net) - exact(band)).powi(2)).sum()
    };
    let pairs = (0..DIMENSIONS).flat_map(|b| (0..b).map(move |a| pair(a, b)));
    let triples = (0..DIMENSIONS).flat_map(|c| (1..c).map(move |b| triple((7 * b + c) % b, b, c)));
    let worst_of = |bands: Vec<Band>| {
        let mut bands: Vec<(f64, Band)> = bands.into_iter().map(|band| (scatter(&band), band)).collect();
        bands.sort_by(|a, b| b.0.total_cmp(&a.0));
        bands.into_iter().take(keep).map(|(_, band)| band).collect::<Vec<_>>()
    };
    [worst_of(pairs.collect()), worst_of(triples.collect()), vec![(vec![3], 0.05), (vec![40], 0.01)]].concat()
}

/// The least number of held intervals over all bands, and how many of all verdicts on neighbouring shares were wrong.
fn held(points: u64, replicates: u64, seeds: u64, keep: usize) -> (u64, u64) {
    let bands = worst(points / replicates, keep);
    let mut held = vec![0; bands.len()];
    let mut wrong = vec![0; bands.len()];
    for seed in 0..seeds {
        let cube = cube(DIMENSIONS, points, seed, replicates).unwrap();
        for (k, band) in bands.iter().enumerate() {
            let mut counts = vec![0; replicates as usize];
            for (i, point) in cube.iter().enumerate() {
                counts[i % replicates as usize] += u64::from(is_in(band, point));
            }
            let (ends, share) = (randomised(&counts, points, 0.95), exact(band));
            held[k] += u64::from(ends[0] <= share && share <= ends[1]);
            let higher = Rule { share: share * 1.0001, confidence: 0.95 };
            wrong[k] += u64::from(higher.decide(ends) == Decision::Verified);
        }
    }
    println!("{points} points, {replicates} nets, {seeds} seeds: {bands:?} held {held:?} wrong {wrong:?}");
    (held.into_iter().min().unwrap(), wrong.into_iter().max().unwrap())
}

#[test]
fn intervals_hold_for_the_worst_pairs_and_triples() {
    let (held, wrong) = held(128, 8, 100, 2);
    assert!(held >= 93 && wrong <= 5, "{held} {wrong}");
}

/// A single net, taken for independent points, holds far less often: why there is no interval of it.
#[test]
fn single_nets_do_not_count_as_independent_points() {
    let (held, _) = held(64, 1, 60, 2);
    assert!(held < 50, "{held}");
}

#[test]
#[ignore = "takes a minute"]
fn intervals_hold_for_the_worst_pairs_and_triples_at_every_size() {
    for points in [64, 128, 256, 512] {
        for replicates in [8, 16] {
            let (held, wrong) = held(points, replicates, 200, 4);
            assert!(held >= 186 && wrong <= 10, "{points} {replicates}: {held} {wrong}");
        }
    }
}
