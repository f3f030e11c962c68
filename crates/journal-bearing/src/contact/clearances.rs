//! The contact of a journal whose clearance changes: tables at several clearances, and polynomials between them.

use super::{Contact, ContactTable, LOGARITHMS, NO_CONTACT, NODES, Node, QUANTITIES, Surface, TablePlace, Touch};
use crate::{roughness::Reach, spline::below};
use std::{
    cell::OnceCell,
    collections::BTreeMap,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

/// The contact of an aligned, round journal over its eccentricity ratio and its radial clearance.
///
/// Tables stand at clearances of equal ratios, and are made where they are first needed. Between them, the knots of a
/// contact follow cubic polynomials over the logarithm of the clearance. The tables' places are fixed, so that a contact does not
/// depend on which ones were made before. One of them lies at seven roughnesses, where contact begins to reach around the whole
/// bush; no polynomial crosses it. Tables of one roughness are the same for all bearings, so a process makes them once.
///
/// # Examples
/// ```
/// use journal_bearing::contact::{ContactFamily, ContactTable, Surface};
///
/// let surface = Surface { roughness: 5e-6, ..Surface::default() };
/// // Clearance, width and diameter in m.
/// let family = ContactFamily::new(&surface, 20e-6, 0.019, 0.025);
/// let table = ContactTable::new(&surface, 23e-6, 0.019, 0.025);
/// let (found, expected) = (family.at(0.8, 23e-6), table.at(0.8));
/// assert!((found.force / expected.force - 1.0).abs() < 1e-5);
/// ```
#[derive(Debug, Default)]
pub struct ContactFamily {
    roughness: f64,
    /// Logarithm of the force over the integrals in `tables`, N.
    scale: f64,
    /// The clearance that was given, m, and its own table.
    clearance: f64,
    table: ContactTable,
    /// The number of the first of `tables`, counted from the one at seven roughnesses.
    first: i32,
    tables: Vec<OnceLock<Arc<ContactTable>>>,
}

/// The tables of the roughness that was met last, m, by their numbers. The points of a study seldom differ in it.
static KNOWN: Mutex<(f64, BTreeMap<i32, Arc<ContactTable>>)> = Mutex::new((0.0, BTreeMap::new()));

/// The table of a roughness, m, with a number.
fn shared(roughness: f64, number: i32) -> Arc<ContactTable> {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if known.0 != roughness {
        *known = (roughness, BTreeMap::new());
    }
    let table = known.1.entry(number).or_insert_with(|| {
        let clearance = NO_CONTACT * roughness * (f64::from(number) * SPACING).exp();
        Arc::new(ContactTable::of_integrals(roughness, clearance))
    });
    Arc::clone(table)
}

/// Ratio of neighbouring clearances, as a logarithm.
const SPACING: f64 = 0.04;
/// The clearances that have tables, over the one that was given. Beyond them the nearest counts.
const LEAST: f64 = 0.01;
const MOST: f64 = 100.0;
/// Tables that a polynomial passes through.
const THROUGH: usize = 4;

impl ContactFamily {
    /// The contact of a bearing with radial clearance, width and diameter in m, and of others like it with clearances from
    /// a hundredth to the hundredfold of this one.
    pub fn new(surface: &Surface, clearance: f64, width: f64, diameter: f64) -> Self {
        let table = ContactTable::new(surface, clearance, width, diameter);
        let middle = (clearance / (NO_CONTACT * surface.roughness)).ln() / SPACING;
        let touches = !table.nodes.is_empty();
        let bound = |ratio: f64| (middle + ratio.ln() / SPACING).floor();
        // Each end has room for the tables of a polynomial, also near seven roughnesses, where all lie on one side.
        let (first, last) = if touches { (bound(LEAST) - 4.0, bound(MOST) + 5.0) } else { (0.0, 0.0) };
        let count = (last - first) as usize;
        Self {
            roughness: surface.roughness,
            scale: surface.log_force_scale(width, diameter),
            clearance,
            table,
            first: first as i32,
            tables: (0..count).map(|_| OnceLock::new()).collect(),
        }
    }

    /// The contact at an eccentricity ratio and a clearance, m.
    pub fn at(&self, eccentricity_ratio: f64, clearance: f64) -> Contact {
        let touch = self.touch(eccentricity_ratio, clearance);
        touch.map_or_else(Contact::default, |touch| touch.contact)
    }

    /// Contact and film at an eccentricity ratio and a clearance, m; `None` where the asperities do not touch.
    #[inline]
    pub fn touch(&self, eccentricity_ratio: f64, clearance: f64) -> Option<Touch> {
        if clearance == self.clearance || self.tables.is_empty() {
            return self.table.touch(eccentricity_ratio);
        }
        self.between(eccentricity_ratio, clearance)
    }

    /// The same between tables.
    fn between(&self, eccentricity_ratio: f64, clearance: f64) -> Option<Touch> {
        let (clearance, start, per_spacing) = self.within(clearance);
        let position = (eccentricity_ratio - start) * per_spacing;
        if position < 0.0 {
            return None;
        }
        let place = TablePlace::new(position);
        let mut quantities = [0.0; QUANTITIES];
        for (table, weight) in self.about(clearance) {
            place.add(table.ends(place.cell), weight, &mut quantities);
        }
        for log in &mut quantities[..LOGARITHMS] {
            *log += self.scale;
        }
        Some(place.touch(&quantities, eccentricity_ratio, start))
    }

    /// The contact at one clearance, m, for many eccentricity ratios: its knots are computed once.
    pub fn with_clearance(&self, clearance: f64) -> ContactAt<'_> {
        if clearance == self.clearance || self.tables.is_empty() {
            return ContactAt(Tables::Own(&self.table));
        }
        let (clearance, start, per_spacing) = self.within(clearance);
        ContactAt(Tables::Between {
            start,
            per_spacing,
            scale: self.scale,
            tables: self.about(clearance),
            nodes: vec![OnceCell::new(); NODES],
        })
    }

    /// A clearance within those that have tables, m; the eccentricity ratio where contact begins, and the knots per eccentricity
    /// ratio there.
    #[inline]
    fn within(&self, clearance: f64) -> (f64, f64, f64) {
        let clearance = clearance.clamp(LEAST * self.clearance, MOST * self.clearance);
        let [start, length] = Reach::along(self.roughness / clearance);
        (clearance, start, (NODES - 1) as f64 / length)
    }

    /// The tables about a clearance, m, with their weights.
    #[inline(always)]
    fn about(&self, clearance: f64) -> [(&ContactTable, f64); THROUGH] {
        let x = (clearance / (NO_CONTACT * self.roughness)).ln() / SPACING;
        let below = below(x);
        let lowest = if below >= 0 { (below - 1).max(0) } else { (below - 1).min(1 - THROUGH as i32) };
        let weights = weights(x - f64::from(lowest));
        let index = usize::try_from(lowest - self.first).unwrap_or(0).min(self.tables.len() - THROUGH);
        let tables = &self.tables[index..index + THROUGH];
        std::array::from_fn(|k| {
            let number = self.first + (index + k) as i32;
            let table = tables[k].get_or_init(|| shared(self.roughness, number));
            (&**table, weights[k])
        })
    }
}

