//! The map at one width-to-diameter ratio, for use in every time step.

use nalgebra::Vector2;
use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

use super::coordinates::Point;
use super::family::Blend;
use super::map::CHANNELS;
use super::spline::{End, Spline, hermite};

/// Of each quantity: value, slope over `u`, slope over `s` and twist.
pub(super) type Node = [[f64; CHANNELS]; 4];

/// The points over `u` and `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// Nodes over `s`.
    ss: usize,
    /// Nodes over `u`, less one.
    last_u: f64,
    /// Nodes over `s`, less one.
    last_s: f64,
    /// Node spacings per unit of `u`.
    per_u: f64,
}

/// The map's quantities over `u` and `s` at one of its `B/D`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tabulated {
    pub(super) grid: Grid,
    /// By `u`, then `s`.
    pub(super) nodes: Vec<Node>,
}

/// The mobility of bearings of one `B/D`: the map's quantities over `u` and `s`, once continuously
/// differentiable.
#[derive(Clone, Debug)]
pub struct MobilitySlice {
    grid: Grid,
    /// By `u`. A journal visits few of them, so they are made when it does.
    rows: Vec<OnceLock<Box<[Node]>>>,
    blend: Blend,
}

/// A film under a load, dimensionless; what is not asked for is not looked up.
#[derive(Clone, Copy, Debug)]
pub struct Film<'a> {
    slice: &'a MobilitySlice,
    place: Place,
    direction: Vector2<f64>,
    /// Of the angle from the eccentricity to the load.
    sign: f64,
}

impl Film<'_> {
    /// The mobility vector `M` in the frame of the load's direction.
    #[inline]
    pub fn mobility(&self) -> Vector2<f64> {
        let [log_mobility, lead] = self.slice.pair::<0>(&self.place);
        // Beyond a right angle the film would push the journal along. Nothing does, but the surface beyond the table.
        let lead = lead.clamp(-FRAC_PI_2, FRAC_PI_2);
        // The lead is odd in the angle from eccentricity to load.
        let (sin, cos) = (self.sign * lead).sin_cos();
        let (x, y) = (self.direction.x, self.direction.y);
        Vector2::new(x * cos - y * sin, x * sin + y * cos) * log_mobility.exp()
    }

    /// The largest pressure over `F / (B D)`.
    pub fn max_pressure(&self) -> f64 {
        self.slice.pair::<1>(&self.place)[0].exp()
    }

    /// The flow out of both ends together over `F c^3 / (3 eta B^2)`.
    #[inline]
    pub fn side_flow(&self) -> f64 {
        self.slice.pair::<1>(&self.place)[1].exp()
    }
}

/// A place in the table: the cell's first node, and the weights of what is stored at its corners.
#[derive(Clone, Copy, Debug)]
struct Place {
    near: [usize; 2],
    /// By corner, then by what is stored there.
    weights: [[f64; 4]; 4],
}

/// How each quantity continues beyond the ends of `s`.
const SYMMETRY: [End; CHANNELS] = [End::Even, End::Odd, End::Even, End::Even];

impl Tabulated {
    /// From node values, by `u`, then `s`, then channel.
    pub(super) fn new(values: &[f32], us: usize, ss: usize, last_u: f64) -> Self {
        let mut nodes = vec![Node::default(); us * ss];
        let free = Spline::new(us, [End::Free; 2]);
        for (channel, symmetry) in SYMMETRY.into_iter().enumerate() {
            let values: Vec<f64> = values
                .iter()
                .skip(channel)
                .step_by(CHANNELS)
                .map(|&value| f64::from(value))
                .collect();
            let over_u = over_u(&values, &free, us, ss);
            let spline = Spline::new(ss, [symmetry; 2]);
            let (mut over_s, mut twist) = (vec![0.0; ss], vec![0.0; ss]);
            for i in 0..us {
                let row = i * ss..(i + 1) * ss;
                spline.slopes(&values[row.clone()], &mut over_s);
                spline.slopes(&over_u[row.clone()], &mut twist);
                for (j, at) in row.enumerate() {
                    let node = [values[at], over_u[at], over_s[j], twist[j]];
                    for (kind, value) in nodes[at].iter_mut().zip(node) {
                        kind[channel] = value;
                    }
                }
            }
        }
        let last = (us - 1) as f64;
        let grid = Grid {
            ss,
            last_u: last,
            last_s: (ss - 1) as f64,
            per_u: last / last_u,
        };
        Self { grid, nodes }
    }
}

