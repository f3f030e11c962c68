//! Tests of the quasi-static film.

#[path = "../../../tests/literature/mod.rs"]
mod literature;

use crate::reynolds::Grid;
use literature::RAIMONDI_BOYD;
use nalgebra::{Matrix2, Vector2};

use super::{Boundary, Groove, QuasiStatic};
use std::f64::consts::PI;

/// Sommerfeld number S, attitude angle and (R/c) f of a journal at rest under a steady load.
fn steady(grid: Grid, e: f64, width: f64, boundary: Boundary) -> [f64; 3] {
    let mut film = QuasiStatic::new(grid, width, boundary);
    film.place(Vector2::new(e, 0.0));
    // Mean rotation of 1 rad/s and no squeeze: v = -z x eps.
    let carried = film.load_at(Vector2::new(0.0, -e)).unwrap();
    let (s, w) = (carried.sommerfeld_number(1.0), carried.load);
    let attitude = -w.y.atan2(w.x);
    // Petroff's friction over the whole film, 2 pi^2 S / sqrt(1 - e^2), and the pressure's share.
    let friction = 2.0 * PI * PI * s / (1.0 - e * e).sqrt() + 0.5 * e * attitude.sin();
    [s, attitude.to_degrees(), friction]
}

#[test]
fn raimondi_and_boyd() {
    for [e, s, attitude, friction] in RAIMONDI_BOYD {
        let solution = steady(Grid::clustered(96, 8, e, 1.0), e, 1.0, Boundary::Seam);
        assert!((solution[0] / s - 1.0).abs() < 0.015, "S at {e}: {solution:?}");
        assert!((solution[1] - attitude).abs() < 1.0, "angle at {e}: {solution:?}");
        assert!((solution[2] / friction - 1.0).abs() < 0.015, "friction at {e}: {solution:?}");
    }
}

#[test]
fn the_boundary_conditions_differ_as_known() {
    // At B/D = 1 the load differs by 2 % and the angle by 4.4 degrees at e = 0.1, the load by less than 0.4 % above 0.8. The
    // angles are from an independent solution with either condition, on 361 x 61 and 722 x 122 nodes.
    for (e, largest, smallest, apart) in
        [(0.1, 0.025, 0.015, 4.43), (0.4, 0.004, 0.0, 2.56), (0.8, 0.004, 0.0, 0.56), (0.97, 0.004, 0.0, 0.05)]
    {
        let of = |boundary| steady(Grid::clustered(192, 16, e, 1.0), e, 1.0, boundary);
        let (free, seam) = (of(Boundary::Free), of(Boundary::Seam));
        let difference = (seam[0] / free[0] - 1.0).abs();
        assert!(difference < largest && difference >= smallest, "{e}: {difference}");
        let angle = free[1] - seam[1];
        assert!((angle - apart).abs() < 0.05, "{e}: {angle} degrees");
    }
}

/// The load of the journal at rest on ever finer grids, extrapolated.
fn extrapolated_load(e: f64, width: f64, coarse: [usize; 2]) -> f64 {
    let load = |k| {
        let grid = Grid::clustered(coarse[0] * k, coarse[1] * k, e, width);
        steady(grid, e, width, Boundary::Free)[0].recip()
    };
    let (middle, fine) = (load(1), load(2));
    fine + (fine - middle) / 3.0
}

