use plain_bearing_stand::{bearing::Flows, multirate::Correction};

/// A fast film's flows, and a slow film's with other powers of the viscosity. Boundary friction sets in below 20 mPa.s.
fn films(viscosity: f64) -> [Flows; 2] {
    let flows = |power: f64| Flows {
        viscous: 40.0 * viscosity.powf(power),
        boundary: 500.0 * (0.02 - viscosity).max(0.0) * viscosity.powf(power - 0.5),
        side_flow: 1e-9 / viscosity.powf(power),
        feed: 0.0,
    };
    [flows(0.5), flows(0.45)]
}

fn known(viscosities: &[f64]) -> Correction {
    let mut correction = Correction::default();
    for &viscosity in viscosities {
        let [fast, slow] = films(viscosity);
        correction.learn(viscosity, &slow, &fast);
    }
    correction
}

fn heat(flows: &Flows) -> f64 {
    flows.viscous + flows.boundary
}

#[test]
fn two_nodes_correct_a_ratio_that_is_a_power() {
    let correction = known(&[0.03, 0.008]);
    for viscosity in [0.009, 0.015, 0.025] {
        let [fast, slow] = films(viscosity);
        let corrected = correction.apply(viscosity, &fast);
        assert!((heat(&corrected) / heat(&slow) - 1.0).abs() < 1e-3, "{viscosity}: {corrected:?} {slow:?}");
        assert!((corrected.side_flow / slow.side_flow - 1.0).abs() < 1e-6);
    }
}

#[test]
fn nothing_is_corrected_where_nothing_is_known() {
    let [fast, _] = films(0.01);
    assert_eq!(Correction::default().apply(0.01, &fast), fast);
}

#[test]
fn a_node_takes_the_place_of_one_next_to_it() {
    let mut correction = known(&[0.03, 0.008]);
    let [fast, _] = films(0.008);
    correction.learn(0.00801, &fast, &fast);
    let corrected = correction.apply(0.00801, &fast);
    assert!((heat(&corrected) / heat(&fast) - 1.0).abs() < 1e-12);
    assert_eq!(correction.nodes.len(), 2);
}

#[test]
fn distances_count_from_the_nearest_node() {
    let correction = known(&[0.01, 0.02]);
    assert!((correction.distance(0.005) - 2f64.ln()).abs() < 1e-12);
    assert!((correction.distance(0.018) - (0.02 / 0.018f64).ln()).abs() < 1e-12);
    assert_eq!(Correction::default().distance(0.01), f64::INFINITY);
}
