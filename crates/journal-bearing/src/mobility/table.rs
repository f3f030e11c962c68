//! The tabulated quantities at one `B/D`, with the slopes that bicubic interpolation needs.

use super::spline::{End, Spline};

/// Quantities per node: `ln |M|`, the angle by which `M` leads the load (rad), `ln` of the largest pressure over
/// `F/(B D)`, and `ln` of the side flow over `F c^3 / (3 eta B^2)`.
pub const CHANNELS: usize = 4;

/// How each quantity continues beyond the ends of `s`: the lead changes its sign with the angle from eccentricity to
/// load, the others do not.
const SYMMETRY: [End; CHANNELS] = [End::Even, End::Odd, End::Even, End::Even];

/// One node: of each quantity the value, the slope over `u`, the slope over `s`, and the mixed derivative ("twist"),
/// all per node spacing.
pub type Node = [[f64; CHANNELS]; 4];

/// Index of the value among a node's four numbers, and of `ln |M|` among the quantities.
pub const VALUE: usize = 0;
pub const MOBILITY: usize = 0;

/// The evenly spaced nodes over `u` and `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Number of nodes over `s`.
    pub ss: usize,
    /// Index of the last node over `u`.
    pub last_u: f64,
    /// Index of the last node over `s`.
    pub last_s: f64,
    /// Node spacings per unit of `u`.
    pub per_u: f64,
}

impl Lattice {
    /// The range of the nodes of row `i`: one `u`, all `s`.
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        i * self.ss..(i + 1) * self.ss
    }
}

/// The quantities over `u` and `s` at one of the map's `B/D`.
#[derive(Clone, Debug, PartialEq)]
pub struct Tabulated {
    pub lattice: Lattice,
    /// By `u`, then `s`.
    pub nodes: Vec<Node>,
}

impl Tabulated {
    /// Makes the table from `us * ss` node values, ordered by `u`, then `s`, then channel; `u` ends at `last_u`.
    pub fn new(values: &[f32], us: usize, ss: usize, last_u: f64) -> Self {
        let mut nodes = vec![Node::default(); us * ss];
        let free = Spline::new(us, [End::Free; 2]);
        for (channel, symmetry) in SYMMETRY.into_iter().enumerate() {
            let values: Vec<f64> = values
                .iter()
                .skip(channel)
                .step_by(CHANNELS)
                .map(|&value| f64::from(value))
                .collect();
            let over_u = slopes_over_u(&values, &free, us, ss);
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
        let lattice = Lattice {
            ss,
            last_u: last,
            last_s: (ss - 1) as f64,
            per_u: last / last_u,
        };
        Self { lattice, nodes }
    }
}

/// Slopes over `u`, per node spacing, of values ordered by `u`, then `s`.
fn slopes_over_u(values: &[f64], spline: &Spline, us: usize, ss: usize) -> Vec<f64> {
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
