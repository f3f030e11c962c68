//! A recording's noise, between the harmonics of its shaft.
//!
//! A load that comes again with every turn has lines at the harmonics of the shaft and nothing between them. So noise shows
//! between the lines.

mod disturbance;

use super::{
    scatter::{freedom, scatter},
    signal::Even,
};
use realfft::{RealFftPlanner, num_complex::Complex};
use sampling::statistics::moments::{mean, sorted};
use std::f64::consts::TAU;

/// Cosines of the four-term window of Harris (1978), "On the use of windows for harmonic analysis", Proc. IEEE 66: beyond four
/// bins a line leaves less than -92 dB.
const WINDOW: [f64; 4] = [0.358_75, -0.488_29, 0.141_28, -0.011_68];
/// Bins to either side of a line that it fills.
const LOBE: usize = 5;
/// Neighbours that tell the level of the noise, and the coherence.
const NEAR: usize = 32;

/// The noise of a channel's rows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Noise {
    /// The standard deviation of a row.
    pub row: f64,
    /// The deviation of independent rows that would tell as much of the signal: neighbouring rows may share their noise.
    pub equivalent: f64,
    /// The standard uncertainty of the ratio of their squares, where rows share nothing: few bins tell the one, many the other.
    pub of_ratio: f64,
    /// The degrees of freedom of the square of `row`.
    pub freedom: f64,
    /// The correlation of each row's noise with the next one's.
    pub correlation: f64,
}

impl Noise {
    /// The noise by the differences of neighbouring rows, for a signal of which no lines are known.
    pub(crate) fn by_rows(values: &[f64]) -> Option<Self> {
        let values: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        // What is left of digits is no noise.
        let digits = 1e-9 * values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let row = scatter(&values).filter(|row| *row > digits)?;
        Some(Self { row, equivalent: row, freedom: freedom(values.len())?, ..Self::default() })
    }

    /// Whether neighbouring rows share their noise: of a white one chance says so once in about 50 channels.
    pub fn is_shared(&self) -> bool {
        self.equivalent.powi(2) > (1.0 + 2.5 * self.of_ratio) * self.row.powi(2)
    }

    /// The deviation to state of a row where rows are taken for independent.
    pub fn stated(&self) -> f64 {
        if self.is_shared() { self.equivalent } else { self.row }
    }

    /// How many rows count as one with an independent noise of that deviation.
    pub fn rows(&self) -> f64 {
        (self.stated() / self.row).powi(2)
    }
}

/// A signal's frequencies in bins; the square of a bin has the mean of the variance of a row of white noise.
fn transform(values: &[f64]) -> Vec<Complex<f64>> {
    let n = values.len() as f64;
    let place = |k: usize| k as f64 - (n - 1.0) / 2.0;
    let centre = mean(values);
    let pairs = values.iter().enumerate();
    let slope = pairs.map(|(k, v)| place(k) * v).sum::<f64>() / (n * (n * n - 1.0) / 12.0);
    let window = window(values.len());
    let scale = window.iter().map(|w| w * w).sum::<f64>().sqrt();
    let mut tapered: Vec<f64> =
        values.iter().zip(&window).enumerate().map(|(k, (v, w))| (v - centre - slope * place(k)) * w / scale).collect();
    let transform = RealFftPlanner::new().plan_fft_forward(values.len());
    let mut bins = transform.make_output_vec();
    transform.process(&mut tapered, &mut bins).expect("the buffers are the planner's own");
    bins
}

fn window(n: usize) -> Vec<f64> {
    (0..n)
        .map(|k| {
            let turn = TAU * k as f64 / n as f64;
            WINDOW.iter().enumerate().map(|(m, a)| a * (m as f64 * turn).cos()).sum()
        })
        .collect()
}

/// By how much fewer bins are independent: the window spreads each over its neighbours.
fn memory() -> f64 {
    let window = window(1024);
    let power = |of: i32| window.iter().map(|w| w.powi(of)).sum::<f64>() / 1024.0;
    power(4) / power(2).powi(2)
}

/// Which bins belong to which harmonic.
pub struct Comb {
    /// The width of a bin, Hz.
    bin: f64,
    /// The frequency of the shaft in bins, where it turns.
    shaft: Option<f64>,
    /// The harmonic of each bin; 0 at low frequencies, where drift is; `None` between the lines.
    line: Vec<Option<usize>>,
}

impl Comb {
    /// The comb of a signal of a shaft whose turns take `turn` seconds, give or take the part `spread`.
    pub fn new(load: &Even, turn: Option<f64>, spread: f64) -> Self {
        let n = load.values.len();
        let bin = 1.0 / (n as f64 * load.step);
        let power: Vec<f64> = transform(&load.values).iter().map(Complex::norm_sqr).collect();
        let shaft = turn.map(|turn| refined(&power, 1.0 / (turn * bin)));
        // Shorter records leave nothing between the lines.
        let shaft = shaft.filter(|shaft| *shaft > 2.0 * LOBE as f64 + 2.0);
        let lowest = shaft.map_or(8.0, |shaft| shaft / 2.0);
        let line = |k: usize| {
            let place = k as f64;
            if place < lowest {
                return Some(0);
            }
            let shaft = shaft?;
            let harmonic = (place / shaft).round();
            let reach = LOBE as f64 + harmonic * (0.05 + spread * shaft);
            ((place - harmonic * shaft).abs() <= reach).then_some(harmonic as usize)
        };
        Self { bin, shaft, line: (0..power.len()).map(line).collect() }
    }

