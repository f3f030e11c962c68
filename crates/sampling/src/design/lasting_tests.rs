//! The points of a seed never change: a study that an earlier version began must go on with the same points, and a
//! published result must be found again. The numbers are those of version 0.1.0.

use super::{Design, Method, Sampling};
use crate::distribution::Distribution;

const UNIT: Distribution = Distribution::Uniform { min: 0.0, max: 1.0 };

/// The points 0, 1 and 19 of 20 with four inputs, seed 7; the second number is that of the replicates.
const POINTS: [(Method, u64, [[f64; 4]; 3]); 4] = [
    (
        Method::MonteCarlo,
        1,
        [
            [0.7501522221031126, 0.17173538717791426, 0.8509509130245897, 0.12378288865847986],
            [0.7952840373401903, 0.8498386593738912, 0.2223900225781571, 0.45987247503069095],
            [0.7529877018170162, 0.9395045537384609, 0.9254613797704175, 0.6486348979277611],
        ],
    ),
    (
        Method::LatinHypercube,
        1,
        [
            [0.139313624114871, 0.9882811527010007, 0.933575168137604, 0.8431522430468649],
            [0.4836378774260616, 0.8738092762633094, 0.5187413695554469, 0.9090550731255591],
            [0.8627619062002024, 0.6646795986870673, 0.9552250997021148, 0.11070132701048556],
        ],
    ),
    (
        Method::Sobol,
        1,
        [
            [0.9653574795895891, 0.5173405622517743, 0.7284339158030934, 0.43169337507873895],
            [0.2704197738023376, 0.03143445413470858, 0.43877691178927847, 0.6771961090110944],
            [0.23785141768288753, 0.26660813956837914, 0.29046951749001215, 0.5633994699954118],
        ],
    ),
    (
        Method::Sobol,
        3,
        [
            [0.9653574795895891, 0.5173405622517743, 0.7284339158030934, 0.43169337507873895],
            [0.8093999595550722, 0.8399758374961525, 0.6577479933329923, 0.40162009703486723],
            [0.7170984526759102, 0.5573990110525843, 0.16331150222208868, 0.6095639619077619],
        ],
    ),
];

#[test]
fn the_points_of_a_seed_never_change() {
    for method in Method::ALL {
        assert!(POINTS.iter().any(|(pinned, ..)| pinned == method), "{method:?} has no points here");
    }
    for (method, replicates, expected) in POINTS {
        let sampling = Sampling { method, points: 20, seed: 7, replicates };
        let design = Design::new(&sampling, vec![UNIT; 4]).unwrap();
        let points = [0, 1, 19].map(|index| design.point(index));
        assert_eq!(points, expected, "{method:?}");
    }
}
