use plain_bearing_stand::{
    bearing::Flows,
    multirate::orbit::{Orbit, Piece},
};

fn orbit(x: f64) -> Orbit {
    let heat = 3.0 + x - 0.2 * x * x + 0.05 * x * x * x;
    Orbit([0.1 * x, -0.2, heat, heat - 4.0, 0.5 * x].into())
}

#[test]
fn a_cubic_is_its_own_piece_from_every_gap() {
    let nodes = [-1.0, -0.8, -0.3, 0.5, 0.9, 1.0].map(|x| (x, orbit(x)));
    for gap in 0..=nodes.len() {
        let piece = Piece::new(&nodes, gap);
        for x in [-1.2, -0.5, 0.0, 0.7] {
            let (value, _) = piece.at(x);
            assert!((value.0 - orbit(x).0).norm() < 1e-10, "{gap} {x}");
        }
    }
}

#[test]
fn the_last_term_shows_what_a_piece_of_lower_order_lacks() {
    let nodes = [-0.5, 0.0, 0.5].map(|x| (x, orbit(x)));
    let (whole, last) = Piece::new(&nodes, 2).at(0.2);
    let (line, _) = Piece::new(&nodes[1..], 1).at(0.2);
    assert!((whole.0 - line.0 - last).norm() < 1e-12);
}

#[test]
fn flows_come_back() {
    let flows = Flows { viscous: 12.0, boundary: 0.0, side_flow: 3e-7, feed: 0.0 };
    let back = Orbit::new([0.1, 0.2], &flows).flows();
    assert!((back.viscous - 12.0).abs() < 1e-12 && back.boundary.abs() < 1e-12);
    assert!((back.side_flow / 3e-7 - 1.0).abs() < 1e-9);
}
