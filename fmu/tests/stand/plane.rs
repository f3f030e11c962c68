//! A load that turns, reverses and hits: against loads at rest, and against a film that this test solves in its own way.

use fmu_export::model::{Experiment, Model};
use nalgebra::{Matrix2, Rotation2, Vector2};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::stand::Stand;
use std::f64::consts::{PI, TAU};

const SPEED: f64 = 100.0;

/// The smooth, isothermal stand without its load mechanism, both of whose films are of the same kind: without conserved mass.
fn bare(film: FilmModel) -> Stand {
    let mut stand = Stand::default();
    stand.thermal.isothermal = true;
    stand.bearing.surface.roughness = 0.0;
    stand.bearing.resolution.mass_conserving = false;
    stand.film.model = film;
    stand.load.lever_ratio = 0.0;
    stand.inputs.speed.value = SPEED;
    stand
}

/// The journal's path, as eccentricity-ratio vectors, under the load of the function of time, N, which is linear within steps.
fn path(stand: &mut Stand, steps: usize, step: f64, load: impl Fn(f64) -> Vector2<f64>) -> Vec<Vector2<f64>> {
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    let advance = |k: usize| {
        let time = k as f64 * step;
        let now = load(time);
        let slope = (load(time + step) - now) / step;
        let inputs = &mut stand.inputs;
        (inputs.external_force_x.value, inputs.external_force_y.value) = (now.x, now.y);
        (inputs.external_force_x.slope, inputs.external_force_y.slope) = (slope.x, slope.y);
        stand.advance(time, step, &mut ()).unwrap();
        place(stand)
    };
    (0..steps).map(advance).collect()
}

fn place(stand: &Stand) -> Vector2<f64> {
    let readings = stand.readings();
    turned(readings.attitude_angle) * readings.eccentricity_ratio
}

/// The unit vector at an angle, rad.
fn turned(angle: f64) -> Vector2<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector2::new(cos, sin)
}

/// A load that turns as a whole turns the journal's place, and neither friction nor coefficients along and across the load know.
#[test]
fn no_direction_is_special() {
    for (film, angles, close) in [
        (FilmModel::Mobility, [1.0, -2.5], 1e-9),
        // Its cells lie alike after a quarter of a turn.
        (FilmModel::Reynolds, [0.5 * PI, PI], 1e-9),
        (FilmModel::Reynolds, [1.0, -2.5], 1e-3),
    ] {
        let under = |angle: f64| {
            let mut stand = bare(film);
            path(&mut stand, 1, 5.0, |_| turned(angle) * 500.0);
            stand
        };
        let along = under(0.0);
        for angle in angles {
            let other = under(angle);
            let back = Rotation2::new(-angle);
            let off = (back * place(&other) - place(&along)).norm();
            let friction = [&along, &other].map(|stand| stand.readings().friction_coefficient);
            let [here, there] = [&along, &other].map(|stand| stand.resting().coefficients.stiffness);
            let there = back.matrix() * there * back.inverse().matrix();
            let (rubs, gives) = (friction[1] / friction[0] - 1.0, (there - here).norm() / here.norm());
            println!("{film:?} at {angle}: {off:.1e} {rubs:.1e} {gives:.1e}");
            assert!(off < close && rubs.abs() < close && gives < 100.0 * close, "{film:?} at {angle}");
        }
    }
}

