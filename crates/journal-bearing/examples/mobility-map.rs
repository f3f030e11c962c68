//! Makes the mobility map from solutions of the Reynolds equation, and prints its errors against direct solutions at points
//! between the map's nodes.
//!
//!     cargo run --release -p journal-bearing --example mobility-map [-- --rough] [--check]
//!
//! `--rough` makes the table of rough films' corrections instead, and prints its errors. `--check` only prints the errors of
//! what is committed.

use std::error::Error;
use std::f64::consts::PI;
use std::sync::Mutex;

use journal_bearing::contact::{ContactTable, NO_CONTACT, Surface};
use journal_bearing::mobility::{
    MobilityMap, RoughSlices, SliceFamily, exact, exact_between, generate, generate_rough,
};
use nalgebra::Vector2;

/// The file that the library includes.
const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/mobility/map.bin");

const ROUGH_FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/mobility/rough.bin");

const QUANTITIES: [&str; 3] = ["mobility vector", "largest pressure", "side flow"];

/// Number of points at which the table of rough films is compared.
const ROUGH_POINTS: usize = 800;

/// Number of points at which the map is compared with direct solutions.
const POINTS: usize = 2000;

/// The grid of those direct solutions, finer than the map's own.
const CELLS: [usize; 2] = [256, 20];

fn main() -> Result<(), Box<dyn Error>> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let asked = |option: &str| std::env::args().any(|argument| argument == option);
    if asked("--rough") {
        if !asked("--check") {
            return save(ROUGH_FILE, &generate_rough()?);
        }
        return report_rough();
    }
    let map = if asked("--check") {
        MobilityMap::built_in()?
    } else {
        let map = generate()?;
        save(FILE, &map.to_bytes()?)?;
        map
    };
    report(&SliceFamily::new(&map), threads)
}

/// Writes a file that the library includes.
fn save(file: &str, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    std::fs::write(file, bytes).map_err(|error| format!("{file}: {error}"))?;
    println!("{file}: {} bytes", bytes.len());
    Ok(())
}

/// Prints the errors of the committed table of rough films against direct solutions between its nodes.
fn report_rough() -> Result<(), Box<dyn Error>> {
    let family = SliceFamily::new(&MobilityMap::built_in()?);
    let mut errors: Vec<([f64; 3], [f64; 4])> = Vec::new();
    for n in 0..ROUGH_POINTS {
        let [width, share, angle] = point(n);
        let roughness = 0.002 * 300_f64.powf((0.37 + 0.618_034 * n as f64).fract());
        let start = (1.0 - NO_CONTACT * roughness).max(0.0);
        let e = start + (1.0 + 2.5 * roughness - start) * share;
        let (eps, load) = (Vector2::new(e, 0.0), Vector2::new(angle.cos(), angle.sin()));
        let surface = Surface { roughness, ..Surface::default() };
        let Some(touch) = ContactTable::new(&surface, 1.0, width, 1.0).touch(e) else {
            continue;
        };
        let slices = RoughSlices::new(&family.slice(width), width, roughness, 1.0)?;
        let film = slices.with_clearance(1.0).look_up(eps, e, &touch, load);
        let direct = exact_between(roughness, width, e, angle, CELLS)?;
        let of = [
            (film.mobility() - direct.mobility).norm() / direct.mobility.norm(),
            (film.max_pressure() / direct.max_pressure - 1.0).abs(),
            (film.side_flow() / direct.side_flow - 1.0).abs(),
        ];
        errors.push((of, [width, roughness, e, angle.to_degrees()]));
    }
    for (k, name) in QUANTITIES.iter().enumerate() {
        let mean = errors.iter().map(|(of, _)| of[k]).sum::<f64>() / errors.len() as f64;
        errors.sort_by(|a, b| a.0[k].total_cmp(&b.0[k]));
        let of = |share: f64| &errors[(share * (errors.len() - 1) as f64) as usize];
        let (worst, [width, roughness, e, angle]) = of(1.0);
        println!(
            "{name}: mean error {:.3} %, 95 % of {} below {:.2} %, largest {:.2} % at B/D {width:.3}, roughness/clearance {roughness:.4}, e {e:.4}, load {angle:.1} deg ahead",
            100.0 * mean,
            errors.len(),
            100.0 * of(0.95).0[k],
            100.0 * worst[k],
        );
    }
    Ok(())
}

/// Prints the map's mean and largest errors.
fn report(map: &SliceFamily, threads: usize) -> Result<(), Box<dyn Error>> {
    let points: Vec<[f64; 3]> = (0..POINTS).map(point).collect();
    let share = points.len().div_ceil(threads);
    let errors = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for part in points.chunks(share) {
            let errors = &errors;
            scope.spawn(move || {
                for &[width, e, angle] in part {
                    let error = compare(map, width, e, angle);
                    if let Ok(mut errors) = errors.lock() {
                        errors.push((error, [width, e, angle]));
                    }
                }
            });
        }
    });
    let errors = errors.into_inner()?;
    for (k, name) in QUANTITIES.iter().enumerate() {
        let mut settled = Vec::new();
        for (error, at) in &errors {
            settled.push((error.clone()?[k], *at));
        }
        let mean = settled.iter().map(|(error, _)| error).sum::<f64>() / settled.len() as f64;
        let Some(worst) = settled.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        let [width, e, angle] = worst.1;
        println!(
            "{name}: mean error {:.4} %, largest {:.3} % at B/D {width:.3}, e {e:.4}, load {:.1} deg ahead ({} points, B/D 0.25..1.5, e 0.05..0.98)",
            100.0 * mean,
            100.0 * worst.0,
            angle.to_degrees(),
            settled.len(),
        );
    }
    Ok(())
}

/// The map's relative errors at one point.
fn compare(map: &SliceFamily, width: f64, e: f64, angle: f64) -> Result<[f64; 3], String> {
    let direct = exact(width, e, angle, CELLS).map_err(|error| error.to_string())?;
    let slice = map.slice(width);
    let (eps, load) = (Vector2::new(e, 0.0), Vector2::new(angle.cos(), angle.sin()));
    let film = slice.look_up(eps, eps.norm(), load);
    Ok([
        (slice.mobility_vector(eps, load) - direct.mobility).norm() / direct.mobility.norm(),
        (film.max_pressure() / direct.max_pressure - 1.0).abs(),
        (film.side_flow() / direct.side_flow - 1.0).abs(),
    ])
}

/// Point `n` of an even, irregular cover (R3 sequence, Roberts 2018) of `B/D` 0.25..1.5, eccentricity ratio 0.05..0.98 and
/// load direction, rad. In every other point the load is within a few `sqrt(1 - e)` of the eccentricity, where journals
/// run.
fn point(n: usize) -> [f64; 3] {
    const PHI: f64 = 1.220_744_084_605_759_5;
    let at = |k: i32| (0.5 + (n + 1) as f64 / PHI.powi(k)).fract();
    let e = 0.05 + 0.93 * at(2);
    let span = if n.is_multiple_of(2) { PI } else { (3.0 * (1.0 - e).sqrt()).min(PI) };
    [0.25 + 1.25 * at(1), e, span * (2.0 * at(3) - 1.0)]
}
