//! Published functions, and some that no smooth surrogate follows. Coordinates lie between 0 and 1 or are standard normal.
#![allow(dead_code, reason = "each of the tests uses some of them")]

use std::f64::consts::{PI, SQRT_2};

/// A number that the environment sets: how long a trial is.
pub fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|s| s.parse().ok()).unwrap_or(default)
}

/// The functions and numbers of runs of a trial: all, or those that the environment's `MODEL` and `RUNS` name.
pub fn trials() -> impl Iterator<Item = (&'static Model, u64)> {
    let (only, runs) = (std::env::var("MODEL").unwrap_or_default(), number("RUNS", 0));
    let models = ALL.iter().filter(move |model| only.is_empty() || model.name == only);
    models.flat_map(move |model| {
        [50, 100, 200].into_iter().filter(move |r| runs == 0 || *r == runs).map(move |r| (model, r))
    })
}

/// A function with the lower limit of its value.
pub struct Model {
    pub name: &'static str,
    pub dimensions: usize,
    /// The first so many coordinates are standard normal.
    pub normals: usize,
    /// Of each of these with the one before.
    pub correlation: f64,
    pub of: fn(&[f64]) -> f64,
    /// The value from which on a point is good.
    pub limit: f64,
    /// Whether it is smooth.
    pub smooth: bool,
}

impl Model {
    /// A net of plain points.
    pub fn points(&self, count: u64, seed: u64) -> Vec<Vec<f64>> {
        self.places(sampling::design::cube(self.dimensions, count, seed, 1).expect("there is such a net"))
    }

    /// Two independent samples: the halves of a net of twice the dimensions.
    pub fn halves(&self, count: u64, seed: u64) -> [Vec<Vec<f64>>; 2] {
        let d = self.dimensions;
        let net = sampling::design::cube(2 * d, count, seed, 1).expect("there is such a net");
        [0, 1].map(|half| self.places(net.iter().map(|u| u[half * d..][..d].to_vec()).collect()))
    }

    fn places(&self, mut cube: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let standard = sampling::distribution::Distribution::Normal { mean: 0.0, deviation: 1.0 };
        cube.iter_mut().flat_map(|u| &mut u[..self.normals]).for_each(|u| *u = standard.quantile(*u));
        for u in &mut cube {
            for k in 1..self.normals {
                u[k] = self.correlation * u[k - 1] + (1.0 - self.correlation.powi(2)).sqrt() * u[k];
            }
        }
        cube
    }
}

const fn model(name: &'static str, d: [usize; 2], of: fn(&[f64]) -> f64, limit: f64, smooth: bool) -> Model {
    Model { name, dimensions: d[0], normals: d[1], correlation: 0.0, of, limit, smooth }
}

/// All of them.
pub static ALL: [Model; 12] = [
    model("circuit", [6, 0], circuit, 4.6, true),
    model("borehole", [8, 2], borehole, 60.0, true),
    model("piston", [7, 0], piston, 0.4, true),
    model("ishigami", [3, 0], ishigami, 1.0, true),
    model("branches", [2, 2], four_branches, 2.0, false),
    model("oscillator", [6, 6], oscillator, 0.25, false),
    model("g-function", [4, 0], g_function, 0.8, false),
    model("jump", [3, 0], jump, 1.2, false),
    model("noise", [3, 0], noisy, 0.8, false),
    model("thirty", [30, 0], thirty, 0.0, true),
    model("ridge", [2, 0], ridge, 0.3, false),
    Model { correlation: 0.6, ..model("beam", [3, 3], beam, 0.0, true) },
];

fn range(u: f64, low: f64, high: f64) -> f64 {
    low + (high - low) * u
}

/// Output voltage of a push-pull circuit without transformer (Ben-Ari & Steinberg 2007, "Modeling data from computer
/// experiments", Quality Engineering 19, 327-338).
pub fn circuit(u: &[f64]) -> f64 {
    let (b1, b2, f) = (range(u[0], 50.0, 150.0), range(u[1], 25.0, 70.0), range(u[2], 0.5, 3.0));
    let (c1, c2, gain) = (range(u[3], 1.2, 2.5), range(u[4], 0.25, 1.2), range(u[5], 50.0, 300.0));
    let base = 12.0 * b2 / (b1 + b2);
    let turned = gain * (c2 + 9.0);
    ((base + 0.74) * turned + 11.35 * f) / (turned + f) + 0.74 * f * turned / ((turned + f) * c1)
}

/// Flow through a borehole (Harper & Gupta 1983; Surjanovic & Bingham, Virtual Library of Simulation Experiments).
pub fn borehole(u: &[f64]) -> f64 {
    let radius = 0.1 + 0.016_181_2 * u[0];
    let reach = (7.71 + 1.0056 * u[1]).exp();
    let (tu, hu, tl) = (range(u[2], 63_070.0, 115_600.0), range(u[3], 990.0, 1110.0), range(u[4], 63.1, 116.0));
    let (hl, length, k) = (range(u[5], 700.0, 820.0), range(u[6], 1120.0, 1680.0), range(u[7], 9855.0, 12_045.0));
    let ratio = (reach / radius).ln();
    2.0 * PI * tu * (hu - hl) / (ratio * (1.0 + 2.0 * length * tu / (ratio * radius * radius * k) + tu / tl))
}