impl Grid {
    /// The nodes of a row over `s`.
    pub(super) fn row(&self, i: usize) -> std::ops::Range<usize> {
        i * self.ss..(i + 1) * self.ss
    }
}

impl MobilitySlice {
    /// A slice whose rows are made by `blend`.
    pub(super) fn new(grid: Grid, blend: Blend) -> Self {
        Self {
            grid,
            rows: vec![OnceLock::new(); grid.last_u as usize + 1],
            blend,
        }
    }

    /// The nodes of a row over `s`.
    #[inline]
    pub(super) fn row(&self, i: usize) -> &[Node] {
        self.rows[i].get_or_init(|| self.blend.row(i))
    }

    /// The mobility along the eccentricity and 90 degrees ahead of it, at the eccentricity ratio
    /// `e` (0 up to, but not, 1) under a load whose angle ahead of the eccentricity has this cosine and sine.
    ///
    /// An eccentricity ratio of 1 or more is taken as just below 1.
    pub fn mobility(&self, e: f64, cos: f64, sin: f64) -> (f64, f64) {
        let mobility = self.mobility_vector(Vector2::new(e, 0.0), Vector2::new(cos, sin));
        (mobility.x, mobility.y)
    }

    /// The mobility vector `M` in the frame of `eps` and of the load's `direction`, a unit vector.
    pub fn mobility_vector(&self, eps: Vector2<f64>, direction: Vector2<f64>) -> Vector2<f64> {
        self.film(eps, eps.norm(), direction).mobility()
    }

    /// The film at the eccentricity-ratio vector `eps` of length `e` under a load along the unit vector
    /// `direction`.
    #[inline]
    pub fn film(&self, eps: Vector2<f64>, e: f64, direction: Vector2<f64>) -> Film<'_> {
        let (cos, sin) = if e > 0.0 {
            let inverse = 1.0 / e;
            (
                eps.dot(&direction) * inverse,
                eps.perp(&direction) * inverse,
            )
        } else {
            (1.0, 0.0)
        };
        Film {
            slice: self,
            place: self.place(Point::new(e, cos, sin)),
            direction,
            sign: if sin < 0.0 { -1.0 } else { 1.0 },
        }
    }

    #[inline]
    fn place(&self, point: Point) -> Place {
        let grid = &self.grid;
        let position = point.u * grid.per_u;
        let across = (point.s * grid.last_s).clamp(0.0, grid.last_s);
        let inside = position.min(grid.last_u);
        let i = (inside as usize).min(grid.last_u as usize - 1);
        let j = (across as usize).min(grid.ss - 2);
        // Beyond the last node over u the surface goes on straight.
        let x = inside - i as f64;
        let excess = position - inside;
        let [a0, a1, b0, b1] = hermite(x);
        let along = [a0, a1, b0, b1 + excess];
        let wide = hermite(across - j as f64);
        let corner = |k: usize| {
            let (value, slope) = (along[k & 1], along[2 + (k & 1)]);
            let (wide_value, wide_slope) = (wide[k >> 1], wide[2 + (k >> 1)]);
            [
                wide_value * value,
                wide_value * slope,
                wide_slope * value,
                wide_slope * slope,
            ]
        };
        Place {
            near: [i, j],
            weights: [corner(0), corner(1), corner(2), corner(3)],
        }
    }

    /// Two of the quantities at a place: the mobility's for 0, the others for 1.
    #[inline]
    fn pair<const PAIR: usize>(&self, place: &Place) -> [f64; 2] {
        let [i, j] = place.near;
        let (near, far) = (&self.row(i)[j..=j + 1], &self.row(i + 1)[j..=j + 1]);
        let corners = [&near[0], &far[0], &near[1], &far[1]];
        let mut sum = [0.0; 2];
        for (node, weights) in corners.into_iter().zip(&place.weights) {
            for (kind, weight) in node.iter().zip(weights) {
                sum[0] += weight * kind[2 * PAIR];
                sum[1] += weight * kind[2 * PAIR + 1];
            }
        }
        sum
    }
}

/// Slopes over `u` of values by `u`, then `s`.
fn over_u(values: &[f64], spline: &Spline, us: usize, ss: usize) -> Vec<f64> {
    let mut result = vec![0.0; us * ss];
    let (mut line, mut slope) = (vec![0.0; us], vec![0.0; us]);
    for j in 0..ss {
        for i in 0..us {
            line[i] = values[i * ss + j];
        }
        spline.slopes(&line, &mut slope);
        for i in 0..us {
            result[i * ss + j] = slope[i];
        }
    }
    result
}
