//! The stand whose bush is fed with oil.

use fmu_export::model::{Experiment, Fault, Model};
use plain_bearing_stand::bearing::{Feeding, FilmModel};
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;
use plain_bearing_stand::thermal::Initialization;

/// The stand under a constant load in a Reynolds film of few cells.
fn fed(feed: Feeding) -> Stand {
    let mut stand = Stand::default();
    stand.film.model = FilmModel::Reynolds;
    stand.bearing.resolution.columns = 48;
    stand.bearing.resolution.rows = 4;
    stand.bearing.supply.feed = feed;
    stand.bearing.supply.extent = 0.4;
    stand.bearing.supply.length = 0.01;
    stand.load.eccentricity = 0.0;
    stand
}

fn after(stand: &mut Stand, seconds: f64) -> Readings {
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    let step = 0.5;
    for k in 0..(seconds / step) as usize {
        stand.advance(k as f64 * step, step, &mut ()).unwrap();
    }
    *stand.readings()
}

#[test]
fn the_mobility_film_refuses_a_feed() {
    let mut stand = fed(Feeding::Hole);
    stand.film.model = FilmModel::Mobility;
    let refused = stand.initialise(&Experiment::default(), &mut ());
    let Err(Fault::Invalid(why)) = refused else {
        panic!("{refused:?}");
    };
    assert!(why.contains("bearing.feed = Hole"), "{why}");
    assert!(why.contains("bearing.film = Reynolds"), "{why}");
}

#[test]
fn a_groove_all_around_is_one() {
    let mut stand = fed(Feeding::CircumferentialGroove);
    stand.bearing.supply.count = 2;
    let refused = stand.initialise(&Experiment::default(), &mut ());
    let Err(Fault::Invalid(why)) = refused else {
        panic!("{refused:?}");
    };
    assert!(why.contains("bearing.feedCount is 2"), "{why}");
    assert!(why.contains("circumferential groove"), "{why}");
}

/// More pressure feeds more oil, and cold oil cools a hot film; without a feed there is no such flow.
#[test]
fn feeds_feed_and_cool() {
    let plain = after(&mut fed(Feeding::None), 2.0);
    assert_eq!(plain.feed_flow, 0.0);
    for feed in [Feeding::AxialGrooves, Feeding::Hole, Feeding::CircumferentialGroove] {
        let of = |pressure: f64| {
            let mut stand = fed(feed);
            stand.bearing.supply.pressure = pressure;
            after(&mut stand, 2.0)
        };
        let [low, high] = [1e5, 3e5].map(of);
        println!(
            "{feed:?}: {:e} {:e} m3/s, {} {} K",
            low.feed_flow, high.feed_flow, low.film_temperature, high.film_temperature
        );
        assert!(0.0 < low.feed_flow && low.feed_flow < high.feed_flow, "{feed:?}");
        assert!(high.film_temperature < low.film_temperature, "{feed:?}");
        assert!(low.film_temperature < plain.film_temperature, "{feed:?}");
    }
}

/// The steady start stays where it is, with a feed that carries more heat than all conductances.
#[test]
fn the_steady_start_knows_the_feed() {
    let mut stand = fed(Feeding::AxialGrooves);
    stand.thermal.initialization = Initialization::SteadyState;
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    let start = *stand.readings();
    for k in 0..8 {
        stand.advance(f64::from(k), 1.0, &mut ()).unwrap();
    }
    let end = stand.readings();
    println!("{} {} K", start.film_temperature, end.film_temperature);
    for (name, start, end) in [
        ("film", start.film_temperature, end.film_temperature),
        ("bush", start.bearing_temperature, end.bearing_temperature),
        ("oil", start.oil_temperature, end.oil_temperature),
    ] {
        assert!((start - end).abs() < 4e-4, "{name}: {start} {end}");
    }
}