#[test]
fn converges_with_second_order() {
    second_order(&[(0.5, 0.76), (0.9, 0.25)]);
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn converges_with_second_order_at_any_eccentricity() {
    second_order(&[(0.5, 0.76), (0.9, 0.76), (0.97, 1.0), (0.9, 0.25)]);
}

fn second_order(cases: &[(f64, f64)]) {
    let mut orders = 0.0;
    for &(e, width) in cases {
        let exact = extrapolated_load(e, width, [192, 18]);
        let error = |grid| (steady(grid, e, width, Boundary::Free)[0].recip() / exact - 1.0).abs();
        let even = [96, 192, 384].map(|n| error(Grid::uniform(n, n / 12)));
        let order = 0.5 * (even[0] / even[2]).log2();
        println!("e {e}, B/D {width}: order {order:.2}, errors {even:.6?}");
        // The free boundary moves in whole cells, which scatters single orders around 2.
        assert!(order > 1.6, "order {order} at {e}, {width}");
        orders += order;
        let map = error(Grid::clustered(160, 14, e, width));
        assert!(map < 0.001, "map's grid {map} at {e}, {width}");
    }
    let mean = orders / cases.len() as f64;
    assert!((mean - 2.0).abs() < 0.1, "mean order {mean}");
}

#[test]
fn sufficient_cells_are_sufficient_for_narrow_and_wide_bearings() {
    enough_cells(&[0.25, 0.5, 1.5], &[0.3, 0.97]);
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn sufficient_cells_are_sufficient() {
    enough_cells(&[0.25, 0.3, 0.4, 0.5, 0.6, 0.76, 1.0, 1.5], &[0.3, 0.6, 0.8, 0.9, 0.95, 0.97]);
}

fn enough_cells(widths: &[f64], eccentricities: &[f64]) {
    for &width in widths {
        for &e in eccentricities {
            let exact = extrapolated_load(e, width, [128, 12]);
            let [columns, rows] = Grid::sufficient_cells(width);
            let grid = Grid::standard(columns, rows, width);
            let error = (steady(grid, e, width, Boundary::Free)[0].recip() / exact - 1.0).abs();
            println!("B/D {width}, e {e}: {columns} x {rows} cells, error {:.3} %", 100.0 * error);
            assert!(error < 0.003, "{error} at {e}, {width}");
        }
    }
}

#[test]
fn short_bearing_at_the_centre() {
    // Booker (1965): M = (D/B)^2 / pi for a short bearing at eps = 0.
    let width = 0.02;
    let mut film = QuasiStatic::new(Grid::uniform(96, 4), width, Boundary::Free);
    let carried = film.velocity_under(Vector2::new(1.0, 0.0)).unwrap();
    let mobility = carried.velocity.x / 6.0;
    assert!((mobility * PI * width * width - 1.0).abs() < 2e-3, "{mobility}");
}

/// A film between two grooves at 90 degrees from a load along `x`, with the journal at rest.
#[derive(Debug)]
struct Resting {
    /// Eccentricity ratio and attitude angle, degrees.
    place: [f64; 2],
    /// In loads over the clearance, and in loads over the clearance and the journal's speed.
    stiffness: Matrix2<f64>,
    damping: Matrix2<f64>,
    threshold: f64,
}

impl Resting {
    fn scaled(&self) -> [f64; 7] {
        let (k, b) = (&self.stiffness, &self.damping);
        [k.m11, k.m12, k.m21, k.m22, b.m11, b.m12, b.m22]
    }
}

/// Grooves of some degrees.
fn grooves(extent: f64) -> [Groove; 2] {
    [-0.5 * PI, 0.5 * PI].map(|angle| Groove { angle, extent: extent.to_radians() })
}

/// The resting place at a Sommerfeld number, by Newton's method.
fn between_grooves(width: f64, extent: f64, s: f64) -> Resting {
    let grid = Grid::standard(288, 16, width);
    let mut film = QuasiStatic::new(grid, width, Boundary::Free).with_grooves(&grooves(extent));
    let load = 1.0 / (6.0 * PI * s);
    let mut eps = Vector2::new(0.3, 0.3);
    for _ in 0..60 {
        film.place(eps);
        let (carried, found) = film.coefficients(1.0).unwrap();
        let missing = Vector2::new(load, 0.0) - carried.load;
        let step = found.stiffness.try_inverse().unwrap() * missing;
        if step.norm() < 1e-12 {
            return Resting {
                place: [eps.norm(), eps.y.atan2(eps.x).to_degrees()],
                stiffness: found.stiffness / load,
                damping: found.damping * (2.0 / load),
                threshold: found.whirl_threshold(load, 2.0),
            };
        }
        let room = 0.5 * (1.0 - eps.norm());
        eps += step * (room / step.norm()).min(1.0);
    }
    panic!("no resting place at S = {s}");
}

/// Lund & Thomsen (1978), "A calculation method and data for the dynamic coefficients of oil-lubricated journal bearings": two
/// axial grooves of 20 degrees, L/D 0.5. Small entries are differences of large ones: an entry may be off by 2.5 % of itself or
/// by 1 % of its matrix.
#[test]
fn lund_and_thomsen() {
    for ([s, e, angle], published) in [
        ([1.656, 0.244, 65.85], [1.69, 5.06, -2.20, 1.95, 9.93, 2.15, 4.80]),
        ([0.917, 0.372, 57.45], [2.12, 4.01, -1.30, 1.85, 7.70, 2.06, 3.23]),
        ([0.580, 0.477, 51.01], [2.67, 3.70, -0.78, 1.75, 6.96, 1.94, 2.40]),
        ([0.379, 0.570, 45.43], [3.33, 3.64, -0.43, 1.68, 6.76, 1.87, 1.89]),
    ] {
        let film = between_grooves(0.5, 20.0, s);
        assert!((film.place[0] - e).abs() < 0.002, "{film:?}");
        assert!((film.place[1] - angle).abs() < 0.3, "{film:?}");
        for (n, (computed, published)) in film.scaled().into_iter().zip(published).enumerate() {
            let of_matrix = if n < 4 { film.stiffness.norm() } else { film.damping.norm() };
            let bound = f64::max(0.025 * f64::abs(published), 0.01 * of_matrix);
            assert!((computed - published).abs() < bound, "{published}: {film:?}");
        }
    }
}

/// Someya (1989), Journal-Bearing Databook: two axial grooves of 10 degrees, L/D 0.5. Its Kxx, Kyx and Kyy are those of
/// another model: at a small eccentricity ratio K tends to half the speed times B, turned by 90 degrees, which Kyx = -13.1 and Byy
/// = 14.9 contradict.
#[test]
fn someya() {
    for [s, e, angle, kxy, bxx] in [
        [5.96, 0.0750, 82.6, 13.6, 27.2],
        [2.07, 0.200, 71.6, 5.63, 11.2],
        [0.798, 0.400, 57.5, 3.75, 7.32],
        [0.323, 0.600, 44.7, 3.62, 6.81],
        [0.135, 0.750, 34.9, 4.11, 7.65],
        [0.0582, 0.850, 27.2, 4.92, 9.12],
    ] {
        let film = between_grooves(0.5, 10.0, s);
        assert!((film.place[0] - e).abs() < 0.002, "{film:?}");
        assert!((film.place[1] - angle).abs() < 0.9, "{film:?}");
        for (computed, published) in [(film.stiffness.m12, kxy), (film.damping.m11, bxx)] {
            assert!((computed / published - 1.0).abs() < 0.05, "{published}: {film:?}");
        }
    }
}

/// Nicholas (1980): a rigid rotor in a plain bearing with two grooves begins to whirl at `Omega sqrt(c/g)` = 2.1, at S = 5.3
/// and at 4.3.
#[test]
fn a_rotor_begins_to_whirl_where_it_is_known_to() {
    for s in [5.3, 4.3] {
        let film = between_grooves(1.0, 20.0, s);
        assert!((film.threshold / 2.1 - 1.0).abs() < 0.03, "{film:?}");
    }
}

/// Away from resting places, too.
#[test]
fn coefficients_are_the_differences_of_loads() {
    let grid = Grid::standard(96, 8, 0.76);
    let smooth = QuasiStatic::new(grid.clone(), 0.76, Boundary::Free).with_grooves(&grooves(11.0));
    differences(smooth, [[0.3, 0.2], [-0.1, 0.85], [0.0, 0.05]], 1e-8);
    // Contact on one side, with crossing mean planes, and around the bush.
    let rough = QuasiStatic::between(0.1, grid.clone(), 0.76, Boundary::Free);
    differences(rough, [[0.3, 0.4], [-0.1, 0.85], [0.7, 0.75]], 1e-6);
    let coarse = QuasiStatic::between(0.4, grid, 0.76, Boundary::Free);
    differences(coarse, [[0.3, 0.2], [-0.1, 0.85], [0.7, 0.75]], 1e-6);
}

/// Compares a film's coefficients at some places with differences of its loads.
fn differences(mut film: QuasiStatic, places: [[f64; 2]; 3], bound: f64) {
    const STEP: f64 = 1e-6;
    for place in places.map(Vector2::from) {
        film.place(place);
        let (_, all) = film.coefficients(1.0).unwrap();
        let mut load = |place: Vector2<f64>, moved: Vector2<f64>| {
            film.place(place);
            let still = Vector2::new(place.y, -place.x);
            film.load_at(still + moved).unwrap().load
        };
        for (k, towards) in [Vector2::x(), Vector2::y()].into_iter().enumerate() {
            let (step, none) = (STEP * towards, Vector2::zeros());
            let stiffness = (load(place + step, none) - load(place - step, none)) / (2.0 * STEP);
            let damping = (load(place, step) - load(place, -step)) / (2.0 * STEP);
            for (difference, column, size) in [
                (stiffness, all.stiffness.column(k), all.stiffness.norm()),
                (damping, all.damping.column(k), all.damping.norm()),
            ] {
                let error = (difference - column).norm() / size;
                assert!(error < bound, "{place}: {error:e}");
            }
        }
    }
}
