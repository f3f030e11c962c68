//! The delay between two signals of which one should be proportional to the other.
//!
//! The friction coefficient mu(t) = M(t) / (F_N(t) D/2) of a steady state hardly varies: the torque follows the load.
//! Where the torque channel lags behind the load channel, mu seems to vary. The delay is the shift of the torque at which
//! both signals correlate most (Vrublevskyi & Skonieczna, section 5.1, ask for the least variance of mu; a correlation
//! does not divide by a noisy load).
//!
//! Between samples the torque is known by interpolation only, which averages the noise, most of all halfway. A plain
//! interpolation therefore prefers half samples. Here both signals pass through the same Gaussian kernel at every shift,
//! so wide that the noise it leaves does not depend on the shift.

use sampling::statistics::{
    estimate::Estimate,
    moments::{mean, variance},
};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{
    kernel::Kernel,
    signal::{Even, SignalError},
    spectrum::Comb,
};

/// The delay of the torque, with its uncertainty.
#[derive(Debug, Default)]
pub struct Delay {
    /// How much later the torque is than the load, s, with its 95 % interval; `None` where the signals are not related.
    pub delay: Option<Estimate>,
    /// The chance that unrelated signals seem to be related as much.
    pub chance: f64,
    /// The part of the torque's deviations that the load does not explain, by delays, s, over the range that was searched.
    pub scan: Vec<(f64, f64)>,
    /// How many blocks of the record the interval rests on.
    pub blocks: usize,
    /// Whether the greatest correlation lies at the edge of the searched range: then it is no maximum.
    pub at_edge: bool,
    /// Why the interval does not hold, and the remedy: load and torque share more than the load.
    pub disturbance: Option<String>,
}

impl Delay {
    /// The shift that aligns the torque, s; 0 where the signals are not related.
    pub fn shift(&self) -> f64 {
        self.delay.map_or(0.0, |delay| delay.value)
    }

    /// The delay's standard uncertainty, s; `None` where there is no interval.
    pub fn uncertainty(&self) -> Option<f64> {
        self.delay.filter(|_| self.disturbance.is_none()).map(|delay| (delay.high - delay.low) / 4.0)
    }

    /// The delay with its interval as text, where the signals are related.
    pub fn words(&self) -> Option<String> {
        let [value, low, high] = self.delay.map(|d| [d.value, d.low, d.high].map(|s| 1e3 * s))?;
        Some(match self.disturbance {
            None => format!("{value:.3} ms ({low:.3} to {high:.3} ms, 95 %)"),
            Some(_) => format!("{value:.3} ms (without an interval)"),
        })
    }
}

/// Load and torque on the same grid of times.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// The load.
    pub load: &'a Even,
    /// The torque.
    pub torque: &'a Even,
    /// Which samples of the load can be used; the others are clipped.
    pub load_good: &'a [bool],
    /// The same of the torque.
    pub torque_good: &'a [bool],
}

/// Blocks of the record, of which each tells the delay anew.
const BLOCKS: usize = 16;
/// Fewer blocks tell too little.
const LEAST_BLOCKS: usize = 8;
/// Student's degrees of freedom of the interval: half the blocks, since they do not tell equally much.
const FREEDOM: f64 = 8.0;
/// Signals count as related when unrelated ones seem so at most this often. Slowly wandering signals are less independent
/// from block to block than the test takes them for, hence a quarter of the 2 % that are stated.
const CHANCE: f64 = 0.005;
/// The least deviation of the kernel in samples: the noise that it leaves depends on the shift by less than 1e-9.
const LEAST_WIDTH: f64 = 1.5;
/// A kernel whose deviation is the duration of a turn divided by this passes the turn's first ten harmonics.
const WIDTHS_A_TURN: f64 = 80.0;
/// A shaft's speed may droop by this part to either side.
const USUAL_SPREAD: f64 = 0.005;

/// Finds the delay of the torque after the load, searched within `longest` seconds to either side. `turn` is the time of
/// a turn of the shaft, s, where it is known.
///
/// The 95 % interval comes from the delete-one jackknife over 16 blocks, and from delays at which the correlation is not
/// significantly less. Where it would be wider than the kernel, a kernel of twice the width lets less noise through. Signals
/// are related when the shift that one half of the blocks prefers leaves a positive correlation in the other half.
///
/// # Errors
/// When the record is too short.
pub fn find(pair: Pair, longest: f64, turn: Option<f64>) -> Result<Delay, SignalError> {
    let step = pair.load.step;
    let reach = longest / step;
    let least = (2.0 * reach).max(turn.map_or(0.0, |turn| turn / step));
    let least = (least.ceil() as usize).max(10);
    let mut width = turn.map_or(LEAST_WIDTH, |turn| turn / step / WIDTHS_A_TURN);
    width = width.max(LEAST_WIDTH);
    // A kernel of a tenth of a turn still lets the turn itself through.
    let widest = 8.0 * width;
    let mut last = None;
    while let Some(search) = Search::new(pair, width, reach, least) {
        let (delay, half) = search.delay(step);
        last = Some((delay, width * step));
        if half <= 0.3 * width || width >= widest {
            break;
        }
        width *= 2.0;
    }
    let (mut delay, kernel) = last.ok_or(SignalError::TooShort {
        name: "load".into(),
        usable: pair.load.values.len(),
        needed: LEAST_BLOCKS * least + 2 * (reach + 20.0 * LEAST_WIDTH).ceil() as usize,
    })?;
    if let (Some(Estimate { value, low, high }), false) = (delay.delay, delay.at_edge) {
        let comb = Comb::new(pair.load, turn, USUAL_SPREAD);
        let numbers = [value, (high - low) / 2.0, longest, kernel];
        delay.disturbance = comb.disturbance([pair.load, pair.torque], numbers);
    }
    Ok(delay)
}

