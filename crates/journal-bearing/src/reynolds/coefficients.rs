//! Stiffness and damping of a film, and the speed at which a rotor begins to whirl in it.

use nalgebra::Matrix2;

/// The film's answer to a small displacement `d` and a small velocity `v` of a resting journal, in the frame of
/// [`reynolds`](crate::reynolds): the film's force on the journal changes by `-K d - B v`. In SI units of a
/// [`ReynoldsFilm`](crate::reynolds::ReynoldsFilm), in dimensionless ones of a
/// [`QuasiStatic`](crate::reynolds::QuasiStatic).
///
/// # Examples
/// Two axial grooves of 20 degrees, `B/D = 0.5`, at the eccentricity ratio 0.477: Lund & Thomsen (1978) have the attitude angle
/// 51.01 degrees and, in loads over the clearance, `Kxx` = 2.67.
/// ```
/// use std::f64::consts::FRAC_PI_2;
/// use journal_bearing::nalgebra::{Rotation2, Vector2};
/// use journal_bearing::reynolds::{Boundary, Grid, Groove, QuasiStatic};
///
/// let extent = 20_f64.to_radians();
/// let grooves = [-FRAC_PI_2, FRAC_PI_2].map(|angle| Groove { angle, extent });
/// let grid = Grid::standard(144, 8, 0.5);
/// let mut film = QuasiStatic::new(grid, 0.5, Boundary::Free).with_grooves(&grooves);
/// film.place(Rotation2::new(51.01_f64.to_radians()) * Vector2::new(0.477, 0.0));
/// let (carried, coefficients) = film.coefficients(1.0)?;
/// assert!(carried.load.y.atan2(carried.load.x).abs() < 0.01);
/// let scaled = coefficients.stiffness / carried.load.norm();
/// assert!((scaled.m11 / 2.67 - 1.0).abs() < 0.025);
/// # Ok::<(), journal_bearing::reynolds::NotConverged>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// `K`, N/m; or the derivative of the load `W` by the eccentricity ratio, 1/s.
    pub stiffness: Matrix2<f64>,
    /// `B`, N.s/m; or the derivative of `W` by the eccentricity ratio's velocity, 1.
    pub damping: Matrix2<f64>,
}

impl Coefficients {
    /// The speed at which a rigid rotor begins to whirl, rad/s; infinite where none makes it whirl. Its mass on this bearing is
    /// `mass`, kg, and `speed` is the journal's, rad/s, at which the coefficients hold: as numbers in loads over the clearance they
    /// are taken to hold at any speed.
    ///
    /// In the dimensionless quantities of [`reynolds`](crate::reynolds) and with the load for the mass it is `Omega sqrt(c/g)`
    /// of a rotor whose weight is the load.
    ///
    /// At the threshold the rotor circles without growing: mass, damping and stiffness have a root without a real part (Lund
    /// 1974, J. Eng. Ind. 96, 509-517).
    pub fn whirl_threshold(&self, mass: f64, speed: f64) -> f64 {
        let (k, b) = (&self.stiffness, &self.damping);
        let turned = k.m11 * b.m22 + k.m22 * b.m11 - k.m12 * b.m21 - k.m21 * b.m12;
        let equal = turned / b.trace();
        // The square of the frequency over the speed with which it circles.
        let squared = ((equal - k.m11) * (equal - k.m22) - k.m12 * k.m21) / (b.determinant() * speed * speed);
        if squared > 0.0 { (equal / mass / squared).sqrt() } else { f64::INFINITY }
    }
}
