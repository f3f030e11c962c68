use plain_bearing_stand::bearing::{Bearing, FILM, Film, FilmModel};

#[test]
fn every_model_is_found_by_its_value() {
    for (model, item) in FilmModel::ALL.iter().zip(FILM.items) {
        assert_eq!(FilmModel::of(item.value), *model);
        assert_eq!(format!("{model:?}"), item.name);
    }
}

#[test]
fn impossible_dimensions_are_refused() {
    let bearing = Bearing::default();
    for (width, diameter) in [(-0.02, 0.025), (0.0, 0.025), (f64::NAN, 0.025), (0.0, 0.0)] {
        let impossible = Bearing { width, diameter, ..bearing.clone() };
        let fault = Film::mobility(&impossible).map(|_| ()).unwrap_err();
        assert!(fault.to_string().contains("must be positive"), "{fault}");
    }
}
