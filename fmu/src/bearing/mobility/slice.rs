//! The map at one width-to-diameter ratio, for use in every time step.

use nalgebra::Vector2;

use super::coordinates::Point;
use super::map::CHANNELS;
use super::spline::{End, hermite, slopes};

/// Value, slope over `u`, slope over `s` and twist of two quantities at a node.
type Node = [[f64; 4]; 2];

/// The mobility of bearings of one `B/D`.
#[derive(Clone, Debug, PartialEq)]
pub struct MobilitySlice {
    /// `ln |M|` and the angle by which `M` leads the load.
    motion: Surface,
    /// `ln` of the largest pressure over `F/(B D)` and of the side flow over `F c^3 / (3 eta B^2)`.
    film: Surface,
}

/// What else is known of a film under a load, dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// The largest pressure over `F / (B D)`.
    pub max_pressure: f64,
    /// The flow out of both ends together over `F c^3 / (3 eta B^2)`.
    pub side_flow: f64,
}

impl MobilitySlice {
    /// From node values, by `u`, then `s`, then channel.
    pub(super) fn new(values: &[f64], us: usize, ss: usize, last_u: f64) -> Self {
        let channel =
            |k: usize| -> Vec<f64> { values.iter().skip(k).step_by(CHANNELS).copied().collect() };
        let surface = |a: usize, b: usize, odd: End| {
            Surface::new([channel(a), channel(b)], us, ss, last_u, [End::Even, odd])
        };
        Self {
            motion: surface(0, 1, End::Odd),
            film: surface(2, 3, End::Even),
        }
    }

    /// The mobility along the eccentricity and 90 degrees ahead of it, at the eccentricity ratio
    /// `e` (0 up to, but not, 1) under a load whose angle ahead of the eccentricity has this cosine and sine.
    ///
    /// An eccentricity ratio of 1 or more is taken as just below 1.
    pub fn mobility(&self, e: f64, cos: f64, sin: f64) -> (f64, f64) {
        let [logarithm, lead] = self.motion.at(Point::new(e, cos, sin));
        let (lead_sin, lead_cos) = if sin < 0.0 { -lead } else { lead }.sin_cos();
        let size = logarithm.exp();
        (
            size * (cos * lead_cos - sin * lead_sin),
            size * (sin * lead_cos + cos * lead_sin),
        )
    }

    /// The mobility vector `M` in the frame of `eps` and of the load's `direction`, a unit vector.
    pub fn mobility_vector(&self, eps: Vector2<f64>, direction: Vector2<f64>) -> Vector2<f64> {
        let e = eps.norm();
        let [logarithm, lead] = self.motion.at(self.point(eps, direction));
        let sine = eps.perp(&direction);
        let lead = if sine < 0.0 { -lead } else { lead };
        let (sin, cos) = lead.sin_cos();
        logarithm.exp()
            * Vector2::new(
                direction.x * cos - direction.y * sin,
                direction.x * sin + direction.y * cos,
            )
    }

    /// Largest pressure and side flow under a load along the unit vector `direction`.
    pub fn film(&self, eps: Vector2<f64>, direction: Vector2<f64>) -> Film {
        let [pressure, flow] = self.film.at(self.point(eps, direction));
        Film {
            max_pressure: pressure.exp(),
            side_flow: flow.exp(),
        }
    }

    fn point(&self, eps: Vector2<f64>, direction: Vector2<f64>) -> Point {
        let e = eps.norm();
        if e > 0.0 {
            let inverse = 1.0 / e;
            Point::new(
                e,
                eps.dot(&direction) * inverse,
                eps.perp(&direction) * inverse,
            )
        } else {
            Point::new(0.0, 1.0, 0.0)
        }
    }
}

/// Two quantities over `u` and `s`, once continuously differentiable.
#[derive(Clone, Debug, PartialEq)]
struct Surface {
    /// By `u`, then `s`.
    nodes: Vec<Node>,
    /// Nodes over `s`.
    ss: usize,
    /// Nodes over `u`, less one.
    last_u: f64,
    /// Nodes over `s`, less one.
    last_s: f64,
    /// Node spacings per unit of `u`.
    per_u: f64,
}

impl Surface {
    /// From the node values; `symmetry` tells how each quantity behaves at both ends of `s`.
    fn new(values: [Vec<f64>; 2], us: usize, ss: usize, last_u: f64, symmetry: [End; 2]) -> Self {
        let mut nodes = vec![Node::default(); us * ss];
        for (channel, values) in values.iter().enumerate() {
            let ends = [symmetry[channel]; 2];
            let over_u = over_u(values, us, ss);
            for i in 0..us {
                let row = i * ss..(i + 1) * ss;
                let mut over_s = vec![0.0; ss];
                let mut twist = vec![0.0; ss];
                slopes(&values[row.clone()], ends, &mut over_s);
                slopes(&over_u[row.clone()], ends, &mut twist);
                for j in 0..ss {
                    let at = i * ss + j;
                    nodes[at][channel] = [values[at], over_u[at], over_s[j], twist[j]];
                }
            }
        }
        let last = (us - 1) as f64;
        Self {
            nodes,
            ss,
            last_u: last,
            last_s: (ss - 1) as f64,
            per_u: last / last_u,
        }
    }

    /// Both quantities at a point.
    fn at(&self, point: Point) -> [f64; 2] {
        let position = point.u * self.per_u;
        let across = (point.s * self.last_s).clamp(0.0, self.last_s);
        let inside = position.min(self.last_u);
        let i = (inside as usize).min(self.last_u as usize - 1);
        let j = (across as usize).min(self.ss - 2);
        // Beyond the last node over u the surface goes on straight.
        let x = inside - i as f64;
        let excess = position - inside;
        let [a0, a1, b0, b1] = hermite(x);
        let along = [a0, a1, b0, b1 + excess];
        let wide = hermite(across - j as f64);
        let near = i * self.ss + j;
        let corners = [
            &self.nodes[near],
            &self.nodes[near + self.ss],
            &self.nodes[near + 1],
            &self.nodes[near + self.ss + 1],
        ];
        let mut sum = [0.0; 2];
        for (k, corner) in corners.into_iter().enumerate() {
            let (value, slope) = (along[k & 1], along[2 + (k & 1)]);
            let (wide_value, wide_slope) = (wide[k >> 1], wide[2 + (k >> 1)]);
            for (total, [f, fu, fs, fus]) in sum.iter_mut().zip(corner) {
                *total +=
                    wide_value * (value * f + slope * fu) + wide_slope * (value * fs + slope * fus);
            }
        }
        sum
    }
}

/// Slopes over `u` of values by `u`, then `s`.
fn over_u(values: &[f64], us: usize, ss: usize) -> Vec<f64> {
    let mut result = vec![0.0; us * ss];
    let (mut line, mut slope) = (vec![0.0; us], vec![0.0; us]);
    for j in 0..ss {
        for i in 0..us {
            line[i] = values[i * ss + j];
        }
        slopes(&line, [End::Free; 2], &mut slope);
        for i in 0..us {
            result[i * ss + j] = slope[i];
        }
    }
    result
}