/// Cycle time of a piston in a cylinder (Kenett & Zacks 1998; Surjanovic & Bingham).
pub fn piston(u: &[f64]) -> f64 {
    let (m, s, v0) = (range(u[0], 30.0, 60.0), range(u[1], 0.005, 0.02), range(u[2], 0.002, 0.01));
    let (k, p0) = (range(u[3], 1000.0, 5000.0), range(u[4], 90_000.0, 110_000.0));
    let (ta, t0) = (range(u[5], 290.0, 296.0), range(u[6], 340.0, 360.0));
    let a = p0 * s + 19.62 * m - k * v0 / s;
    let v = s / (2.0 * k) * ((a * a + 4.0 * k * p0 * v0 / t0 * ta).sqrt() - a);
    2.0 * PI * (m / (k + s * s * p0 * v0 / t0 * ta / (v * v))).sqrt()
}

/// Ishigami & Homma (1990).
pub fn ishigami(u: &[f64]) -> f64 {
    let x: Vec<f64> = u.iter().map(|v| PI * (2.0 * v - 1.0)).collect();
    x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
}

/// A series system of four branches, kinked where they meet (Schueremans & Van Gemert 2005).
pub fn four_branches(u: &[f64]) -> f64 {
    let (x, y) = (u[0], u[1]);
    let curved = 3.0 + 0.1 * (x - y).powi(2);
    let (sum, apart) = ((x + y) / SQRT_2, 6.0 / SQRT_2);
    (curved - sum).min(curved + sum).min(x - y + apart).min(y - x + apart)
}

/// A non-linear oscillator under a rectangular load (Schueremans & Van Gemert 2005; Echard et al. 2011); kinked.
pub fn oscillator(u: &[f64]) -> f64 {
    let x = |k: usize, mean: f64, deviation: f64| mean + deviation * u[k];
    let (c1, c2, m) = (x(0, 1.0, 0.1), x(1, 0.1, 0.01), x(2, 1.0, 0.05));
    let (r, t1, f1) = (x(3, 0.5, 0.05), x(4, 1.0, 0.2), x(5, 1.0, 0.2));
    let square = (c1 + c2) / m;
    3.0 * r - (2.0 * f1 / (m * square) * (square.sqrt() * t1 / 2.0).sin()).abs()
}

/// Sobol's g-function with a = 0, 1, 4.5, 9; kinked.
pub fn g_function(u: &[f64]) -> f64 {
    let pairs = u.iter().zip([0.0, 1.0, 4.5, 9.0]);
    pairs.map(|(u, a)| ((4.0 * u - 2.0).abs() + a) / (1.0 + a)).product()
}

/// A jump of 2 at a slanted edge.
pub fn jump(u: &[f64]) -> f64 {
    u[0] + u[1] * u[2] + if u[0] + 0.5 * u[1] > 0.8 { 2.0 } else { 0.0 }
}

/// A slope under numerical noise of a tenth of its range, the same for the same point.
pub fn noisy(u: &[f64]) -> f64 {
    let bits = u.iter().fold(0, |bits, v| sampling::random::mix(bits ^ v.to_bits()));
    u[0] + 0.5 * u[1] * u[2] + 0.15 * (bits as f64 / u64::MAX as f64 - 0.5)
}

/// Thirty coordinates of falling weight, with neighbours that interact.
pub fn thirty(u: &[f64]) -> f64 {
    let x = |k: usize| 2.0 * u[k] - 1.0;
    (0..30).map(|k| x(k) / (1.0 + k as f64 / 5.0) + 0.3 * x(k) * x((k + 1) % 30)).sum()
}

/// What the tip of a cantilever under two loads may still be displaced by (Wu et al. 1990, "Advanced probabilistic structural
/// analysis method for implicit performance functions"; Surjanovic & Bingham).
pub fn beam(u: &[f64]) -> f64 {
    let (across, along, modulus) = (500.0 + 100.0 * u[0], 1000.0 + 100.0 * u[1], 2.9e7 + 1.45e6 * u[2]);
    let (width, height, length) = (2.4_f64, 3.3_f64, 100_f64);
    let load = (across / width.powi(2)).hypot(along / height.powi(2));
    2.2535 - 4.0 * length.powi(3) / (modulus * width * height) * load
}

/// A kink along a circle.
pub fn ridge(u: &[f64]) -> f64 {
    ((u[0] - 0.3).hypot(u[1] - 0.4) - 0.35).abs() + 0.2 * u[0]
}
