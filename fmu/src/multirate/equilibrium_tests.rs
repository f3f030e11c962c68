use plain_bearing_stand::{
    bearing::Flows,
    multirate::{Across, Departure, Matrix4, NoEquilibrium, TwoScales, equilibrium, slowest_time_constant},
    thermal::Temperatures,
};

/// A film that is heated by what `heat` says of its temperature, and that loses 1 W/K at 300 K. The journal goes to
/// the middle.
struct Toy(fn(f64) -> f64);

impl TwoScales for Toy {
    fn period(&self) -> f64 {
        0.2
    }

    fn journal(&self, _: f64) -> impl Fn(f64, [f64; 2], f64) -> ([f64; 2], Flows) {
        move |_, [x, y], viscosity| {
            let flows = Flows { viscous: (self.0)(300.0 - viscosity.ln() / 0.03), ..Flows::default() };
            ([-10.0 * x, -10.0 * y], flows)
        }
    }

    /// Falls by 3 % per kelvin, as that of oil.
    fn viscosity(&self, film_temperature: f64) -> f64 {
        (-0.03 * (film_temperature - 300.0)).exp()
    }

    fn clearance(&self, _: &Temperatures, _: f64) -> f64 {
        1.0
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
        Temperatures {
            film: (flows.viscous - (t.film - 300.0)) / 10.0,
            bush: 300.0 - t.bush,
            shaft: 300.0 - t.shaft,
            oil: 300.0 - t.oil,
        }
    }
}

fn from(film: f64) -> Departure {
    Departure {
        before: [0.0; 2],
        eccentricity: [0.0; 2],
        temperatures: Temperatures { film, bush: 300.0, shaft: 300.0, oil: 300.0 },
        worn: 0.0,
    }
}

/// Heat in less heat out is `-(T - 310)(T - 340)(T - 370)/1000` W: equilibria at 310, 340 and 370 K.
const THREE: Toy = Toy(|t| t - 300.0 - (t - 310.0) * (t - 340.0) * (t - 370.0) / 1e3);

#[test]
fn each_basin_has_its_equilibrium() {
    for (begin, end) in [(301.0, 310.0), (339.8, 310.0), (340.2, 370.0), (400.0, 370.0)] {
        let equilibrium = equilibrium(&THREE, 1e-7, Across::Cubics, &from(begin)).unwrap();
        assert!((equilibrium.temperatures.film - end).abs() < 1e-3, "{begin}: {equilibrium:?}");
        // The derivative at either end is -30*60/1000 W/K over 10 J/K.
        let slowest = slowest_time_constant(&equilibrium.drift);
        assert!((slowest - 10.0 / 1.8).abs() < 0.01, "{slowest}");
    }
}

#[test]
fn an_unstable_equilibrium_is_refused() {
    let result = equilibrium(&THREE, 1e-7, Across::Cubics, &from(340.0));
    let Err(NoEquilibrium::Unstable { film, growth }) = result else {
        unreachable!("{result:?}");
    };
    assert!((film - 340.0).abs() < 1e-3 && (growth - 10.0 / 0.9).abs() < 0.1, "{growth}");
}

#[test]
fn a_runaway_is_refused() {
    let result = equilibrium(&Toy(|t| 1.1 * (t - 300.0) + 1.0), 1e-6, Across::Cubics, &from(300.0));
    assert!(matches!(result, Err(NoEquilibrium::Runaway { node: "film", .. })), "{result:?}");
}

#[test]
fn a_drift_that_is_no_number_has_no_time_constant() {
    assert_eq!(slowest_time_constant(&Matrix4::repeat(f64::NAN)), 0.0);
    assert_eq!(slowest_time_constant(&Matrix4::zeros()), 1e12);
    assert_eq!(slowest_time_constant(&-Matrix4::identity()), 1.0);
}
