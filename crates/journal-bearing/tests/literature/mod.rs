//! Published results for comparison.

/// Raimondi & Boyd (1958), Trans. ASLE 1, 159-209, full bearing with `B/D = 1`. Each row holds the eccentricity ratio (1), the
/// Sommerfeld number `S = eta N D B (R/c)^2 / F` (1), the attitude angle (degrees) and the friction variable `(R/c) f` (1).
pub const RAIMONDI_BOYD: [[f64; 4]; 7] = [
    [0.1, 1.33, 79.5, 26.4],
    [0.2, 0.631, 74.0, 12.8],
    [0.4, 0.264, 63.1, 5.79],
    [0.6, 0.121, 50.6, 3.22],
    [0.8, 0.0446, 36.2, 1.70],
    [0.9, 0.0188, 26.5, 1.05],
    [0.97, 0.00474, 15.5, 0.514],
];