/// The contact at one clearance, from [`ContactFamily::with_clearance`].
#[derive(Clone, Debug)]
pub struct ContactAt<'a>(Tables<'a>);

#[derive(Clone, Debug)]
enum Tables<'a> {
    Own(&'a ContactTable),
    Between {
        /// The eccentricity ratio where contact begins, and the knots per eccentricity ratio.
        start: f64,
        per_spacing: f64,
        /// Logarithm of the force over the integrals in the tables, N.
        scale: f64,
        /// With their weights.
        tables: [(&'a ContactTable, f64); THROUGH],
        nodes: Vec<OnceCell<Node>>,
    },
}

impl ContactAt<'_> {
    /// Contact and film at an eccentricity ratio; `None` where the asperities do not touch.
    #[inline]
    pub fn touch(&self, eccentricity_ratio: f64) -> Option<Touch> {
        let (start, per_spacing, nodes) = match &self.0 {
            Tables::Own(table) => return table.touch(eccentricity_ratio),
            Tables::Between { start, per_spacing, nodes, .. } => (*start, per_spacing, nodes),
        };
        let position = (eccentricity_ratio - start) * per_spacing;
        if position < 0.0 {
            return None;
        }
        let place = TablePlace::new(position);
        let nodes = &nodes[place.cell..=place.cell + 1];
        let ends = [0, 1].map(|k| nodes[k].get_or_init(|| self.node(place.cell + k)));
        let mut quantities = [0.0; QUANTITIES];
        place.add(ends, 1.0, &mut quantities);
        Some(place.touch(&quantities, eccentricity_ratio, start))
    }

    /// A knot between tables.
    #[inline(never)]
    fn node(&self, i: usize) -> Node {
        let Tables::Between { scale, tables, .. } = &self.0 else { return Node::default() };
        let mut sum = Node::default();
        for (table, weight) in tables {
            let node = table.nodes[i].get_or_init(|| table.node(i));
            for (sum, value) in sum.iter_mut().flatten().zip(node.iter().flatten()) {
                *sum += weight * value;
            }
        }
        for log in &mut sum[0][..LOGARITHMS] {
            *log += scale;
        }
        sum
    }
}

/// Lagrange's weights of the nodes at 0, 1, 2 and 3 at the place `x`.
#[inline]
fn weights(x: f64) -> [f64; THROUGH] {
    let [a, b, c, d] = [x, x - 1.0, x - 2.0, x - 3.0];
    [-b * (c / -2.0) * (d / -3.0), a * -c * (d / -2.0), a / 2.0 * b * -d, a / 3.0 * (b / 2.0) * c]
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: f64 = 0.019;
    const DIAMETER: f64 = 0.025;
    /// A force, N, that matters to no bearing: where contact begins, a table fades in from a billionth of a newton.
    const NOTHING: f64 = 1e-9;

    /// Against a table of that clearance, from a tenth to ten times the one given: contact all around and in a patch, next to
    /// seven roughnesses, and on both sides of it.
    #[test]
    fn other_clearances_have_the_contact_of_their_own_tables() {
        let surface = Surface { roughness: 4.94e-6, ..Surface::default() };
        let family = ContactFamily::new(&surface, 20e-6, WIDTH, DIAMETER);
        let seven = 7.0 * surface.roughness;
        for c in [2e-6, 8e-6, 19.3e-6, 20.1e-6, 25e-6, 0.9999 * seven, 1.0001 * seven, 37e-6, 60e-6, 200e-6] {
            let table = ContactTable::new(&surface, c, WIDTH, DIAMETER);
            for e in [0.0, 1e-3, 0.1, 0.3, 0.6, 0.8, 0.9, 0.97, 0.999] {
                let (contact, expected) = (family.at(e, c), table.at(e));
                let again = family.with_clearance(c).touch(e).map_or(0.0, |touch| touch.contact.force);
                assert!((again - contact.force).abs() <= 1e-13 * contact.force, "c = {c}, e = {e}");
                for (value, expected) in [(contact.force, expected.force), (contact.normal, expected.normal)] {
                    assert!(
                        (value - expected).abs() <= 1e-5 * expected + NOTHING,
                        "c = {c}, e = {e}: {value} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_given_clearance_has_its_own_table() {
        let surface = Surface::default();
        let family = ContactFamily::new(&surface, 20e-6, WIDTH, DIAMETER);
        let table = ContactTable::new(&surface, 20e-6, WIDTH, DIAMETER);
        assert_eq!(family.at(0.87, 20e-6), table.at(0.87));
    }

    /// The order in which clearances were visited does not matter.
    #[test]
    fn a_contact_does_not_depend_on_earlier_ones() {
        let surface = Surface::default();
        let fresh = || ContactFamily::new(&surface, 20e-6, WIDTH, DIAMETER);
        let used = fresh();
        for c in [30e-6, 10e-6, 22e-6, 1e-9, 1.0] {
            assert!(used.at(0.9, c).force.is_finite(), "{c}");
        }
        assert_eq!(used.at(0.9, 21e-6), fresh().at(0.9, 21e-6));
    }

    #[test]
    fn smooth_surfaces_do_not_touch_at_any_clearance() {
        let smooth = Surface { roughness: 0.0, ..Surface::default() };
        let family = ContactFamily::new(&smooth, 20e-6, WIDTH, DIAMETER);
        assert_eq!(family.at(0.999, 1e-6), Contact::default());
    }
}
