use plain_bearing_stand::{
    bearing::Flows,
    multirate::{Across, Departure, TwoScales, equilibrium},
    thermal::Temperatures,
};
use std::cell::Cell;

/// A film of 20 W at 300 K, whose heat falls with the clearance, and a bush that it warms and that widens the clearance. The
/// journal goes to a place that follows both.
#[derive(Default)]
struct Widening {
    looks: Cell<usize>,
}

impl TwoScales for Widening {
    fn period(&self) -> f64 {
        0.2
    }

    fn journal(&self, c: f64) -> impl Fn(f64, [f64; 2], f64) -> ([f64; 2], Flows) {
        move |tau, [x, y], viscosity| {
            self.looks.set(self.looks.get() + 1);
            let turning = (tau / 0.2 * std::f64::consts::TAU).sin();
            let place = 0.5 * c.powf(0.3) * viscosity.powf(-0.1) + 0.1 * turning;
            let flows =
                Flows { viscous: 20.0 * viscosity.powf(0.7) * c.powf(-1.5) * (1.0 + x * x), ..Flows::default() };
            ([20.0 * (place - x), -20.0 * y], flows)
        }
    }

    fn viscosity(&self, film_temperature: f64) -> f64 {
        (-0.03 * (film_temperature - 300.0)).exp()
    }

    fn clearance(&self, t: &Temperatures, _: f64) -> f64 {
        1.0 + 0.02 * (t.bush - 300.0)
    }

    fn is_closed(&self, _: &Temperatures, _: f64) -> bool {
        false
    }

    fn wears(&self) -> bool {
        false
    }

    fn wear_rate(&self, _: &Flows) -> f64 {
        0.0
    }

    fn thermal_rates(&self, t: &Temperatures, _: f64, flows: &Flows) -> Temperatures {
        let to_bush = t.film - t.bush;
        Temperatures {
            film: flows.viscous - to_bush,
            bush: (to_bush - (t.bush - 300.0)) / 10.0,
            shaft: 300.0 - t.shaft,
            oil: 300.0 - t.oil,
        }
    }
}

/// The film is warmer than the bush by as much as the bush is warmer than its surroundings, and its heat is a watt per
/// kelvin of that.
#[test]
fn parabolas_find_the_equilibrium_of_cubics_with_fewer_orbits() {
    let mut looks = Vec::new();
    let mut rises = Vec::new();
    for across in [Across::Parabolas, Across::Cubics] {
        let model = Widening::default();
        let from = Departure {
            before: [0.0; 2],
            eccentricity: [0.0; 2],
            temperatures: Temperatures { film: 305.0, bush: 302.0, shaft: 300.0, oil: 300.0 },
            worn: 0.0,
        };
        let t = equilibrium(&model, 1e-6, across, &from).unwrap().temperatures;
        looks.push(model.looks.get());
        let rise = t.bush - 300.0;
        assert!((t.film - t.bush - rise).abs() < 1e-5, "{across:?} {t:?}");
        rises.push(rise);
    }
    assert!((rises[0] - rises[1]).abs() < 0.02, "{rises:?}");
    assert!(rises[0] > 5.0, "{rises:?}");
    assert!(3 * looks[0] < 2 * looks[1], "{looks:?}");
}