/// A search with one kernel; places and lags are in samples.
struct Search<'a> {
    pair: Pair<'a>,
    kernel: Kernel,
    width: f64,
    /// The lags that are tried, whole samples, and the distance from one to the next.
    lags: Vec<isize>,
    stride: isize,
    /// The first place, the length of a block, and how many there are.
    first: usize,
    length: usize,
    blocks: usize,
    /// The load behind the kernel at each place of the blocks.
    load: Vec<f64>,
}

/// Sums over one block: load by torque, load by load, torque by torque, all from their means.
#[derive(Clone, Copy, Default)]
struct BlockSums {
    xy: f64,
    xx: f64,
    yy: f64,
}

impl<'a> Search<'a> {
    /// `None` where the record is too short for the kernel.
    fn new(pair: Pair<'a>, width: f64, reach: f64, least: usize) -> Option<Self> {
        let kernel = Kernel::new(width);
        let first = reach.ceil() as usize + kernel.reach() + (3.0 * width).ceil() as usize;
        let usable = pair.load.values.len().checked_sub(2 * first)?;
        let blocks = BLOCKS.min(usable / least);
        if blocks < LEAST_BLOCKS {
            return None;
        }
        let length = usable / blocks;
        if (length as f64) < 10.0 * width {
            return None;
        }
        let stride = (width / 2.0).max(1.0).floor() as isize;
        let most = reach.floor() as isize / stride;
        let mut search = Self {
            pair,
            kernel,
            width,
            lags: (-most..=most).map(|k| k * stride).collect(),
            stride,
            first,
            length,
            blocks,
            load: Vec::new(),
        };
        search.load = search.values(&pair.load.values, 0.0);
        Some(search)
    }

    /// A signal behind the kernel at each place of the blocks, `lag` samples later.
    fn values(&self, signal: &[f64], lag: f64) -> Vec<f64> {
        self.values_of(signal, lag, self.blocks * self.length)
    }

    fn values_of(&self, signal: &[f64], lag: f64, count: usize) -> Vec<f64> {
        let (whole, weights) = self.kernel.at(lag);
        let start = (self.first as isize + whole) as usize - self.kernel.reach();
        (start..start + count).map(|place| signal[place..].iter().zip(&weights).map(|(v, w)| v * w).sum()).collect()
    }

    /// The sums of all blocks with the torque `lag` samples later; `whole` is the lag by which its bad samples are known.
    fn sums(&self, torque: &[f64], whole: isize) -> Vec<BlockSums> {
        let is_good = |k: &usize| {
            let place = self.first + k;
            self.pair.load_good[place] && self.pair.torque_good[(place as isize + whole) as usize]
        };
        let block = |b: usize| {
            let samples = b * self.length..(b + 1) * self.length;
            sums(samples.filter(is_good).map(|k| (self.load[k], torque[k])))
        };
        (0..self.blocks).map(block).collect()
    }

    /// The sums at each lag that is tried.
    fn scan(&self) -> Vec<Vec<BlockSums>> {
        let (first, last) = (self.lags[0], self.lags[self.lags.len() - 1]);
        let count = self.blocks * self.length + (last - first) as usize;
        let torque = self.values_of(&self.pair.torque.values, first as f64, count);
        self.lags.iter().map(|&lag| self.sums(&torque[(lag - first) as usize..], lag)).collect()
    }

    /// The delay, and half the width of its interval by the jackknife in samples.
    fn delay(&self, step: f64) -> (Delay, f64) {
        let scan = self.scan();
        let all: Vec<f64> = scan.iter().map(|sums| correlation(sums)).collect();
        let best = greatest(&all);
        let [before, after] = [-self.stride, self.stride].map(|off| (self.lags[best] + off) as f64);
        let at = |lag: f64| correlation(&self.sums(&self.values(&self.pair.torque.values, lag), lag.round() as isize));
        let limit = *self.lags.last().expect("there is the lag 0") as f64;
        let lag = golden(before, after, |lag| -at(lag)).clamp(-limit, limit);
        let (error, drop) = self.jackknife(lag);
        let half = quantile() * error;
        let [mut low, mut high] = [lag - half, lag + half];
        // Delays that explain the torque about as well.
        let enough = at(lag) - drop * quantile() * quantile();
        for (&other, _) in self.lags.iter().zip(&all).filter(|(_, r)| **r >= enough) {
            low = low.min(other as f64);
            high = high.max(other as f64);
        }
        let chance = chance(&scan);
        let related = chance < CHANCE && half.is_finite();
        let unexplained = |r: &f64| (1.0 - r.max(0.0).powi(2)).max(0.0).sqrt();
        let scanned = self.lags.iter().zip(&all);
        let delay = Delay {
            delay: related.then_some(Estimate { value: lag * step, low: low * step, high: high * step }),
            chance,
            scan: scanned.map(|(&lag, r)| (lag as f64 * step, unexplained(r))).collect(),
            blocks: self.blocks,
            at_edge: best == 0 || best + 1 == all.len(),
            disturbance: None,
        };
        (delay, half)
    }

