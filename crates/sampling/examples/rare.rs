//! How exact rare shares are, and how often their 95 % intervals hold, for events whose share is known:
//! `cargo run --release -p sampling --example rare -- 50` (repetitions; then the runs of each, and names of cases).

use std::convert::Infallible;
use std::f64::consts::{PI, SQRT_2};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use sampling::design::correlation::Correlation;
use sampling::distribution::Distribution;
use sampling::rare::{Answer, Judged, Search, share};
use statrs::function::erf::erfc;

/// The level of a point.
type Level = Box<dyn Fn(&[f64]) -> f64 + Sync>;

/// An event: its level falls to 0.
struct Case {
    name: &'static str,
    dimensions: usize,
    exact: f64,
    level: Level,
    is_binary: bool,
}

impl Case {
    fn label(&self) -> String {
        format!("{}, {} of {:.0e}", self.name, self.dimensions, self.exact)
    }
}

const RARE: f64 = 1e-9;

fn below(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

fn density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / (2.0 * PI).sqrt()
}

/// The probability of an interval, exact in both tails.
fn between(low: f64, high: f64) -> f64 {
    if low > 0.0 { below(-low) - below(-high) } else { below(high) - below(low) }
}

/// Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    const N: u32 = 40_000;
    let h = (high - low) / f64::from(N);
    let weight = |k: u32| match k {
        0 | N => 1.0,
        k if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=N).map(|k| weight(k) * f(low + h * f64::from(k))).sum::<f64>() * h / 3.0
}