/// In a frame that turns with the load, a film sees the shaft turn at `omega - 2 omega_load`, and a load at rest (Pinkus & Sternlicht
/// 1961, Theory of Hydrodynamic Lubrication, ch. 8): backwards at the shaft's speed it carries like a shaft three times as fast, and
/// with the shaft like one that turns the other way. At half the speed nothing draws oil in: the film is only squeezed.
#[test]
fn a_turning_load_is_one_at_rest_at_another_speed() {
    for film in [FilmModel::Mobility, FilmModel::Reynolds] {
        for (ratio, seen) in [(-1.0, 3.0), (1.0, -1.0), (0.25, 0.5)] {
            let step = TAU / SPEED / 200.0;
            let steps = 1000;
            let end = steps as f64 * step;
            let turning = path(&mut bare(film), steps, step, |time| turned(ratio * SPEED * time) * 500.0);
            let seen_from_load = Rotation2::new(-ratio * SPEED * end) * turning[steps - 1];
            let mut still = bare(film);
            still.inputs.speed.value = seen * SPEED;
            let resting = path(&mut still, 1, 5.0, |_| Vector2::new(500.0, 0.0))[0];
            assert!((seen_from_load - resting).norm() < 1e-3, "{film:?} at {ratio}: {seen_from_load} {resting}");
        }
        let step = TAU / SPEED / 200.0;
        let half = path(&mut bare(film), 400, step, |time| turned(0.5 * SPEED * time) * 500.0);
        let mut still = bare(film);
        still.inputs.speed.value = 0.0;
        let squeezed = path(&mut still, 400, step, |_| Vector2::new(500.0, 0.0));
        for (turning, squeezed) in half.iter().zip(&squeezed) {
            assert!((turning.norm() - squeezed.norm()).abs() < 1e-3, "{film:?}: {turning} {squeezed}");
        }
    }
}

const COLUMNS: usize = 72;
const ROWS: usize = 6;

/// A film of finite differences with `p >= 0`, on half of a bearing's width, solved by projected relaxation (Christopherson 1941,
/// Proc. Inst. Mech. Eng. 146, 126-135). Angles count from x.
struct Squeezed {
    radius: f64,
    width: f64,
    clearance: f64,
    viscosity: f64,
    speed: f64,
    pressure: Vec<[f64; ROWS]>,
}

impl Squeezed {
    fn of(stand: &Stand) -> Self {
        Self {
            radius: stand.bearing.radius(),
            width: stand.bearing.width,
            clearance: stand.bearing.radial_clearance,
            viscosity: stand.readings().film_viscosity,
            speed: SPEED,
            pressure: vec![[0.0; ROWS]; COLUMNS],
        }
    }

    /// The film's force on the journal, N, at an eccentricity-ratio vector and its rate, 1/s.
    fn force(&mut self, e: Vector2<f64>, rate: Vector2<f64>) -> Vector2<f64> {
        let (across, along) = (self.radius * TAU / COLUMNS as f64, 0.5 * self.width / ROWS as f64);
        let gap = |column: f64| {
            let n = turned(TAU * column / COLUMNS as f64);
            self.clearance * (1.0 - e.dot(&n))
        };
        let cube = |h: f64| h * h * h;
        let columns: Vec<[f64; 4]> = (0..COLUMNS)
            .map(|k| {
                let k = k as f64;
                let [before, here, after] = [-0.5, 0.0, 0.5].map(|by| gap(k + by));
                let n = turned(TAU * k / COLUMNS as f64);
                let wedge = 6.0 * self.viscosity * self.speed * self.radius * (after - before) / across;
                let squeeze = -12.0 * self.viscosity * self.clearance * rate.dot(&n);
                [
                    cube(before) / across.powi(2),
                    cube(after) / across.powi(2),
                    cube(here) / along.powi(2),
                    wedge + squeeze,
                ]
            })
            .collect();
        const OVER: f64 = 1.7;
        for _ in 0..3000 {
            let (mut change, mut most) = (0.0_f64, 0.0_f64);
            for (k, [west, east, side, source]) in columns.iter().enumerate() {
                let left = self.pressure[(k + COLUMNS - 1) % COLUMNS];
                let right = self.pressure[(k + 1) % COLUMNS];
                for row in 0..ROWS {
                    let here = self.pressure[k];
                    // Row 0 touches the middle of the bearing, the last one its end, half a cell away.
                    let (inner, inward) = if row == 0 { (0.0, 0.0) } else { (here[row - 1], 1.0) };
                    let (outer, outward) = if row + 1 == ROWS { (0.0, 2.0) } else { (here[row + 1], 1.0) };
                    let flows = west * left[row] + east * right[row] + side * (inward * inner + outward * outer);
                    let balance = west + east + side * (inward + outward);
                    let new = here[row] + OVER * ((flows - source) / balance - here[row]);
                    let new = new.max(0.0);
                    change = change.max((new - here[row]).abs());
                    most = most.max(new);
                    self.pressure[k][row] = new;
                }
            }
            if change <= 1e-6 * most {
                break;
            }
        }
        let area = 2.0 * across * along;
        let push = |(k, rows): (usize, &[f64; ROWS])| {
            turned(TAU * k as f64 / COLUMNS as f64) * (-area * rows.iter().sum::<f64>())
        };
        self.pressure.iter().enumerate().map(push).sum()
    }

