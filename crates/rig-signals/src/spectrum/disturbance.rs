//! Disturbances that load and torque share and that move the delay between them.
//!
//! What both channels have in common between the harmonics of the shaft is the load at random, mains hum, or one channel that
//! leaks into the other.

use super::{Comb, LOBE, NEAR, memory, transform};
use crate::signal::Even;
use realfft::num_complex::Complex;
use sampling::statistics::moments::sorted;
use std::f64::consts::{LN_2, TAU};

/// What the window leaves of the highest line in all other bins, of power, with a margin.
const LEAK: f64 = 1e-8;
/// A line stands this many times above the noise around it in both channels: chance does that once in 1e10 bins.
const STANDS_OUT: f64 = 12.0;
/// Channels vary together from so many standard deviations on: chance does it once in 10,000 recordings.
const TOGETHER: f64 = 5.0;
/// The same at one delay that is known before.
const AT_ONCE: f64 = 3.5;
/// A line of the mains that hides behind a harmonic is so many times as strong as both harmonics next to it.
const ABOVE_NEXT: f64 = 4.0;
/// A line is turned by more than so many standard deviations: chance does it once in 370 lines.
const TURNED: f64 = 3.0;
/// A load is periodic if a bin of its harmonics tells so many times as much of the delay as one between them, where there is
/// nothing but noise and hum. A load at random has as much there.
const PERIODIC: f64 = 5.0;
/// Of the interval's half width, by this much the harmonics' own delay may differ, and by this much a disturbance may move the
/// delay: of a periodic load, and of one at random, whose content between the harmonics scatters both.
const APART: [f64; 2] = [0.5, 1.5];
const MOVES: [f64; 2] = [0.2, 0.4];
/// Channels that at the delay vary together by this part of the most at any are related by it alone.
const RELATED: f64 = 0.7;
/// Frequencies of the mains, Hz.
const MAINS: [f64; 2] = [50.0, 60.0];

impl Comb {
    /// Why the delay of the torque has no interval: what both channels share and is not the load, a sentence with its remedy.
    /// `half` is the interval's half width, `longest` the longest delay, and `kernel` the deviation of the search's kernel, s.
    pub fn disturbance(&self, both: [&Even; 2], [delay, half, longest, kernel]: [f64; 4]) -> Option<String> {
        let places = self.between();
        if places.len() < NEAR {
            return None;
        }
        let bins = both.map(|signal| transform(&signal.values));
        let levels = bins.each_ref().map(|bins| levels(bins, &places));
        let spectra = Spectra { comb: self, bins, places, levels, delay, half, kernel };
        let lines = spectra.lines();
        let harmonics = spectra.harmonics(&lines);
        spectra
            .hum(&lines, &harmonics)
            .or_else(|| spectra.leak(&lines, &harmonics, longest))
            .or_else(|| spectra.dispersion(harmonics.whole_curvature))
    }
}

/// The noise around each of the bins between the lines.
fn levels(bins: &[Complex<f64>], places: &[usize]) -> Vec<f64> {
    let power = |&k: &usize| bins[k].norm_sqr();
    let highest = bins.iter().map(Complex::norm_sqr).fold(0.0, f64::max);
    let around = |i: usize| {
        let from = i.saturating_sub(NEAR / 2).min(places.len() - NEAR);
        let near = sorted(places[from..from + NEAR].iter().map(power).collect());
        // The median of an exponential distribution is ln 2 of its mean.
        (near[NEAR / 2 - 1] + near[NEAR / 2]) / (2.0 * LN_2) + LEAK * highest
    };
    (0..places.len()).map(around).collect()
}

/// Load and torque between and at the harmonics of their shaft.
struct Spectra<'a> {
    comb: &'a Comb,
    bins: [Vec<Complex<f64>>; 2],
    /// The bins between the lines, and the noise around each of them.
    places: Vec<usize>,
    levels: [Vec<f64>; 2],
    /// The delay of the torque, half the width of its interval, and the deviation of the search's kernel, s.
    delay: f64,
    half: f64,
    kernel: f64,
}

/// Bins between the harmonics, or behind one, with a line in both channels.
struct CommonLines {
    all: Vec<usize>,
    /// Those whose phase the delay does not explain.
    unexplained: Vec<usize>,
}

/// What the shaft's harmonics alone tell of the delay.
struct Harmonics {
    /// The delay that they prefer, s, and whether it differs beyond chance.
    delay: f64,
    is_apart: bool,
    is_periodic: bool,
    /// The second derivative of the whole correlation by the delay.
    whole_curvature: f64,
}

