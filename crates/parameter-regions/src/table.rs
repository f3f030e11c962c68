//! The table of points: what was sampled, what came out, what was accepted.

use std::borrow::Cow;

use indexmap::IndexSet;
use sampling::statistics::moments::length;

/// A sampled parameter with its value at every point.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterColumn {
    /// The variable's name.
    pub name: String,
    /// The unit of `values`; empty when dimensionless.
    pub unit: String,
    /// One value per point.
    pub values: Vec<f64>,
}

/// A criterion with its value at every point and its accepted interval.
#[derive(Clone, Debug, PartialEq)]
pub struct CriterionColumn {
    /// The criterion's name.
    pub name: String,
    /// The unit of `values` and of the three numbers below; empty when dimensionless.
    pub unit: String,
    /// The measured value.
    pub nominal: f64,
    /// The least acceptable value, inclusive; may be minus infinity.
    pub lower: f64,
    /// The greatest acceptable value, inclusive; may be infinity.
    pub upper: f64,
    /// The group of criteria that it is counted with.
    pub group: Option<String>,
    /// One value per point; not a number where there is none. A point may have failed and yet have values of some criteria.
    pub values: Vec<f64>,
    /// Whether the point meets the criterion.
    pub ok: Vec<bool>,
}

impl CriterionColumn {
    /// How far a value is from nominal, in units of the tolerance on that side: 0 at nominal,
    /// 1 at the limit, above 1 outside. Towards an infinite limit the deviation is 0.
    /// Not a number for a value that is not a number.
    pub fn deviation(&self, value: f64) -> f64 {
        let (miss, room) = if value >= self.nominal {
            (value - self.nominal, self.upper - self.nominal)
        } else {
            (self.nominal - value, self.nominal - self.lower)
        };
        if miss == 0.0 {
            0.0
        } else if room > 0.0 {
            miss / room
        } else if miss.is_nan() {
            f64::NAN
        } else {
            f64::INFINITY
        }
    }
}

/// Points with their parameters, criteria and verdicts. All columns have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointTable {
    /// The points' numbers, as in `points.csv`.
    pub ids: Vec<u64>,
    /// The sampled parameters.
    pub parameters: Vec<ParameterColumn>,
    /// The criteria.
    pub criteria: Vec<CriterionColumn>,
    /// Whether the point meets all criteria.
    pub verified: Vec<bool>,
    /// `ok`, or why the point has no values.
    pub status: Vec<Cow<'static, str>>,
}

/// The largest deviation over the criteria of one point, and which criterion it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Binding {
    /// Index of the criterion that binds.
    pub criterion: usize,
    /// Deviation from the measured value, in units of the tolerance.
    pub deviation: f64,
}

impl PointTable {
    /// The number of points, failed ones included.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The places of a group's criteria, or of those without one.
    pub fn members(&self, group: Option<&str>) -> Vec<usize> {
        (0..self.criteria.len()).filter(|&k| self.criteria[k].group.as_deref() == group).collect()
    }

    /// Some of the points, in the order asked for.
    pub fn subset(&self, points: &[usize]) -> Self {
        let numbers = |values: &[f64]| points.iter().map(|&i| values[i]).collect();
        let flags = |values: &[bool]| points.iter().map(|&i| values[i]).collect();
        let parameter = |p: &ParameterColumn| ParameterColumn { values: numbers(&p.values), ..p.clone() };
        let criterion =
            |c: &CriterionColumn| CriterionColumn { values: numbers(&c.values), ok: flags(&c.ok), ..c.clone() };
        Self {
            ids: points.iter().map(|&i| self.ids[i]).collect(),
            parameters: self.parameters.iter().map(parameter).collect(),
            criteria: self.criteria.iter().map(criterion).collect(),
            verified: flags(&self.verified),
            status: points.iter().map(|&i| self.status[i].clone()).collect(),
        }
    }

    /// Adds the points of another table with the same parameters and criteria.
    pub fn extend(&mut self, other: &Self) {
        self.ids.extend(&other.ids);
        for (column, more) in self.parameters.iter_mut().zip(&other.parameters) {
            column.values.extend(&more.values);
        }
        for (criterion, more) in self.criteria.iter_mut().zip(&other.criteria) {
            criterion.values.extend(&more.values);
            criterion.ok.extend(&more.ok);
        }
        self.verified.extend(&other.verified);
        self.status.extend(other.status.iter().cloned());
    }

