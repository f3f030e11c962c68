//! The trade-off between the criteria of a study: its front and the best compromise.

use super::front;
use crate::table::PointTable;
use sampling::statistics::moments::length;
use serde::{Deserialize, Serialize};

/// The trade-off between the criteria of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pareto {
    /// Points with values that the front was chosen from.
    pub points: usize,
    /// The parameters, in the order of all lists below.
    pub parameters: Vec<String>,
    /// Their units.
    pub units: Vec<String>,
    /// The criteria, in the order of all lists below.
    pub criteria: Vec<String>,
    /// How many points no other one beats in every criterion.
    pub unbeaten: usize,
    /// How many of these meet all criteria.
    pub unbeaten_verified: usize,
    /// The unbeaten points, those with the least largest deviation first; of very many, the first thousand, as
    /// many from all over the others, and the nearest.
    pub front: Vec<Member>,
    /// The point nearest to the measurement, by the root of the sum of squared deviations; its
    /// place in the front. The best compromise is the front's first point.
    pub nearest: usize,
}

/// A point of the front.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Member {
    /// The point's number in `points.csv`.
    pub point: u64,
    /// The parameters.
    pub parameters: Vec<f64>,
    /// The criteria's values.
    pub values: Vec<f64>,
    /// Their deviations in units of the tolerance: 0 agrees exactly, 1 is at the limit.
    pub deviations: Vec<f64>,
}

impl Member {
    fn of(table: &PointTable, point: usize) -> Self {
        Self {
            point: table.ids[point],
            parameters: table.parameters.iter().map(|p| p.values[point]).collect(),
            values: table.criteria.iter().map(|c| c.values[point]).collect(),
            deviations: table.deviations(point).collect(),
        }
    }

    /// The largest deviation: Chebyshev's distance from the measurement.
    pub fn largest(&self) -> f64 {
        self.deviations.iter().copied().fold(0.0, f64::max)
    }

    /// Euclid's distance from the measurement.
    pub fn distance(&self) -> f64 {
        length(self.deviations.iter().copied())
    }

    /// Whether all criteria are met.
    pub fn verified(&self) -> bool {
        self.deviations.iter().all(|d| *d <= 1.0)
    }
}

/// Largest number of front points that are listed. Nobody reads more, and a file of a million would be unwieldy.
const MOST: usize = 2_000;

/// The trade-off among the points of a study. `None` where no point has values.
///
/// The best compromise is the point with the least largest deviation (Zeleny 1973, "Compromise
/// programming", with the infinite norm): every criterion is met with as much room to spare as the
/// worst of them can have.
pub fn trade_off(table: &PointTable) -> Option<Pareto> {
    let completed: Vec<usize> = (0..table.len()).filter(|&i| table.completed(i)).collect();
    let objectives = completed.iter().map(|&i| table.deviations(i).collect());
    let unbeaten = front(&objectives.collect::<Vec<_>>()).into_iter();
    let mut chosen: Vec<Member> = unbeaten.map(|k| Member::of(table, completed[k])).collect();
    chosen.sort_by(|a, b| a.largest().total_cmp(&b.largest()));
    let by_distance = |a: &usize, b: &usize| chosen[*a].distance().total_cmp(&chosen[*b].distance());
    let nearest = (0..chosen.len()).min_by(by_distance)?;
    let unbeaten = chosen.len();
    let unbeaten_verified = chosen.iter().filter(|m| m.verified()).count();
    let nearest = shorten(&mut chosen, nearest);
    Some(Pareto {
        points: completed.len(),
        parameters: table.parameters.iter().map(|p| p.name.clone()).collect(),
        units: table.parameters.iter().map(|p| p.unit.clone()).collect(),
        criteria: table.criteria.iter().map(|c| c.name.clone()).collect(),
        nearest,
        unbeaten,
        unbeaten_verified,
        front: chosen,
    })
}

