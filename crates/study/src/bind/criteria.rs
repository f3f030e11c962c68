//! What the criteria of a study observe in a simulation.

use std::sync::Arc;

use fmu_import::{Content, Handle, Variable, quantity::Scale, units::Conversion};
use fmu_points::task::{Measure, MeasuredCurve, Probe, Product, Schedule};
use sampling::statistics::Statistic;
use toml::Spanned;

use super::Binder;
use crate::{CriterionText, Detail, Name, Result, cases::SEPARATOR, measured::Binder as CurveBinder, values::find};

impl Binder<'_> {
    /// How each criterion's variable becomes a number, and how that goes from the FMU's unit to the study's.
    pub(super) fn criteria(&self, schedule: &Schedule) -> Result<(Vec<Conversion>, Vec<Probe>)> {
        self.study
            .criteria
            .iter()
            .map(|(name, criterion)| {
                let variable = self.variable(&criterion.variable)?;
                let at = |message| self.study.error_at(&criterion.variable, message);
                let probe = Probe::of(variable, criterion.statistic.unwrap_or_default())
                    .ok_or_else(|| at("a text cannot be compared with a measurement".to_owned()))?;
                let scale = criterion.scale(Some((self.fmu, variable))).map_err(at)?;
                let curve = self.curve(name, criterion, &scale, &probe.handle, schedule)?;
                let number = self.measure(name, criterion, variable, schedule)?;
                let probe = Probe {
                    measure: curve.map_or(number, Measure::Curve),
                    product: self.product(criterion, variable),
                    ..probe
                };
                Ok((scale.conversion.inverse(), probe))
            })
            .collect()
    }

    /// What a derived criterion is the product of, where one factor is a recorded input.
    fn product(&self, text: &CriterionText, variable: &Variable) -> Option<Product> {
        let derived = text.derived.as_ref()?;
        let [from, by] = [&derived.from, &derived.by].map(|key| key.as_ref().as_str());
        self.study.inputs.get(by)?;
        // Other statistics of a product do not follow from those of its factors.
        let is_linear = matches!(text.statistic.unwrap_or_default(), Statistic::Mean | Statistic::Final);
        if !is_linear || text.percent.is_some() || text.level.is_some() {
            return None;
        }
        let is_factor =
            |name: &str| name == from || text.case.is_some() && name.ends_with(&format!("{SEPARATOR}{from}"));
        let mut criteria = self.study.criteria.iter();
        let (_, factor) = criteria.find(|(name, _)| is_factor(name.as_ref()))?;
        let of = find(self.fmu, factor.variable.as_ref()).ok()?;
        let by = find(self.fmu, by).ok()?;
        let to_base = |variable: &Variable| match variable.unit() {
            None => Some(1.0),
            Some(unit) => self.fmu.units.0.get(unit)?.base.map(|base| base.to_base.factor),
        };
        // Without the units' definitions they count as coherent.
        let factor = to_base(of).zip(to_base(by)).zip(to_base(variable)).map_or(1.0, |((of, by), own)| of * by / own);
        Some(Product { of: of.number_handle()?, by: by.number_handle()?, factor })
    }

    /// What turns a criterion's signal into one number, but for a measured curve.
    fn measure(&self, name: &Name, text: &CriterionText, variable: &Variable, schedule: &Schedule) -> Result<Measure> {
        let named = |message| self.study.error_of(name, message);
        let detail = text.detail().map_err(named)?;
        let needs_lines =
            detail.is_some() || text.turns.is_some() || text.statistic.is_some_and(Statistic::needs_lines);
        if needs_lines && variable.handle().content != Content::Real {
            return Err(named(
                "this statistic follows straight lines, and the variable is not real; take final, mean, min or max"
                    .to_owned(),
            ));
        }
        if let Some(angle) = &text.turns {
            return self.turns(angle, variable);
        }
        match detail {
            Some(Detail::Level(number, direction)) => {
                let unit = text.level.as_ref().and_then(|level| level.as_ref().unit.as_deref());
                let level = Scale::new(unit, self.fmu, variable).map_err(named)?.conversion.value(number);
                Ok(Measure::Crossing { level, direction })
            }
            Some(Detail::At(time)) if !(schedule.start..=schedule.stop).contains(&time) => Err(named(format!(
                "at = {time} s is not within the run from {} s to {} s; correct it, or start and stop under [simulation]",
                schedule.start, schedule.stop
            ))),
            Some(Detail::At(time)) => Ok(Measure::At(time)),
            Some(Detail::Percent(percent)) => Ok(Measure::Percentile(percent)),
            None => Ok(Measure::Statistic(text.statistic.unwrap_or_default())),
        }
    }

    /// The angle over whose whole turns the mean of a variable is taken.
    fn turns(&self, name: &Spanned<String>, of: &Variable) -> Result<Measure> {
        let at = |message| self.study.error_at(name, message);
        let angle = self.variable(name)?;
        let handle = angle.number_handle();
        let handle = handle
            .filter(|handle| handle.content == Content::Real && angle.name != of.name)
            .ok_or_else(|| at("turns must name another real variable, an angle".to_owned()))?;
        let turn = Scale::new(Some("rad"), self.fmu, angle)
            .map_err(|message| at(format!("turns must name an angle: {message}")))?
            .conversion
            .difference(std::f64::consts::TAU);
        Ok(Measure::MeanOverTurns { angle: handle, turn: turn.abs() })
    }

    /// The measured curve of a criterion, where it has one.
    fn curve(
        &self,
        name: &Name,
        text: &CriterionText,
        scale: &Scale,
        handle: &Handle,
        schedule: &Schedule,
    ) -> Result<Option<Arc<MeasuredCurve>>> {
        let (Some(reference), Some(metric)) = (&text.reference, text.metric) else { return Ok(None) };
        if handle.content != Content::Real {
            return Err(self.study.error_at(&text.variable, "only real variables can be compared with a curve"));
        }
        let run = [schedule.start, schedule.stop];
        let general = [schedule.window_start, schedule.stop];
        let stated = self.stated_window(text, run)?;
        let binder = CurveBinder {
            study: self.study,
            name,
            text,
            reference,
            metric,
            scale,
            run,
            window: stated.or((general != run).then_some(general)),
        };
        binder.bind().map(|curve| Some(Arc::new(curve)))
    }
}
