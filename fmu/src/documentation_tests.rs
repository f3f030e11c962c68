use plain_bearing_stand::documentation::page;

#[test]
fn the_committed_page_is_fresh() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../modelDescription/documentation/index.html");
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        committed.replace("\r\n", "\n") == page(),
        "{path} is stale: run `cargo run -p plain-bearing-stand --bin model-description`"
    );
}

#[test]
fn values_are_shown_in_their_display_units() {
    let html = page();
    assert!(html.contains("<code>bearing.radialClearance</code></td><td class=\"number\">0.02</td><td>mm</td>"));
    assert!(html.contains("<code>bearing.film</code></td><td class=\"number\">Mobility</td>"));
}
