//! Tests of the quasi-static film.

use nalgebra::Vector2;

use super::{Boundary, Grid, QuasiStatic};
use std::f64::consts::PI;

/// Raimondi and Boyd (1958), full bearing, L/D = 1: eccentricity ratio, S, attitude angle
/// (deg), (R/c) f.
const RAIMONDI_BOYD: [[f64; 4]; 7] = [
    [0.1, 1.33, 79.5, 26.4],
    [0.2, 0.631, 74.0, 12.8],
    [0.4, 0.264, 63.1, 5.79],
    [0.6, 0.121, 50.6, 3.22],
    [0.8, 0.0446, 36.2, 1.70],
    [0.9, 0.0188, 26.5, 1.05],
    [0.97, 0.00474, 15.5, 0.514],
];

/// Sommerfeld number S, attitude angle and (R/c) f of a journal at rest under a steady load.
fn steady(grid: Grid, e: f64, width: f64, boundary: Boundary) -> [f64; 3] {
    let mut film = QuasiStatic::new(grid, width, boundary);
    film.place(Vector2::new(e, 0.0));
    // Mean rotation of 1 rad/s and no squeeze: v = -z x eps.
    let w = film.load_at(Vector2::new(0.0, -e)).unwrap().load;
    // F = 12 eta (R/c)^2 R B W at the mean rotation 1 rad/s, so omega_journal = 2 and
    // S = eta N D B (R/c)^2 / F, N = omega_journal / (2 pi).
    let s = 2.0 / (2.0 * PI) * 2.0 / (12.0 * w.norm());
    let attitude = -w.y.atan2(w.x);
    // Petroff over the whole film, 2 pi^2 S / sqrt(1 - e^2), and the pressure's share.
    let friction = 2.0 * PI * PI * s / (1.0 - e * e).sqrt() + 0.5 * e * attitude.sin();
    [s, attitude.to_degrees(), friction]
}

#[test]
fn raimondi_and_boyd() {
    for [e, s, attitude, friction] in RAIMONDI_BOYD {
        let found = steady(Grid::clustered(96, 8, e, 1.0), e, 1.0, Boundary::Seam);
        assert!((found[0] / s - 1.0).abs() < 0.015, "S at {e}: {found:?}");
        assert!((found[1] - attitude).abs() < 1.0, "angle at {e}: {found:?}");
        assert!(
            (found[2] / friction - 1.0).abs() < 0.015,
            "friction at {e}: {found:?}"
        );
    }
}

#[test]
fn the_boundary_conditions_differ_as_known() {
    // At L/D = 1: 2 % in load and 4.4 degrees at e = 0.1, less than 0.4 % above 0.8.
    for (e, largest, smallest) in [(0.1, 0.025, 0.015), (0.8, 0.004, 0.0), (0.95, 0.004, 0.0)] {
        let of = |boundary| steady(Grid::clustered(192, 16, e, 1.0), e, 1.0, boundary);
        let (free, seam) = (of(Boundary::Free), of(Boundary::Seam));
        let difference = (seam[0] / free[0] - 1.0).abs();
        assert!(
            difference < largest && difference >= smallest,
            "{e}: {difference}"
        );
    }
}

/// Loads on finer and finer even grids, against the extrapolated load of fine clustered ones.
#[test]
fn converges_with_second_order_and_the_default_grids_are_close() {
    for (e, width) in [(0.5, 0.76), (0.9, 0.76), (0.97, 1.0), (0.9, 0.25)] {
        let load = |grid| steady(grid, e, width, Boundary::Free)[0].recip();
        let clustered = |k: usize| load(Grid::clustered(64 * k, 6 * k, e, width));
        let (middle, fine) = (clustered(3), clustered(6));
        let extrapolated = fine + (fine - middle) / 3.0;
        let error = |load: f64| (load / extrapolated - 1.0).abs();
        let even = [96, 192, 384].map(|n| error(load(Grid::uniform(n, n / 12))));
        // Twice finer twice; the free boundary, which moves in cells, scatters single figures.
        let order = 0.5 * (even[0] / even[2]).log2();
        let default = error(load(Grid::standard(96, 8, width)));
        let map = error(load(Grid::clustered(160, 14, e, width)));
        println!(
            "e {e}, B/D {width}: order {order:.2}, errors {even:.6?}, film's default grid {default:.6}, map's {map:.6}"
        );
        assert!(order > 1.6, "order {order} at {e}, {width}");
        // 0.3 % is the aim. At B/D = 0.25 and e = 0.9, 96 columns miss it (0.53 %): a known
        // shortfall, held here so that it does not grow.
        let limit = if width < 0.5 { 0.006 } else { 0.003 };
        assert!(default < limit, "default grid {default} at {e}, {width}");
        assert!(map < 0.001, "map's grid {map} at {e}, {width}");
    }
}

#[test]
fn short_bearing_at_the_centre() {
    // Booker (1965): M = (D/B)^2 / pi for a short bearing at eps = 0.
    let width = 0.02;
    let mut film = QuasiStatic::new(Grid::uniform(96, 4), width, Boundary::Free);
    let carried = film.velocity_under(Vector2::new(1.0, 0.0)).unwrap();
    let mobility = carried.velocity.x / 6.0;
    assert!(
        (mobility * PI * width * width - 1.0).abs() < 2e-3,
        "{mobility}"
    );
}