fn is_near(lines: &[usize], k: usize) -> bool {
    lines.iter().any(|line| line.abs_diff(k) <= LOBE)
}

impl Spectra<'_> {
    /// The torque on the load, turned back by the delay: without an imaginary part where the delay explains it.
    fn cross(&self, k: usize) -> Complex<f64> {
        self.bins[0][k].conj() * self.bins[1][k] * self.comb.turned(k, self.delay)
    }

    /// The first two derivatives of the correlation by the delay, behind the kernel, from some bins.
    fn derivatives(&self, which: &dyn Fn(usize) -> bool) -> [f64; 2] {
        (1..self.bins[0].len()).filter(|&k| which(k)).fold([0.0; 2], |[pull, curvature], k| {
            let angular = TAU * k as f64 * self.comb.bin;
            let cross = (-(angular * self.kernel).powi(2)).exp() * self.cross(k);
            [pull - angular * cross.im, curvature - angular * angular * cross.re]
        })
    }

    /// Bins of the mains that hide behind a harmonic, and stand far above the harmonics next to it in both channels.
    fn mains(&self) -> Vec<usize> {
        let Some(shaft) = self.comb.shaft else { return Vec::new() };
        let power = |bins: &[Complex<f64>], place: f64| {
            let first = (place.round() as usize).saturating_sub(LOBE);
            bins.iter().skip(first).take(2 * LOBE + 1).map(Complex::norm_sqr).sum::<f64>()
        };
        let is_above = |bins: &Vec<Complex<f64>>, place: f64| {
            power(bins, place) > ABOVE_NEXT * (power(bins, place - shaft) + power(bins, place + shaft))
        };
        let hides = |place: &f64| {
            let harmonic = self.comb.line.get(place.round() as usize);
            matches!(harmonic, Some(Some(3..))) && self.bins.iter().all(|bins| is_above(bins, *place))
        };
        let places = MAINS.iter().map(|mains| mains / self.comb.bin);
        places.filter(hides).map(|place| place.round() as usize).collect()
    }

    fn lines(&self) -> CommonLines {
        let ([x, y], levels) = (&self.bins, &self.levels);
        let stands_out = |&(i, k): &(usize, usize)| {
            let [p, q] = [x, y].map(|bins| bins[k].norm_sqr());
            p > STANDS_OUT * levels[0][i] && q > STANDS_OUT * levels[1][i]
        };
        let is_turned = |&&(i, k): &&(usize, usize)| {
            let part = levels[0][i] / x[k].norm_sqr() + levels[1][i] / y[k].norm_sqr();
            self.cross(k).arg().abs() > TURNED * (part / 2.0).sqrt()
        };
        let common: Vec<(usize, usize)> = self.places.iter().copied().enumerate().filter(stands_out).collect();
        let mains = self.mains();
        CommonLines {
            all: common.iter().map(|line| line.1).chain(mains.iter().copied()).collect(),
            unexplained: common.iter().filter(is_turned).map(|line| line.1).chain(mains.iter().copied()).collect(),
        }
    }

    fn harmonics(&self, lines: &CommonLines) -> Harmonics {
        let is_harmonic = |k: usize| matches!(self.comb.line[k], Some(1..)) && !is_near(&lines.all, k);
        let is_other = |k: usize| self.comb.line[k].is_none() && !is_near(&lines.all, k);
        let usual = |which: &dyn Fn(usize) -> bool| {
            let count = (1..self.bins[0].len()).filter(|&k| which(k)).count();
            self.derivatives(which)[1] / count as f64
        };
        let is_periodic = usual(&is_harmonic) / usual(&is_other).abs() > PERIODIC;
        let [pull, curvature] = self.derivatives(&is_harmonic);
        let [_, whole_curvature] = self.derivatives(&|_| true);
        let delay = self.delay - pull / curvature;
        let farthest = APART[usize::from(!is_periodic)] * self.half * (whole_curvature / curvature).max(1.0).sqrt();
        Harmonics { delay, is_apart: (delay - self.delay).abs() > farthest, is_periodic, whole_curvature }
    }

    /// Whether a line that the load does not explain moves the delay.
    fn hum(&self, lines: &CommonLines, harmonics: &Harmonics) -> Option<String> {
        let [pull, _] = self.derivatives(&|k| is_near(&lines.unexplained, k));
        let [_, rest] = self.derivatives(&|k| !is_near(&lines.unexplained, k));
        let pulled = (pull / rest).abs();
        let (lines, moved) = if harmonics.is_apart && harmonics.is_periodic && !lines.all.is_empty() {
            (&lines.all, (harmonics.delay - self.delay).abs())
        } else if pulled > MOVES[usize::from(!harmonics.is_periodic)] * self.half {
            (&lines.unexplained, pulled)
        } else {
            return None;
        };
        let strength = |k: &usize| self.bins[0][*k].norm_sqr() * self.bins[1][*k].norm_sqr();
        let strongest = lines.iter().max_by(|a, b| strength(a).total_cmp(&strength(b)))?;
        let frequency = *strongest as f64 * self.comb.bin;
        Some(format!(
            "both channels have a line at {frequency:.1} Hz that the load does not explain, such as mains hum; it moves the delay by \
             about {:.2} ms, so no interval is stated: shield the cables, or set smoothing = {{ method = \"butterworth\", \
             cutoff = {:.0}, order = 4 }}",
            1e3 * moved,
            0.6 * frequency
        ))
    }

    /// Whether the channels vary together at another delay than the load's.
    fn leak(&self, lines: &CommonLines, harmonics: &Harmonics, longest: f64) -> Option<String> {
        let quiet: Vec<(usize, Complex<f64>)> = (self.places.iter().copied().enumerate())
            .filter(|(_, k)| !is_near(&lines.unexplained, *k))
            .map(|(i, k)| (k, self.cross(k) / (self.levels[0][i] * self.levels[1][i]).sqrt()))
            .collect();
        let power: f64 = quiet.iter().map(|(_, c)| c.norm_sqr()).sum();
        let deviation = (power * memory() / 2.0).sqrt();
        let together = |lag: f64| {
            let terms = quiet.iter().map(|(k, c)| (c * self.comb.turned(*k, lag - self.delay)).re);
            terms.sum::<f64>() / deviation
        };
        let most = (2.0 * longest / self.kernel).ceil().min(500.0);
        let (at, best) = (0..=2 * most as usize)
            .map(|k| (k as f64 / most - 1.0) * longest)
            .map(|lag| (lag, together(lag)))
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let best = best.abs();
        let is_related = together(self.delay) > RELATED * best;
        // What leaks does so at once: at this delay less is chance.
        let at_once = together(0.0).abs();
        let [between, lines] = if best > TOGETHER && !is_related {
            [at, self.delay]
        } else if at_once > AT_ONCE && !is_related {
            [0.0, self.delay]
        } else if best > TOGETHER && harmonics.is_apart {
            [at, harmonics.delay]
        } else {
            return None;
        };
        Some(format!(
            "between the harmonics of the shaft, load and torque vary together at a delay of {:.2} ms, and at the harmonics at {:.2} ms: \
             one channel leaks into the other, or both pick up the same disturbance, which moves the delay, so no interval is \
             stated: separate the channels' cables and amplifiers, or choose a smoothing that takes the disturbance out",
            1e3 * between,
            1e3 * lines
        ))
    }

    /// Whether the content between the shaft's harmonics contradicts a single delay. `curvature` is the second derivative of
    /// the whole correlation by the delay; where the content between the harmonics adds little to it, the answer is no.
    fn dispersion(&self, curvature: f64) -> Option<String> {
        let [x, y] = &self.bins;
        let angular = |k: usize| TAU * k as f64 * self.comb.bin;
        let between: f64 = self.places.iter().map(|&k| -angular(k).powi(2) * self.cross(k).re).sum();
        let free = NEAR as f64 / memory();
        let squares: Vec<f64> = self
            .places
            .chunks_exact(NEAR)
            .map(|group| {
                let power = |of: &[Complex<f64>]| group.iter().map(|&k| of[k].norm_sqr()).sum::<f64>();
                let mean = group.iter().map(|&k| self.cross(k)).sum::<Complex<f64>>() / (power(x) * power(y)).sqrt();
                2.0 * free * mean.im.powi(2) / (1.0 - mean.norm_sqr())
            })
            .collect();
        let count = squares.len() as f64;
        let too_much = squares.iter().sum::<f64>() > 1.1 * count + TOGETHER * (3.0 * count).sqrt();
        (too_much && between / curvature > 0.1).then(|| {
            "the phase between load and torque is not that of one delay at all frequencies: a disturbance is in both, or one \
             channel leaks into the other, so no interval is stated: separate the channels' cables and amplifiers"
                .to_owned()
        })
    }
}