    /// Whether the point was simulated to its end.
    pub fn completed(&self, point: usize) -> bool {
        self.status[point] == "ok"
    }

    /// Names of the groups, in the order in which the criteria first name them.
    pub fn groups(&self) -> Vec<&str> {
        let groups = self.criteria.iter().filter_map(|c| c.group.as_deref());
        groups.collect::<IndexSet<_>>().into_iter().collect()
    }

    /// The [deviations](CriterionColumn::deviation) of a point's values from the measured ones, a criterion each.
    pub fn deviations(&self, point: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        let criteria = self.criteria.iter();
        criteria.map(move |c| c.deviation(c.values[point]))
    }

    /// The criterion with the largest deviation at a point; `None` where any of them has no value.
    pub fn binding(&self, point: usize) -> Option<Binding> {
        let mut worst: Option<Binding> = None;
        for (criterion, deviation) in self.deviations(point).enumerate() {
            if deviation.is_nan() {
                return None;
            }
            if worst.is_none_or(|w| deviation > w.deviation) {
                worst = Some(Binding { criterion, deviation });
            }
        }
        worst
    }

    /// How far a point is from the measurement: the root of the sum of its squared deviations.
    pub fn distance(&self, point: usize) -> f64 {
        length(self.deviations(point))
    }

    /// Points with values: the verified first, of these the one nearest to the measurement first.
    pub fn ranking(&self) -> Vec<Ranked> {
        self.best(self.len())
    }

    /// The first so many of the [ranking](Self::ranking).
    pub fn best(&self, most: usize) -> Vec<Ranked> {
        let ranked = |point| Some(Ranked { point, distance: self.distance(point), binding: self.binding(point)? });
        let key = |r: &Ranked| (!self.verified[r.point], r.distance, r.point);
        let order = |a: &Ranked, b: &Ranked| {
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2))
        };
        let completed = (0..self.len()).filter(|&i| self.completed(i));
        let mut ranking: Vec<Ranked> = completed.filter_map(ranked).collect();
        if most < ranking.len() {
            ranking.select_nth_unstable_by(most, order);
            ranking.truncate(most);
        }
        ranking.sort_unstable_by(order);
        ranking
    }
}

/// A point's place among the others.
pub struct Ranked {
    /// Index of the point.
    pub point: usize,
    /// The point's [distance](PointTable::distance) from the measurement.
    pub distance: f64,
    /// The criterion that binds.
    pub binding: Binding,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn criterion(nominal: f64, lower: f64, upper: f64) -> CriterionColumn {
        CriterionColumn {
            name: "c".into(),
            unit: String::new(),
            nominal,
            lower,
            upper,
            group: None,
            values: vec![],
            ok: vec![],
        }
    }

    #[test]
    fn deviation_is_one_at_either_limit() {
        let c = criterion(10.0, 8.0, 11.0);
        assert_eq!(c.deviation(10.0), 0.0);
        assert_eq!(c.deviation(8.0), 1.0);
        assert_eq!(c.deviation(11.0), 1.0);
        assert_eq!(c.deviation(13.0), 3.0);
        assert!(c.deviation(f64::NAN).is_nan());
    }

    #[test]
    fn one_sided_and_zero_tolerances() {
        let c = criterion(10.0, f64::NEG_INFINITY, 10.0);
        assert_eq!(c.deviation(-1e9), 0.0);
        assert_eq!(c.deviation(10.0), 0.0);
        assert_eq!(c.deviation(10.1), f64::INFINITY);
    }

    #[test]
    fn a_point_without_a_value_binds_nothing() {
        let mut a = criterion(0.0, -1.0, 1.0);
        a.values = vec![0.5, f64::NAN, 3.0];
        let mut b = criterion(0.0, -1.0, 1.0);
        b.values = vec![-0.75, 0.0, 0.0];
        let table = PointTable {
            ids: vec![1, 2, 3],
            criteria: vec![a, b],
            verified: vec![true, false, false],
            status: vec!["ok".into(), "solver failed".into(), "ok".into()],
            ..PointTable::default()
        };
        assert_eq!(table.binding(0), Some(Binding { criterion: 1, deviation: 0.75 }));
        assert_eq!(table.binding(1), None);
        assert_eq!(table.ranking().iter().map(|r| r.point).collect::<Vec<_>>(), [0, 2]);
    }
}