/// Where a falling function has a value.
fn falls_to(value: f64, f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if f(middle) > value {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The score that is exceeded with a probability.
fn exceeded(probability: f64) -> f64 {
    falls_to(probability, |z| below(-z), 0.0, 30.0)
}

fn case(name: &'static str, dimensions: usize, exact: f64, level: impl Fn(&[f64]) -> f64 + Sync + 'static) -> Case {
    Case { name, dimensions, exact, level: Box::new(level), is_binary: false }
}

fn linear(name: &'static str, dimensions: usize) -> Case {
    let limit = exceeded(RARE);
    let root = (dimensions as f64).sqrt();
    case(name, dimensions, RARE, move |u| limit - u.iter().sum::<f64>() / root)
}

/// u2 beyond a parabola that opens away from the centre (`bend` > 0) or around it.
fn parabola(name: &'static str, bend: f64) -> Case {
    let reach = |b: f64| integral(|x| density(x) * below(-b - bend * (x - 0.1).powi(2)), -14.0, 14.0);
    let b = falls_to(RARE, reach, 1.0, 14.0);
    case(name, 2, reach(b), move |u| b + bend * (u[0] - 0.1).powi(2) - u[1])
}

/// Opposite regions, one ten times as probable as the other.
fn uneven() -> Case {
    let [near, far] = [10.0 / 11.0, 1.0 / 11.0].map(|part| exceeded(part * RARE));
    case("two regions, 10 to 1, of 7", 7, RARE, move |u| (near - u[0]).min(far + u[0]))
}

/// The series system with four branches: two curved, two plane; each with a quarter of the share.
fn branches() -> Case {
    let curved = |c: f64| integral(|t| density(t) * 2.0 * below(-c - 0.2 * t * t), -14.0, 14.0);
    let c = falls_to(RARE / 2.0, curved, 1.0, 9.0);
    let plane = exceeded(RARE / 4.0);
    let exact = 2.0 * below(-plane) + integral(|t| density(t) * 2.0 * below(-c - 0.2 * t * t), -plane, plane);
    case("four branches", 2, exact, move |u| {
        let (s, t) = ((u[0] + u[1]) / SQRT_2, (u[0] - u[1]) / SQRT_2);
        (c + 0.2 * t * t - s.abs()).min(plane - t.abs())
    })
}

/// So many criteria at once: v1 = u1, vk = uk + 0.3 (u1^2 - 1), each 0.7 within its tolerance; turned in space.
fn bands(name: &'static str, criteria: usize, dimensions: usize, scales: &'static [f64]) -> Case {
    const PLACE: f64 = 0.7;
    const BEND: f64 = 0.3;
    let of = move |k: usize| scales[k % scales.len()];
    let exact = move |tolerance: f64| {
        let inside = |x: f64| {
            let shift = PLACE - BEND * (x * x - 1.0);
            let others = (1..criteria).map(|k| between(shift - tolerance * of(k), shift + tolerance * of(k)));
            density(x) * others.product::<f64>()
        };
        integral(inside, PLACE - tolerance * of(0), PLACE + tolerance * of(0))
    };
    let ln = falls_to(-RARE, |ln: f64| -exact(ln.exp()), -25.0, 0.0);
    let tolerance = ln.exp();
    case(name, dimensions, exact(tolerance), move |u| {
        let v = reflected(u);
        let bend = BEND * (v[0] * v[0] - 1.0);
        let deviation = |k: usize| {
            let value = if k == 0 { v[0] } else { v[k] + bend };
            (value - PLACE).abs() / (tolerance * of(k))
        };
        (0..criteria).map(deviation).fold(0.0, f64::max) - 1.0
    })
}

/// A rotation of the space: a reflection at a plane that is parallel to no axis.
fn reflected(u: &[f64]) -> Vec<f64> {
    let normal: Vec<f64> = (0..u.len()).map(|k| 1.0 + 0.3 * k as f64).collect();
    let square: f64 = normal.iter().map(|n| n * n).sum();
    let along: f64 = normal.iter().zip(u).map(|(n, x)| n * x).sum();
    let pairs = u.iter().zip(&normal);
    pairs.map(|(x, n)| x - 2.0 * along / square * n).collect()
}

/// A thin ring, which no mixture follows.
fn ring(name: &'static str, exact: f64) -> Case {
    const RADIUS: f64 = 1.5;
    // exp(-r^2 / 2) is the probability beyond r.
    let of = |half: f64| 2.0 * (-0.5 * (RADIUS * RADIUS + half * half)).exp() * (RADIUS * half).sinh();
    let half = falls_to(-exact, |half: f64| -of(half), 0.0, 0.5);
    case(name, 2, exact, move |u| (u[0].hypot(u[1]) - RADIUS).abs() / half - 1.0)
}

/// The sum of three uniform parameters is small: a corner, in which it has the share e^3 / 6.
fn uniform() -> Case {
    let limit = (6.0 * RARE).cbrt();
    let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
    case("corner of 3 uniform", 3, RARE, move |u| u.iter().map(|&z| unit.at_score(z)).sum::<f64>() - limit)
}

/// The product of five lognormal parameters is large: the sum of their logarithms is normal.
fn lognormal() -> Case {
    let each = Distribution::Lognormal { mean: 2.0, deviation: 0.5 };
    let variance = (1.0_f64 + 0.0625).ln();
    let limit = 5.0 * (2.0_f64.ln() - 0.5 * variance) + exceeded(RARE) * (5.0 * variance).sqrt();
    case("product of 5 lognormal", 5, RARE, move |u| limit.exp() - u.iter().map(|&z| each.at_score(z)).product::<f64>())
}

/// The sum of two normal parameters that are cut at three deviations.
fn truncated() -> Case {
    let cut = Distribution::TruncatedNormal { mean: 0.0, deviation: 1.0, min: Some(-3.0), max: Some(3.0) };
    let all = between(-3.0, 3.0);
    let beyond = move |s: f64| integral(|x| density(x) / all * between(s - x, 3.0) / all, s - 3.0, 3.0);
    let limit = falls_to(RARE, beyond, 2.0, 5.9999);
    case("sum of 2 truncated", 2, beyond(limit), move |u| limit - u.iter().map(|&z| cut.at_score(z)).sum::<f64>())
}

/// A sum of correlated parameters: correlations of 0.8 and -0.5.
fn correlated() -> Option<Case> {
    let mixed = Correlation::new(3, &[(0, 1, 0.8), (1, 2, -0.5)]).ok()?;
    let normal = [0; 3].map(|_| Distribution::Normal { mean: 1.0, deviation: 2.0 });
    let deviation = 2.0 * (3.0 + 2.0 * (0.8_f64 - 0.5)).sqrt();
    let limit = 3.0 + deviation * exceeded(RARE);
    Some(case("sum of 3 correlated", 3, RARE, move |u| limit - mixed.at_scores(u, &normal).iter().sum::<f64>()))
}

/// The largest of independent numbers exceeds a limit: as many equal regions.
fn largest(name: &'static str, count: usize, exact: f64) -> Case {
    let each = -(-exact).ln_1p() / count as f64;
    let limit = exceeded(-(-each).exp_m1());
    case(name, count, exact, move |u| limit - u.iter().copied().fold(f64::MIN, f64::max))
}

/// As many regions on both sides of each axis, each `ratio` times as probable as the one before.
fn sides(name: &'static str, dimensions: usize, ratio: f64, exact: f64) -> Case {
    let parts: Vec<f64> = (0..2 * dimensions).map(|k| ratio.powi(k as i32)).collect();
    let sum: f64 = parts.iter().sum();
    let limits: Vec<f64> = parts.iter().map(|p| exceeded(exact * p / sum)).collect();
    let none = |k: usize| 1.0 - below(-limits[2 * k]) - below(-limits[2 * k + 1]);
    let exact = -(0..dimensions).map(|k| (none(k) - 1.0).ln_1p()).sum::<f64>().exp_m1();
    case(name, dimensions, exact, move |u| {
        let axis = |k: usize| (limits[2 * k] - u[k]).min(limits[2 * k + 1] + u[k]);
        (0..u.len()).map(axis).fold(f64::MAX, f64::min)
    })
}

/// The probability that a sum of exponential numbers exceeds a limit (Erlang).
fn erlang(count: usize, limit: f64) -> f64 {
    let terms = (1..count).scan(1.0, |term, k| {
        *term *= limit / k as f64;
        Some(*term)
    });
    (-limit).exp() * (1.0 + terms.sum::<f64>())
}

fn exponentials(name: &'static str, count: usize, exact: f64) -> Case {
    let limit = falls_to(exact, |t| erlang(count, t), 0.0, 200.0);
    case(name, count, exact, move |u| limit - u.iter().map(|&z| -below(-z).ln()).sum::<f64>())
}

/// Outside of a ball: half the square of the radius is Erlang in an even number of dimensions.
fn ball(name: &'static str, dimensions: usize, exact: f64) -> Case {
    let limit = falls_to(exact, |t| erlang(dimensions / 2, t), 0.0, 400.0);
    case(name, dimensions, exact, move |u| limit - 0.5 * u.iter().map(|x| x * x).sum::<f64>())
}

/// Outside of an ellipsoid whose axes come in pairs: a sum of exponential numbers with different means.
fn ellipsoid(name: &'static str, means: &'static [f64], exact: f64) -> Case {
    let beyond = |t: f64| {
        let term = |(i, a): (usize, &f64)| {
            let others = means.iter().enumerate().filter(move |(j, _)| *j != i);
            others.map(|(_, b)| a / (a - b)).product::<f64>() * (-t / a).exp()
        };
        means.iter().enumerate().map(term).sum::<f64>()
    };
    let limit = falls_to(exact, beyond, 0.0, 400.0);
    case(name, 2 * means.len(), exact, move |u| {
        let pairs = u.chunks(2).zip(means);
        limit - pairs.map(|(x, a)| 0.5 * a * (x[0] * x[0] + x[1] * x[1])).sum::<f64>()
    })
}

/// Three balls of unlike size, in which the level is the distance from the nearest one.
fn islands(name: &'static str, exact: f64) -> Case {
    const PLACES: [[f64; 3]; 3] = [[3.0, 1.0, 0.0], [-1.0, -3.5, 2.0], [0.0, 2.0, -4.0]];
    const PARTS: [f64; 3] = [0.6, 0.3, 0.1];
    let share = |away: f64, radius: f64| {
        let at = |r: f64| r / away * (density(r - away) - density(r + away));
        integral(at, 0.0, radius)
    };
    let radius = |k: usize| {
        let away = PLACES[k].iter().map(|x| x * x).sum::<f64>().sqrt();
        falls_to(-PARTS[k] * exact, |r| -share(away, r), 0.0, 3.0)
    };
    let radii = [0, 1, 2].map(radius);
    case(name, 3, exact, move |u| {
        let from = |k: usize| {
            let square: f64 = u.iter().zip(PLACES[k]).map(|(x, c)| (x - c).powi(2)).sum();
            square.sqrt() - radii[k]
        };
        (0..3).map(from).fold(f64::MAX, f64::min)
    })
}

/// All of several uniform parameters are near their ends.
fn corner(name: &'static str, dimensions: usize, exact: f64) -> Case {
    let limit = exceeded(exact.powf(1.0 / dimensions as f64));
    case(name, dimensions, exact, move |u| u.iter().map(|x| limit - x).fold(f64::MIN, f64::max))
}

/// A narrow ridge along a parabola, far out.
fn ridge(name: &'static str, exact: f64) -> Case {
    const HALF: f64 = 0.05;
    let middle = |x: f64| 0.4 * (x - 1.0).powi(2) - 1.0;
    let beyond = move |b: f64| {
        let at = |x| density(x) * between(middle(x) - HALF, middle(x) + HALF);
        integral(at, b, 14.0)
    };
    let from = falls_to(exact, beyond, 0.0, 9.0);
    case(name, 5, exact, move |u| {
        let v = reflected(u);
        ((v[1] - middle(v[0])).abs() / HALF - 1.0).max(from - v[0])
    })
}

/// The sum of two lognormal parameters with long tails: two regions and a bridge between them.
fn long_tails(name: &'static str, exact: f64) -> Case {
    let beyond = |t: f64| {
        let at = |x: f64| density(x) * below(-(t - x.exp()).ln());
        integral(at, -9.0, t.ln() - 1e-9) + below(-t.ln())
    };
    let limit = falls_to(exact, beyond, 5.0, 2000.0);
    case(name, 2, exact, move |u| limit - u.iter().map(|x| x.exp()).sum::<f64>())
}

/// A plane, seen through noise and in steps.
fn stairs(name: &'static str, exact: f64) -> Case {
    const NOISE: f64 = 0.3;
    const STEP: f64 = 0.5;
    let beyond = |b: f64| integral(|e| below(-(b + NOISE * e)), -1.0, 1.0) / 2.0;
    let limit = falls_to(exact, beyond, 1.0, 9.0);
    case(name, 6, exact, move |u| {
        // From -1 to 1, by the last digits of the place.
        let bits = u.iter().fold(0_u64, |sum, x| sum.rotate_left(23) ^ x.to_bits());
        let noise = (bits.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11) as f64 / 2.0_f64.powi(52);
        let level = limit + NOISE * (noise - 1.0) - u.iter().sum::<f64>() / 6.0_f64.sqrt();
        STEP * (level / STEP).ceil()
    })
}

/// Half-spaces of unlike share, and the level falls at an unlike rate towards each.
fn slopes(name: &'static str, exact: f64) -> Case {
    const PARTS: [(f64, f64); 3] = [(0.7, 1.0), (0.25, 5.0), (0.05, 0.3)];
    let limits = PARTS.map(|(part, _)| exceeded(part * exact));
    let none: f64 = PARTS.iter().map(|(part, _)| (-part * exact).ln_1p()).sum();
    case(name, 6, -none.exp_m1(), move |u| {
        let falls = |k: usize| PARTS[k].1 * (limits[k] - u[2 * k]);
        (0..3).map(falls).fold(f64::MAX, f64::min)
    })
}

/// Two thin layers, turned in space.
fn layers(name: &'static str, exact: f64) -> Case {
    let half = |place: f64, part: f64| {
        let of = |h: f64| between(place - h, place + h);
        falls_to(-part * exact, |h| -of(h), 0.0, 1.0)
    };
    let (near, far) = (half(2.5, 0.8), half(3.0, 0.2));
    case(name, 8, exact, move |u| {
        let v = reflected(u)[0];
        ((v - 2.5).abs() - near).min((v + 3.0).abs() - far)
    })
}

/// At least so many of 20 numbers exceed 2: the level is a whole number.
fn many_of_20(name: &'static str, least: i32) -> Case {
    let p = below(-2.0);
    let choose = |k: i32| (0..k).map(|j| f64::from(20 - j) / f64::from(k - j)).product::<f64>();
    let terms = (least..=20).map(|k| choose(k) * p.powi(k) * (1.0 - p).powi(20 - k));
    case(name, 20, terms.sum(), move |u| f64::from(least) - u.iter().filter(|x| **x > 2.0).count() as f64)
}

/// The largest of four correlated numbers.
fn largest_correlated(name: &'static str, exact: f64) -> Case {
    const CORRELATION: f64 = 0.6;
    let (shared, own) = (CORRELATION.sqrt(), (1.0 - CORRELATION).sqrt());
    let beyond = move |t: f64| {
        let none = |x: f64| 4.0 * (-below((shared * x - t) / own)).ln_1p();
        integral(|x| density(x) * -none(x).exp_m1(), -14.0, 14.0)
    };
    let limit = falls_to(exact, beyond, 1.0, 9.0);
    case(name, 5, exact, move |u| {
        let largest = u[1..].iter().copied().fold(f64::MIN, f64::max);
        limit - shared * u[0] - own * largest
    })
}

/// The mean of three Cauchy numbers, which is another one.
fn cauchy(name: &'static str, exact: f64) -> Case {
    let tail = |p: f64| 1.0 / (PI * p).tan();
    case(name, 3, exact, move |u| tail(exact) - u.iter().map(|&z| tail(below(-z))).sum::<f64>() / 3.0)
}

/// Both of two numbers are large, and the level is the same everywhere else.
fn plateau(name: &'static str) -> Case {
    case(name, 3, below(-2.7) * below(-2.9), |u| f64::from(u8::from(u[0] < 2.7 || u[1] < 2.9)))
}

/// A number beyond a paraboloid in 19 dimensions, around which it bends.
fn paraboloid(name: &'static str, exact: f64) -> Case {
    let beyond = |t: f64| integral(|x| density(x) * erlang(9, (9.0 + (t - x) / 0.2).max(0.0)), -9.0, 9.0);
    let limit = falls_to(exact, beyond, 1.0, 30.0);
    case(name, 19, exact, move |u| {
        let squares: f64 = u[1..].iter().map(|x| x * x).sum();
        limit - u[0] - 0.1 * (squares - 18.0)
    })
}

/// Only whether the event happens is known.
fn binary(mut case: Case, name: &'static str) -> Case {
    case.is_binary = true;
    case.name = name;
    case
}

fn cases() -> Vec<Case> {
    let limit = exceeded(RARE / 2.0);
    let mut cases = vec![
        linear("linear, 2", 2),
        linear("linear, 7", 7),
        linear("linear, 30", 30),
        parabola("curved away", 0.5),
        parabola("curved around: two lobes", -0.15),
        case("two regions of 2", 2, RARE, move |u| limit - u[0].abs()),
        uneven(),
        branches(),
        bands("band, 2 criteria of 7", 2, 7, &[1.0]),
        bands("band, 3 criteria of 7", 3, 7, &[1.0]),
        bands("band, 5 criteria of 7", 5, 7, &[1.0]),
        bands("band, 5 uneven of 7", 5, 7, &[1.0, 0.1, 3.0, 0.3]),
        bands("band, 5 criteria of 30", 5, 30, &[1.0]),
        uniform(),
        lognormal(),
        truncated(),
        ring("thin ring of 2, 1e-5", 1e-5),
        ring("thin ring of 2, 1e-7", 1e-7),
        binary(linear("", 2), "linear, 2, yes or no"),
        binary(linear("", 7), "linear, 7, yes or no"),
        binary(branches(), "four branches, yes or no"),
    ];
    cases.extend(correlated());
    for exact in [1e-4, 1e-7] {
        let many = |count: usize| largest("largest", count, exact);
        cases.extend([1, 2, 5, 7, 10, 20].map(many));
        cases.push(exponentials("exponentials", 10, exact));
        cases.push(ball("ball", 10, exact));
        cases.extend([2, 20, 40].map(|d| ball("other: ball", d, exact)));
        cases.push(exponentials("other: exponentials", 3, exact));
        cases.push(ellipsoid("other: ellipsoid", &[1.0, 0.8, 0.5, 0.3], exact));
        cases.push(ellipsoid("other: ellipsoid", &[1.0, 0.1, 0.09, 0.08, 0.07, 0.06], exact));
        cases.push(sides("other: sides", 3, 0.5, exact));
        cases.push(sides("other: sides", 5, 0.8, exact));
        cases.push(sides("other: sides", 15, 1.0, exact));
        cases.push(islands("new: islands", exact));
        cases.push(corner("new: corner", 4, exact));
        cases.push(ridge("new: ridge", exact));
        cases.push(long_tails("new: long tails", exact));
        cases.push(stairs("new: stairs", exact));
    }
    cases.extend([
        slopes("unseen: slopes", 1e-6),
        layers("unseen: layers", 1e-6),
        many_of_20("unseen: 6 exceed 2", 6),
        largest_correlated("unseen: largest correlated", 1e-6),
        cauchy("unseen: Cauchy", 1e-6),
        plateau("unseen: plateau"),
        paraboloid("unseen: paraboloid", 1e-6),
    ]);
    cases
}

fn answer(case: &Case, runs: u64, seed: u64) -> Answer {
    let search = Search { dimensions: case.dimensions, runs, seed, confidence: 0.95, is_binary: case.is_binary };
    let mut ask = |points: &[Vec<f64>]| {
        let judged = points.iter().map(|point| {
            let level = (case.level)(point);
            Judged { level: if case.is_binary { 0.0 } else { level }, met: level <= 0.0, failed: false }
        });
        Ok::<_, Infallible>(judged.collect())
    };
    match share(&search, &mut ask) {
        Ok(answer) => answer,
        Err(error) => match error {},
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, usual: u64| arguments.get(k).and_then(|a| a.parse().ok()).unwrap_or(usual);
    let (repetitions, runs) = (number(0, 50), number(1, 100_000));
    println!("| event | told | rms error | mean ratio | holding | too low | runs (most) | regions |");
    println!("|---|---|---|---|---|---|---|---|");
    for case in cases() {
        let wanted = &arguments[arguments.len().min(2)..];
        if !wanted.is_empty() && !wanted.iter().any(|name| case.label().contains(name.as_str())) {
            continue;
        }
        let (next, answers) = (AtomicU64::new(0), Mutex::new(Vec::new()));
        thread::scope(|scope| {
            for _ in 0..thread::available_parallelism().map_or(2, Into::into) {
                scope.spawn(|| {
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= repetitions {
                            break;
                        }
                        let answer = answer(&case, runs, 1000 + number);
                        if let Ok(mut answers) = answers.lock() {
                            answers.push(answer);
                        }
                    }
                });
            }
        });
        println!("{}", row(&case, &answers.into_inner().unwrap_or_default()));
    }
}

fn row(case: &Case, answers: &[Answer]) -> String {
    let told: Vec<_> = answers.iter().filter_map(|answer| answer.share.as_ref()).collect();
    let interval = |share: &sampling::rare::Share| share.interval.unwrap_or([f64::NAN; 2]);
    let count = |holds: &dyn Fn([f64; 2]) -> bool| {
        told.iter().filter(|share| holds(interval(share))).count() as f64 / told.len() as f64
    };
    let square: f64 = told.iter().map(|share| (share.value / case.exact - 1.0).powi(2)).sum();
    let most = answers.iter().map(|answer| answer.runs).max().unwrap_or(0);
    let mean = |of: &dyn Fn(&Answer) -> f64| answers.iter().map(of).sum::<f64>() / answers.len() as f64;
    format!(
        "| {} | {} of {} | {:.1} % | {:.3} | {} | {:.1} % | {:.0} ({most}) | {:.1} |",
        case.label(),
        told.len(),
        answers.len(),
        100.0 * (square / told.len() as f64).sqrt(),
        told.iter().map(|share| share.value).sum::<f64>() / told.len() as f64 / case.exact,
        count(&|[low, high]| low <= case.exact && case.exact <= high) * told.len() as f64,
        100.0 * count(&|[_, high]| high < case.exact),
        mean(&|answer| answer.runs as f64),
        mean(&|answer| answer.regions.len() as f64),
    )
}
