//! Speed of the film models: `cargo bench -p journal-bearing --bench film`.

use std::hint::black_box;

use divan::Bencher;
use journal_bearing::mobility::{MobilityMap, SliceFamily};
use journal_bearing::reynolds::{Boundary, Cavitation, Drive, FilmSettings, Grid, QuasiStatic, ReynoldsFilm};
use nalgebra::Vector2;

fn main() {
    divan::main();
}

/// Speed, rad/s, and viscosity, Pa.s.
const SPEED: f64 = 31.416;
const VISCOSITY: f64 = 0.02;

/// One warm internal step of the transient film over a load cycle of 750 N +- 20 %. It advances film and journal in two
/// implicit stages and evaluates forces, flows and both balances at its end. The time is that of the whole step.
#[divan::bench(args = [Cavitation::NonNegative, Cavitation::MassConserving], sample_count = 1000, sample_size = 1)]
fn transient_step_of_two_stages_96x8(bencher: Bencher<'_, '_>, cavitation: Cavitation) {
    // The tolerance is so loose that every interval is one internal step.
    let settings = FilmSettings { cavitation, tolerance: 1.0, ..FilmSettings::new(0.019, 0.025, 20e-6) };
    let Ok(mut film) = ReynoldsFilm::new(settings) else {
        return;
    };
    let load = |t: f64| Vector2::new(750.0 * (1.0 + 0.2 * (SPEED * t).sin()), 0.0);
    let step = 1e-3;
    let mut t = 0.0;
    let mut go = || {
        let drive = Drive {
            load_before: load(t),
            load_after: load(t + step),
            ..Drive::steady(Vector2::zeros(), SPEED, VISCOSITY)
        };
        t += step;
        film.advance(step, &drive, &|_| 0.0)
    };
    // Two turns of warm-up. The cost varies over the cycle; 1000 samples are five whole turns.
    for _ in 0..400 {
        assert!(black_box(go()).is_ok_and(|report| report.steps == 1));
    }
    bencher.bench_local(go);
}

/// The quasi-static film's velocity under a load that turns slightly from call to call, warm.
#[divan::bench]
fn quasi_static_96x8(bencher: Bencher<'_, '_>) {
    let mut film = QuasiStatic::new(Grid::standard(96, 8, 0.76), 0.76, Boundary::Free);
    let mut angle: f64 = 0.4;
    bencher.bench_local(|| {
        angle += 1e-3;
        film.place(Vector2::new(0.89, 0.0));
        film.velocity_under(Vector2::new((0.4 * angle.sin()).cos(), (0.4 * angle.sin()).sin()))
    });
}

/// One look-up of the mobility vector.
#[divan::bench]
fn mobility(bencher: Bencher<'_, '_>) {
    let Ok(map) = MobilityMap::built_in() else {
        return;
    };
    let slice = SliceFamily::new(&map).slice(0.76);
    let direction = Vector2::new(1.0, 0.0);
    let mut k = 0_u32;
    bencher.bench_local(|| {
        k = k.wrapping_add(1) & 63;
        let eps = Vector2::new(0.8, 0.3 + 0.001 * f64::from(k));
        black_box(slice.mobility_vector(black_box(eps), black_box(direction)))
    });
}