/// Keeps of a long front its first half of [`MOST`], a selection of the others all along it, and the nearest; returns
/// the latter's place.
fn shorten(front: &mut Vec<Member>, nearest: usize) -> usize {
    if front.len() <= MOST {
        return nearest;
    }
    let first = MOST / 2;
    let others = front.len() - first;
    let spread = (0..MOST - first).map(|k| first + k * others / (MOST - first));
    let mut kept: Vec<usize> = (0..first).chain(spread).collect();
    let place = kept.partition_point(|&i| i < nearest);
    if kept.get(place) != Some(&nearest) {
        kept.insert(place, nearest);
    }
    *front = kept.into_iter().map(|i| front[i].clone()).collect();
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{CriterionColumn, ParameterColumn};

    /// Two criteria that pull a single parameter to 0 and to 1, with tolerances of 1 and 0.5.
    fn table(x: &[f64]) -> PointTable {
        let criterion = |nominal: f64, room: f64| CriterionColumn {
            name: format!("c{nominal}"),
            unit: String::new(),
            nominal,
            lower: nominal - room,
            upper: nominal + room,
            group: None,
            values: x.to_vec(),
            ok: x.iter().map(|v| (v - nominal).abs() <= room).collect(),
        };
        PointTable {
            ids: (1..=x.len() as u64).collect(),
            parameters: vec![ParameterColumn { name: "x".into(), unit: "m".into(), values: x.to_vec() }],
            criteria: vec![criterion(0.0, 1.0), criterion(1.0, 0.5)],
            verified: vec![false; x.len()],
            status: vec!["ok".into(); x.len()],
        }
    }

    #[test]
    fn the_compromise_shares_the_room() {
        let x: Vec<f64> = (-20..=40).map(|k| f64::from(k) / 20.0).collect();
        let p = trade_off(&table(&x)).unwrap();
        // Everything between the two measured values is on the front, nothing else.
        assert_eq!(p.front.len(), 21);
        // x = 2 (1 - x): both deviations are 2/3; the nearest grid point is 0.65.
        assert!((p.front[0].parameters[0] - 0.65).abs() < 1e-9, "{:?}", p.front[0]);
        assert_eq!(p.front[0].point, 34);
        assert!((p.front[p.nearest].parameters[0] - 0.8).abs() < 1e-9);
        assert!(p.front[0].verified() && !p.front[20].verified());
    }

    #[test]
    fn a_large_front_is_counted_and_its_best_points_are_kept() {
        let x: Vec<f64> = (0..=30_000).map(|k| f64::from(k) / 30_000.0).collect();
        let p = trade_off(&table(&x)).unwrap();
        assert_eq!((p.unbeaten, p.front.len()), (30_001, MOST + usize::from(p.nearest >= MOST / 2)));
        // Verified from 0.5 on.
        assert_eq!(p.unbeaten_verified, 15_001);
        assert!((p.front[0].parameters[0] - 2.0 / 3.0).abs() < 1e-9);
        // x^2 + 4 (1 - x)^2 is least at 0.8, which is kept, too.
        assert!((p.front[p.nearest].parameters[0] - 0.8).abs() < 1e-9);
    }

    #[test]
    fn the_nearest_point_is_kept_wherever_it_is() {
        let member = |k: usize| Member { point: k as u64, parameters: vec![], values: vec![], deviations: vec![] };
        let mut front: Vec<Member> = (0..5 * MOST).map(member).collect();
        let place = shorten(&mut front, MOST + 7);
        assert_eq!((front.len(), front[place].point), (MOST + 1, MOST as u64 + 7));
        assert!(front.is_sorted_by_key(|m| m.point));
        assert!(front[MOST].point > 4 * MOST as u64);
    }

    #[test]
    fn failed_points_are_no_part_of_it() {
        let mut t = table(&[0.2, 0.5]);
        t.status[0] = "failed".into();
        t.criteria.iter_mut().for_each(|c| c.values[0] = f64::NAN);
        let p = trade_off(&t).unwrap();
        assert_eq!((p.points, p.front.len(), p.front[0].point), (1, 1, 2));
        t.status[1] = "failed".into();
        t.criteria.iter_mut().for_each(|c| c.values[1] = f64::NAN);
        assert_eq!(trade_off(&t), None);
    }
}
