//! A recording between the harmonics of its shaft: noise, and disturbances that two channels share.
//!
//! A load that comes again with every turn has lines at the harmonics of the shaft and nothing between them. So noise shows
//! between the lines, and what both channels have in common there is the load at random, mains hum, or one channel that
//! leaks into the other.

use super::{
    scatter::{freedom, scatter},
    signal::Even,
};
use realfft::{RealFftPlanner, num_complex::Complex};
use sampling::statistics::moments::{mean, sorted};
use std::f64::consts::{LN_2, TAU};

/// Cosines of the four-term window of Harris (1978), "On the use of windows for harmonic analysis", Proc. IEEE 66: beyond four
/// bins a line leaves less than -92 dB.
const WINDOW: [f64; 4] = [0.358_75, -0.488_29, 0.141_28, -0.011_68];
/// Bins to either side of a line that it fills.
const LOBE: usize = 5;
/// What the window leaves of the highest line in all other bins, of power, with a margin.
const LEAK: f64 = 1e-8;
/// Neighbours that tell the level of the noise, and the coherence.
const NEAR: usize = 32;
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

    /// Why the delay of the torque has no interval: what both channels share and is not the load, a sentence with its remedy.
    /// `half` is the interval's half width, `longest` the longest delay, and `kernel` the deviation of the search's kernel, s.
    pub fn disturbance(&self, both: [&Even; 2], [delay, half, longest, kernel]: [f64; 4]) -> Option<String> {
        let places = self.between();
        if places.len() < NEAR {
            return None;
        }
        let bins = both.map(|signal| transform(&signal.values));
        let levels = bins.each_ref().map(|bins| self.levels(bins, &places));
        let spectra = Spectra { comb: self, bins, places, levels, delay, half, kernel };
        let lines = spectra.lines();
        let harmonics = spectra.harmonics(&lines);
        spectra
            .hum(&lines, &harmonics)
            .or_else(|| spectra.leak(&lines, &harmonics, longest))
            .or_else(|| spectra.dispersion(harmonics.whole_curvature))
    }

    /// The noise around each of the bins between the lines.
    fn levels(&self, bins: &[Complex<f64>], places: &[usize]) -> Vec<f64> {
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

    /// Bins of the mains that hide behind a harmonic, and stand far above the harmonics next to it in both channels.
    fn mains(&self, both: [&[Complex<f64>]; 2]) -> Vec<usize> {
        let Some(shaft) = self.shaft else { return Vec::new() };
        let power = |bins: &[Complex<f64>], place: f64| {
            let middle = place.round() as usize;
            bins.iter().skip(middle.saturating_sub(LOBE)).take(2 * LOBE + 1).map(Complex::norm_sqr).sum::<f64>()
        };
        MAINS
            .iter()
            .map(|mains| mains / self.bin)
            .filter(|&place| {
                let middle = place.round() as usize;
                let hides = matches!(self.line.get(middle), Some(Some(3..)));
                hides
                    && both.iter().all(|bins| {
                        let next = power(bins, place - shaft) + power(bins, place + shaft);
                        power(bins, place) > ABOVE_NEXT * next
                    })
            })
            .map(|place| place.round() as usize)
            .collect()
    }
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
        let mains = self.comb.mains([x, y]);
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
