//! Conclusions from all points together besides the counts: how far they reach, how the model
//! compares with the measurement.

use super::{
    concerns::{out_of_reach, unmoved},
    failed,
    summary::Summary,
};
use conformity::{
    conclusion::grouped,
    validation::{Comparison, Numerical, Spread},
};
use point_journal::PointOutcome;
use study::{
    concern::{Code, Concern},
    judge::Judge,
    plan::Plan,
};

/// What no process can keep from another one.
const HELD: &str = "the FMU holds a port, a socket or a lock of this machine, where points that run at the same time meet each \
                    other, and other programs";
const ONE_JOB: &str = "Compare with `--jobs 1`, where one point runs at a time.";

/// So many points tell where those lie that fail.
const PLACED: usize = 4096;

/// Looks at points one by one, in constant memory.
pub struct Survey<'a> {
    judge: &'a Judge,
    plan: Option<&'a Plan>,
    points: u64,
    reached: Vec<[f64; 2]>,
    spreads: Vec<Spread>,
    /// Of the first points the parameters, whether it failed, and whether it went beyond what the model is valid for.
    first: Vec<(Vec<f64>, bool, bool)>,
}

impl<'a> Survey<'a> {
    /// No points yet. Without a plan the parameters are not known.
    pub fn new(judge: &'a Judge, plan: Option<&'a Plan>) -> Self {
        let criteria = judge.criteria.len();
        Self {
            judge,
            plan,
            points: 0,
            reached: vec![[f64::INFINITY, f64::NEG_INFINITY]; criteria],
            spreads: vec![Spread::default(); criteria],
            first: Vec::new(),
        }
    }

    /// Looks at a point, which may have gone `beyond` what the model is valid for.
    pub fn add(&mut self, parameters: &[f64], outcome: &PointOutcome, beyond: bool) {
        if self.first.len() < PLACED {
            self.first.push((parameters.to_vec(), outcome.is_err(), beyond));
        }
        let Ok(values) = outcome else { return };
        self.points += 1;
        for ((&value, [low, high]), spread) in values.iter().zip(&mut self.reached).zip(&mut self.spreads) {
            (*low, *high) = (low.min(value), high.max(value));
            spread.add(value);
        }
    }

    /// The part of the parameters' space where marked points lie, if that stands out.
    fn place(&self, is_marked: impl Fn(&(Vec<f64>, bool, bool)) -> bool) -> Option<String> {
        let rows: Vec<(&[f64], bool)> = self.first.iter().map(|point| (&*point.0, is_marked(point))).collect();
        let plan = self.plan?;
        failed::place(
            &plan
                .varied()
                .iter()
                .map(|&k| (k, &*plan.inputs[k].name, plan.inputs[k].unit.as_deref()))
                .collect::<Vec<_>>(),
            &rows,
        )
    }

    /// Warns of points beyond what the model is valid for.
    fn beyond_validity(&self, summary: &Summary) -> Option<Concern> {
        let validity = summary.asides.as_ref()?.validity.as_ref()?;
        let which = match summary.verified {
            0 => String::new(),
            all => format!(", {} of the {} that meet all criteria,", grouped(validity.verified), grouped(all)),
        };
        let told = validity.told(summary.points, &which)?;
        let place = self.place(|(_, _, beyond)| *beyond);
        let place = place.map(|place| format!(". They lie mostly where {place}")).unwrap_or_default();
        Some(
            Concern::new(Code::BeyondValidity, format!("{told}{place}"))
                .remedied("Cut the distributions to where the model is valid, or show that it holds beyond."),
        )
    }

    /// Adds to the summary what was seen.
    pub fn complete(&self, summary: &mut Summary) {
        let criteria = || self.judge.criteria.iter().enumerate();
        for warning in &self.judge.warnings {
            // Without the study's path, which may differ from run to run.
            let (_, text) = warning.text.split_once(": ").expect("its place comes first");
            summary.concerns.push(Concern { text: text.to_owned(), ..warning.clone() });
        }
        let reach = criteria().filter_map(|(k, c)| out_of_reach(c, self.reached[k], self.points));
        summary.concerns.extend(reach);
        for (count, reached) in summary.criteria.values_mut().zip(&self.reached) {
            count.reached = Some(*reached).filter(|[low, high]| low <= high);
        }
        let stated = self.judge.warnings.iter().cloned().chain(self.plan.iter().flat_map(|plan| plan.concerns()));
        let wide: Vec<Concern> = stated.filter(|concern| concern.code == Code::WideTolerance).collect();
        let is_told = |name: &str| wide.iter().any(|concern| concern.text.contains(&format!("{name}: ")));
        let unmoved = criteria().filter_map(|(k, c)| {
            unmoved(c, self.reached[k], self.points).filter(|doubt| doubt.code == Code::Unmoved || !is_told(&c.name))
        });
        summary.concerns.extend(unmoved);
        let failed = failed::concern(summary, || self.place(|(_, failed, _)| *failed));
        summary.concerns.extend(failed);
        summary.concerns.extend(self.beyond_validity(summary));
        let held = summary.asides.as_ref().and_then(|asides| asides.held.remark(HELD));
        summary.concerns.extend(held.map(|text| Concern::new(Code::Held, text).remedied(ONE_JOB)));
        for (k, criterion) in criteria() {
            // The comparison is about a measured number.
            let spread =
                self.spreads[k].result().filter(|_| criterion.metric.is_none() && criterion.measured().value.is_some());
            let Some(spread) = spread else { continue };
            match Comparison::new(&criterion.measured(), spread, Numerical::default()) {
                Some(comparison) => {
                    summary.validation.insert(criterion.name.clone(), comparison);
                }
                None => {
                    summary.concerns.push(Concern::new(Code::NotCompared, format!(
                        "{}: its values are too large to compute their spread, so model and measurement are not compared",
                        criterion.name
                    )));
                }
            }
        }
    }
}
