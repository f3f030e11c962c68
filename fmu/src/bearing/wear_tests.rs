use plain_bearing_stand::bearing::Wear;

/// 1e-16 m²/N under 800 N at 0.39 m/s on 14.92257 cm²: 2.090793e-11 m/s.
#[test]
fn depth_grows_with_force_and_speed_and_not_with_friction() {
    let rate =
        |coefficient: f64, friction: f64| Wear { coefficient }.rate(friction * 800.0 * 0.39, friction, 1.492_257e-3);
    assert!((rate(1e-16, 0.05) / 2.090_793e-11 - 1.0).abs() < 1e-5);
    assert!((rate(1e-16, 0.10) / rate(1e-16, 0.05) - 1.0).abs() < 1e-12);
    assert_eq!(rate(0.0, 0.05), 0.0);
    assert_eq!(rate(1e-16, 0.0), 0.0);
}
