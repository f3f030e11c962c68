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
use sampling::statistics::moments::sorted;
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
/// Of the interval's half width, by this much a disturbance may move the delay.
const MOVES: f64 = 0.2;
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
    let centre = values.iter().sum::<f64>() / n;
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
    pub fn disturbance(&self, [load, torque]: [&Even; 2], [delay, half, longest, kernel]: [f64; 4]) -> Option<String> {
        let [x, y] = [load, torque].map(|signal| transform(&signal.values));
        let places = self.between();
        if places.len() < NEAR {
            return None;
        }
        let levels = [&x, &y].map(|bins| self.levels(bins, &places));
        // The torque on the load, turned back by the delay: without an imaginary part where the delay explains it.
        let cross = |k: usize| x[k].conj() * y[k] * self.turned(k, delay);
        let stands_out = |&(i, k): &(usize, usize)| {
            let [p, q] = [&x, &y].map(|bins| bins[k].norm_sqr());
            p > STANDS_OUT * levels[0][i] && q > STANDS_OUT * levels[1][i]
        };
        // Beyond chance the delay does not explain how far such a line is turned.
        let unexplained = |&(i, k): &(usize, usize)| {
            let part = levels[0][i] / x[k].norm_sqr() + levels[1][i] / y[k].norm_sqr();
            cross(k).arg().abs() > 3.0 * (part / 2.0).sqrt()
        };
        let numbered: Vec<(usize, usize)> = places.iter().copied().enumerate().collect();
        let common: Vec<(usize, usize)> = numbered.iter().copied().filter(stands_out).collect();
        let mains = self.mains([&x, &y]);
        let of = |common: &mut dyn Iterator<Item = &(usize, usize)>| -> Vec<usize> {
            common.map(|&(_, k)| k).chain(mains.iter().copied()).collect()
        };
        let all = of(&mut common.iter());
        let lines = of(&mut common.iter().filter(|line| unexplained(line)));
        let near = |lines: &[usize], k: usize| lines.iter().any(|line| line.abs_diff(k) <= LOBE);
        // The first two derivatives of the correlation by the delay, behind the kernel, from some bins.
        let derivatives = |which: &dyn Fn(usize) -> bool| {
            (1..x.len()).filter(|&k| which(k)).fold([0.0; 2], |[pull, bend], k| {
                let angular = TAU * k as f64 * self.bin;
                let cross = (-(angular * kernel).powi(2)).exp() * cross(k);
                [pull - angular * cross.im, bend - angular * angular * cross.re]
            })
        };
        let [pull, _] = derivatives(&|k| near(&lines, k));
        let [_, rest] = derivatives(&|k| !near(&lines, k));
        let [_, bend] = derivatives(&|_| true);
        // The delay that the shaft's harmonics alone prefer.
        let is_harmonic = |k: usize| matches!(self.line[k], Some(1..)) && !near(&all, k);
        let [of_lines, line_bend] = derivatives(&is_harmonic);
        let of_lines = delay - of_lines / line_bend;
        // A load at random has as much between the harmonics, where a periodic one has nothing but noise and hum.
        let usual = |which: &dyn Fn(usize) -> bool| {
            let count = (1..x.len()).filter(|&k| which(k)).count();
            derivatives(which)[1] / count as f64
        };
        let other = |k: usize| self.line[k].is_none() && !near(&all, k);
        let is_periodic = usual(&is_harmonic) / usual(&other).abs() > 5.0;
        let (far, moves) = if is_periodic { (0.5, MOVES) } else { (1.5, 0.4) };
        let apart = (of_lines - delay).abs() > far * half * (bend / line_bend).max(1.0).sqrt();
        let pulled = (pull / rest).abs();
        let moved = match apart && is_periodic {
            true if !all.is_empty() => Some((&all, (of_lines - delay).abs())),
            _ => (!lines.is_empty() && pulled > moves * half).then_some((&lines, pulled)),
        };
        if let Some((lines, moved)) = moved {
            let strength = |k: &usize| x[*k].norm_sqr() * y[*k].norm_sqr();
            let strongest = lines.iter().max_by(|a, b| strength(a).total_cmp(&strength(b)))?;
            let frequency = *strongest as f64 * self.bin;
            return Some(format!(
                "both channels have a line at {frequency:.1} Hz that the load does not explain, such as mains hum; it moves the delay by \
                 about {:.2} ms, so no interval is stated: shield the cables, or set smoothing = {{ method = \"butterworth\", \
                 cutoff = {:.0}, order = 4 }}",
                1e3 * moved,
                0.6 * frequency
            ));
        }
        let quiet: Vec<(usize, Complex<f64>)> = numbered
            .iter()
            .filter(|(_, k)| !near(&lines, *k))
            .map(|&(i, k)| {
                let scale = (levels[0][i] * levels[1][i]).sqrt();
                (k, cross(k) / scale)
            })
            .collect();
        let power: f64 = quiet.iter().map(|(_, c)| c.norm_sqr()).sum();
        let deviation = (power * memory() / 2.0).sqrt();
        let together = |lag: f64| {
            let terms = quiet.iter().map(|(k, c)| (c * self.turned(*k, lag - delay)).re);
            terms.sum::<f64>() / deviation
        };
        let most = (2.0 * longest / kernel).ceil().min(500.0);
        let (at, best) = (0..=2 * most as usize)
            .map(|k| (k as f64 / most - 1.0) * longest)
            .map(|lag| (lag, together(lag)))
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let best = best.abs();
        let related = together(delay) > 0.7 * best;
        // What leaks does so at once: at this delay less is chance.
        let at_once = together(0.0).abs();
        let [between, lines] = match (best > TOGETHER, at_once > AT_ONCE) {
            (true, _) if !related => [at, delay],
            (_, true) if !related => [0.0, delay],
            (true, _) if apart => [at, of_lines],
            _ => return self.dispersion([&x, &y], &places, delay, bend),
        };
        Some(format!(
            "between the harmonics of the shaft, load and torque vary together at a delay of {:.2} ms, and at the harmonics at {:.2} ms: \
             one channel leaks into the other, or both pick up the same disturbance, which moves the delay, so no interval is \
             stated: separate the channels' cables and amplifiers, or choose a smoothing that takes the disturbance out",
            1e3 * between,
            1e3 * lines
        ))
    }

    /// Whether what varies between the harmonics has another phase than one delay gives it. `bend` is what all bins tell of the
    /// delay: where those between the lines tell little of it, their phase does not matter.
    fn dispersion(&self, [x, y]: [&[Complex<f64>]; 2], places: &[usize], delay: f64, bend: f64) -> Option<String> {
        let angular = |k: usize| TAU * k as f64 * self.bin;
        let cross = |k: usize| x[k].conj() * y[k] * self.turned(k, delay);
        let between: f64 = places.iter().map(|&k| -angular(k).powi(2) * cross(k).re).sum();
        let free = NEAR as f64 / memory();
        let squares: Vec<f64> = places
            .chunks_exact(NEAR)
            .map(|group| {
                let power = |of: &[Complex<f64>]| group.iter().map(|&k| of[k].norm_sqr()).sum::<f64>();
                let mean = group.iter().map(|&k| cross(k)).sum::<Complex<f64>>() / (power(x) * power(y)).sqrt();
                2.0 * free * mean.im.powi(2) / (1.0 - mean.norm_sqr())
            })
            .collect();
        let count = squares.len() as f64;
        let too_much = squares.iter().sum::<f64>() > 1.1 * count + TOGETHER * (3.0 * count).sqrt();
        (too_much && between / bend > 0.1).then(|| {
            "the phase between load and torque is not that of one delay at all frequencies: a disturbance is in both, or one \
             channel leaks into the other, so no interval is stated: separate the channels' cables and amplifiers"
                .to_owned()
        })
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