    /// The standard error of the lag by leaving out one block at a time, and by how much the correlation falls at a lag
    /// that is one such error away. Near its maximum, the logarithm of the correlation is taken as a parabola.
    fn jackknife(&self, lag: f64) -> (f64, f64) {
        let apart = 0.25 * self.width;
        let whole = lag.round() as isize;
        let [before, here, after] = [-apart, 0.0, apart].map(|off| {
            let torque = self.values(&self.pair.torque.values, lag + off);
            self.sums(&torque, whole)
        });
        let total = total(&here);
        // Each block's part of the logarithm, but for a constant.
        let part = |s: &BlockSums| s.xy / total.xy - 0.5 * (s.xx / total.xx + s.yy / total.yy);
        let parts = |of: &dyn Fn(f64, f64, f64) -> f64| -> Vec<f64> {
            (0..self.blocks).map(|b| of(part(&before[b]), part(&here[b]), part(&after[b]))).collect()
        };
        let slopes = parts(&|before, _, after| (after - before) / (2.0 * apart));
        let bends = parts(&|before, here, after| (before - 2.0 * here + after) / apart.powi(2));
        let [slope, bend] = [&slopes, &bends].map(|parts| parts.iter().sum::<f64>());
        let without: Vec<f64> = slopes.iter().zip(&bends).map(|(s, b)| -(slope - s) / (bend - b)).collect();
        let n = without.len() as f64;
        let error = ((n - 1.0) * variance(&without, 0)).sqrt();
        (error, 0.5 * bend.abs() * correlation(&here) * error * error)
    }
}

fn sums(samples: impl Iterator<Item = (f64, f64)>) -> BlockSums {
    let (mut n, mut x, mut y, mut sums) = (0.0, 0.0, 0.0, BlockSums::default());
    for (load, torque) in samples {
        // Welford 1962.
        n += 1.0;
        let (dx, dy) = (load - x, torque - y);
        x += dx / n;
        y += dy / n;
        sums.xy += dx * (torque - y);
        sums.xx += dx * (load - x);
        sums.yy += dy * (torque - y);
    }
    sums
}

fn total(blocks: &[BlockSums]) -> BlockSums {
    blocks.iter().fold(BlockSums::default(), |t, s| BlockSums { xy: t.xy + s.xy, xx: t.xx + s.xx, yy: t.yy + s.yy })
}

/// The correlation over all blocks; none where a signal is constant.
fn correlation(blocks: &[BlockSums]) -> f64 {
    let t = total(blocks);
    let scale = (t.xx * t.yy).sqrt();
    if scale > 0.0 { t.xy / scale } else { 0.0 }
}

fn greatest(values: &[f64]) -> usize {
    values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).expect("there is a value").0
}

/// The chance that unrelated signals correlate as well: every second block chooses the lag, Student's test of the others'
/// correlations decides; the smaller one of both ways, doubled.
fn chance(scan: &[Vec<BlockSums>]) -> f64 {
    let half = |odd: usize| {
        let of = |sums: &Vec<BlockSums>, odd| -> Vec<BlockSums> { sums.iter().skip(odd).step_by(2).copied().collect() };
        let choice: Vec<f64> = scan.iter().map(|s| correlation(&of(s, odd))).collect();
        let each: Vec<f64> = of(&scan[greatest(&choice)], 1 - odd).iter().map(|s| correlation(&[*s])).collect();
        let n = each.len() as f64;
        let (mean, error) = (mean(&each), (variance(&each, 1) / n).sqrt());
        match StudentsT::new(0.0, 1.0, n - 1.0) {
            Ok(student) if error > 0.0 => student.sf(mean / error),
            _ => f64::from(mean <= 0.0),
        }
    };
    (2.0 * half(0).min(half(1))).min(1.0)
}

fn quantile() -> f64 {
    StudentsT::new(0.0, 1.0, FREEDOM).expect("there are degrees of freedom").inverse_cdf(0.975)
}

/// The place of the least value between two places, by golden section (Kiefer 1953).
fn golden(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut c, mut d) = (b - RATIO * (b - a), a + RATIO * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    // A ten-thousandth of a sample is far below any delay that could matter.
    while b - a > 1e-4 {
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - RATIO * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + RATIO * (b - a);
            fd = f(d);
        }
    }
    (a + b) / 2.0
}

#[cfg(test)]
mod tests;