    /// The rate at which the film's force holds a load, by Newton's method from a guess.
    fn rate(&mut self, e: Vector2<f64>, load: Vector2<f64>, mut rate: Vector2<f64>) -> Vector2<f64> {
        for _ in 0..30 {
            let miss = self.force(e, rate) + load;
            if miss.norm() < 1e-4 * load.norm() {
                break;
            }
            let nudge = 1e-3 * SPEED;
            let columns = [Vector2::x(), Vector2::y()]
                .map(|towards| (self.force(e, rate + towards * nudge) + load - miss) / nudge);
            let slopes = Matrix2::from_columns(&columns);
            rate -= slopes.lu().solve(&miss).expect("a film resists");
        }
        rate
    }

    /// The journal's path from the middle, by Heun's method in steps that halve those of the load.
    fn path(&mut self, steps: usize, step: f64, load: impl Fn(f64) -> Vector2<f64>) -> Vec<Vector2<f64>> {
        let (mut e, mut rate) = (Vector2::zeros(), Vector2::zeros());
        let half = 0.5 * step;
        let mut now = |k: usize| {
            let [begin, end] = [k, k + 1].map(|k| load(k as f64 * step));
            for (from, to) in [(begin, 0.5 * (begin + end)), (0.5 * (begin + end), end)] {
                let first = self.rate(e, from, rate);
                rate = self.rate(e + first * half, to, first);
                e += (first + rate) * (0.5 * half);
            }
            e
        };
        (0..steps).map(&mut now).collect()
    }
}

/// A load, N, over the time, s.
type Load<'a> = &'a dyn Fn(f64) -> Vector2<f64>;

/// How far two paths are apart, at most.
fn apart(one: &[Vector2<f64>], other: &[Vector2<f64>]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// A load that turns in an ellipse, one that reverses, and one that hits.
#[test]
fn both_films_follow_a_film_solved_in_another_way() {
    let turn = TAU / SPEED;
    let loads: [(&str, Load); 3] = [
        ("ellipse", &|time| {
            let angle = 0.7 * SPEED * time;
            Vector2::new(600.0 * angle.cos(), 250.0 * angle.sin())
        }),
        ("reversing", &|time| Vector2::new(400.0 * (SPEED * time).cos(), 100.0)),
        ("impact", &|time| {
            let hit = (PI * (time - turn) / (0.1 * turn)).sin();
            let within = (turn..1.1 * turn).contains(&time);
            Vector2::new(150.0, if within { 3000.0 * hit } else { 0.0 })
        }),
    ];
    let (steps, step) = (120, turn / 100.0);
    for (name, load) in loads {
        let mut stand = bare(FilmModel::Mobility);
        let mobility = path(&mut stand, steps, step, load);
        let reynolds = path(&mut bare(FilmModel::Reynolds), steps, step, load);
        let other = Squeezed::of(&stand).path(steps, step, load);
        let [mobility, reynolds] = [mobility, reynolds].map(|film| apart(&film, &other));
        println!("{name}: mobility {mobility:.4}, Reynolds {reynolds:.4}");
        assert!(mobility < 0.01 && reynolds < 0.01, "{name}: {mobility} {reynolds}");
    }
}