    fn between(&self) -> Vec<usize> {
        let bins = 0..self.line.len().saturating_sub(1);
        bins.filter(|&k| self.line[k].is_none()).collect()
    }

    /// The noise of a signal. What it shares with `other`, late by `delay` seconds, is none. `None` for a short record.
    pub fn noise(&self, signal: &Even, other: Option<(&Even, f64)>) -> Option<Noise> {
        let places = self.between();
        if places.len() < NEAR {
            return None;
        }
        let bins = transform(&signal.values);
        let mut density: Vec<f64> = bins.iter().map(Complex::norm_sqr).collect();
        if let Some((other, delay)) = other {
            let others = transform(&other.values);
            for group in places.chunks_exact(NEAR) {
                let left = 1.0 - self.coherence(&bins, &others, group, delay);
                // Chance makes unrelated channels seem coherent, in the mean by so much.
                let left = left / (1.0 - memory() / NEAR as f64);
                group.iter().for_each(|&k| density[k] *= left);
            }
        }
        let level = |places: &mut dyn Iterator<Item = &usize>| {
            let (sum, count) = places.fold((0.0, 0.0), |(sum, n), &k| (sum + density[k], n + 1.0));
            (sum / count, count)
        };
        let (row, all) = level(&mut places.iter());
        // A power has twice the square of its mean as the mean of its square.
        let squares: f64 = places.iter().map(|&k| density[k].powi(2)).sum();
        let freedom = 4.0 * (all * row).powi(2) / squares / memory();
        let turn = TAU / signal.values.len() as f64;
        let cosines = places.iter().map(|&k| ((turn * k as f64).cos(), density[k] - row));
        // The first of the cosines that the density is a sum of, by least squares, as some of the bins are left out.
        let (products, norm) = cosines
            .fold((0.0, 0.0), |(products, norm), (cosine, off)| (products + cosine * off, norm + cosine * cosine));
        // Of noise at frequencies where the signal does not vary a fit knows nothing.
        let (mut weighted, mut weights, mut variance) = (0.0, 0.0, 0.0);
        if let Some(shaft) = self.shaft {
            for harmonic in 1..=(self.line.len() as f64 / shaft) as usize {
                let [from, to] = [-0.5, 0.5].map(|off| (harmonic as f64 + off) * shaft);
                let (noise, count) = level(&mut places.iter().filter(|k| (from..to).contains(&(**k as f64))));
                let power: f64 = (0..density.len())
                    .filter(|&k| self.line[k] == Some(harmonic))
                    .map(|k| (density[k] - row).max(0.0))
                    .sum();
                if noise.is_finite() {
                    weighted += power * noise;
                    weights += power;
                    variance += power * power / count;
                }
            }
        }
        let (equivalent, variance) =
            if weights > 0.0 { (weighted / weights, variance / weights.powi(2) + 1.0 / all) } else { (row, 0.0) };
        Some(Noise {
            row: row.sqrt(),
            equivalent: equivalent.sqrt(),
            of_ratio: (memory() * variance).sqrt(),
            freedom,
            correlation: products / norm / (2.0 * row),
        })
    }

    /// The squared coherence of two channels in a group of bins.
    fn coherence(&self, one: &[Complex<f64>], other: &[Complex<f64>], group: &[usize], delay: f64) -> f64 {
        let cross: Complex<f64> = group.iter().map(|&k| one[k] * other[k].conj() * self.turned(k, -delay)).sum();
        let power = |of: &[Complex<f64>]| group.iter().map(|&k| of[k].norm_sqr()).sum::<f64>();
        let scale = power(one) * power(other);
        if scale > 0.0 { cross.norm_sqr() / scale } else { 0.0 }
    }

    /// By how much a bin turns in a time, s.
    fn turned(&self, k: usize, time: f64) -> Complex<f64> {
        Complex::cis(TAU * k as f64 * self.bin * time)
    }
}

/// The frequency of the shaft in bins: the middle of the line near the one that is told, where there is a line.
fn refined(power: &[f64], told: f64) -> f64 {
    let reach = (0.02 * told).max(3.0);
    let near = |from: f64, to: f64| {
        let [from, to] = [from, to].map(|place| place.max(1.0).min((power.len() - 1) as f64));
        from.round() as usize..to.round() as usize + 1
    };
    let highest = near(told - reach, told + reach).max_by(|a, b| power[*a].total_cmp(&power[*b]));
    let Some(highest) = highest else { return told };
    let usual = sorted(power.to_vec())[power.len() / 2];
    if power[highest] < 50.0 * usual {
        return told;
    }
    let lobe = near(highest as f64 - 4.0, highest as f64 + 4.0);
    let all: f64 = power[lobe.clone()].iter().sum();
    lobe.map(|k| k as f64 * power[k]).sum::<f64>() / all
}
