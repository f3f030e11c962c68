//! Where a journal stands in its contact.

use super::{FULL, NO_CONTACT, Width, share};

/// A gap that a smooth film would need for a similar mobility: `H` where asperities do not touch, nearly constant where the
/// mean planes have crossed; with its slope.
pub fn room(ratio: f64) -> Width {
    /// The least room, and how gradually the room comes to it.
    const LEAST: f64 = 0.7;
    const GRADUAL: f64 = 1.0;
    if ratio >= NO_CONTACT {
        return [ratio, 1.0];
    }
    let over = ratio - LEAST;
    let root = (over * over + GRADUAL).sqrt();
    let (open, slope) = (LEAST + 0.5 * (over + root), 0.5 * (1.0 + over / root));
    let t = ((ratio - FULL) / (NO_CONTACT - FULL)).max(0.0);
    let (counts, fall) = (share(ratio), -6.0 * t * (1.0 - t) / (NO_CONTACT - FULL));
    [ratio + counts * (open - ratio), 1.0 + counts * (slope - 1.0) + fall * (open - ratio)]
}

/// Where an aligned, round journal stands in its contact: coordinates of the tables of contact and of rough films.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Roughness over clearance.
    roughness: f64,
    /// Eccentricity ratio at which contact begins.
    pub start: f64,
    /// Length, in the eccentricity ratio, up to where the mean planes have crossed by three roughnesses.
    pub length: f64,
    /// The room of a centred journal.
    whole: f64,
    /// Where the place's coordinate begins, and its length.
    first: f64,
    span: f64,
}

/// How far, in roughnesses, the mean planes cross at the end of the reach.
const CROSSING: f64 = 3.0;
/// The places crowd where the film ratio is within this of zero, as the film changes most there.
const CROWDED: f64 = 0.5;

impl Reach {
    /// The contact at a roughness over clearance.
    pub fn new(roughness: f64) -> Self {
        let [start, length] = Self::along(roughness);
        let first = ((1.0 - start) / roughness / CROWDED).asinh();
        Self {
            roughness,
            start,
            length,
            whole: room(1.0 / roughness)[0],
            first,
            span: first + (CROSSING / CROWDED).asinh(),
        }
    }

    /// Start and length of the contact alone.
    #[inline]
    pub fn along(roughness: f64) -> [f64; 2] {
        let start = (1.0 - NO_CONTACT * roughness).max(0.0);
        [start, 1.0 + CROSSING * roughness - start]
    }

    /// The room at an eccentricity ratio: the relative gap of the smooth bearing to which the film is compared. It is `1 - e`
    /// where asperities do not touch, and one in the centre. With its slope.
    pub fn room(&self, e: f64) -> Width {
        let [room, slope] = room((1.0 - e) / self.roughness);
        [room / self.whole, -slope / (self.roughness * self.whole)]
    }

    /// The place of an eccentricity ratio, from 0 where contact begins to 1 at the end of the reach; with its slope.
    pub fn place(&self, e: f64) -> Width {
        let at = (1.0 - e) / self.roughness / CROWDED;
        let slope = 1.0 / (self.roughness * CROWDED * (at * at + 1.0).sqrt());
        [(self.first - at.asinh()) / self.span, slope / self.span]
    }

    /// The eccentricity ratio of a place.
    pub fn at(&self, place: f64) -> f64 {
        let ratio = CROWDED * (self.first - place * self.span).sinh();
        1.0 - ratio * self.roughness
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_leads_back_to_its_eccentricity() {
        for roughness in [1e-3, 0.05, 0.25, 4.0] {
            let reach = Reach::new(roughness);
            for place in [0.0, 0.3, 0.77, 1.0] {
                let e = reach.at(place);
                assert!((reach.place(e)[0] - place).abs() < 1e-9);
                let d = 1e-5 * roughness;
                let [here, there] = [e - d, e + d].map(|e| (reach.place(e)[0], reach.room(e)[0]));
                let slopes = [reach.place(e)[1], reach.room(e)[1]];
                let differences = [(there.0 - here.0) / (2.0 * d), (there.1 - here.1) / (2.0 * d)];
                for (slope, difference) in slopes.into_iter().zip(differences) {
                    assert!((slope / difference - 1.0).abs() < 1e-3, "{roughness} {place}");
                }
            }
            assert!((reach.at(0.0) - reach.start).abs() < 1e-9);
            assert!((reach.at(1.0) - reach.start - reach.length).abs() < 1e-9);
        }
    }
}
