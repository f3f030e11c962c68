//! Numbers without which a statistic is not complete.

use super::{CriterionText, window::seconds};
use fmu_import::{Description, Variable, quantity::Scale};
use fmu_points::names::behind;
use sampling::statistics::{Direction, Statistic};
use serde::{Deserialize, Serialize};

/// A number without which a statistic is not complete.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Detail {
    /// The percent of the time that a percentile leaves below.
    Percent(f64),
    /// The time of a value, s.
    At(f64),
    /// The level that a signal crosses, in the study's unit, and the way in which it does.
    Level(f64, Direction),
}

impl Detail {
    /// Words for the statistic.
    pub fn label(self) -> String {
        match self {
            Self::Percent(percent) => format!("{percent} % percentile"),
            Self::At(time) => format!("value at {time} s"),
            Self::Level(..) => Statistic::Crossing.label().to_owned(),
        }
    }
}

impl CriterionText {
    /// The scale of its numbers, tied to the FMU's variable where there is an FMU: a time and a frequency have units of their own.
    ///
    /// # Errors
    /// When its unit does not fit.
    pub fn scale<'a>(&self, of: Option<(&'a Description, &'a Variable)>) -> Result<Scale<'a>, String> {
        let unit = self.unit.as_deref();
        match (self.statistic.and_then(Statistic::unit), of) {
            (Some(si_unit), _) => Scale::in_si(unit, si_unit),
            (None, Some((fmu, variable))) => Scale::new(unit, fmu, variable),
            (None, None) => Ok(Scale::alone(unit)),
        }
    }

    /// The number that its statistic needs, where it needs one.
    ///
    /// # Errors
    /// When it is missing, means nothing, or belongs to no statistic of this criterion.
    pub fn detail(&self) -> Result<Option<Detail>, String> {
        let is = |statistic| self.statistic == Some(statistic);
        let is_mean = is(Statistic::Mean) && self.reference.is_none();
        let [is_crossing, is_percentile] = [Statistic::Crossing, Statistic::Percentile].map(is);
        let [level, percent, at] = [self.level.is_some(), self.percent.is_some(), self.at.is_some()];
        first_wrong(&[
            (self.turns.is_some() && !is_mean, "`turns` belongs to statistic = \"mean\"; add that, or remove `turns`"),
            (
                (level || self.direction.is_some()) && !is_crossing,
                "`level` and `direction` belong to statistic = \"crossing\"; add that, or remove them",
            ),
            (is_crossing && !level, "a crossing needs `level`, such as level = \"50 N\""),
            (level && (percent || at), "`percent` and `at` have no place beside `level`; remove them"),
            (
                at && (self.statistic.is_some() || self.window.is_some()),
                "`at` asks for the value at one time; remove `statistic` and `window` beside it",
            ),
            (
                percent && !is_percentile,
                "`percent` belongs to statistic = \"percentile\"; add that, or remove `percent`",
            ),
            (is_percentile && !percent, "a percentile needs `percent`, from 0 to 100, such as percent = 95"),
            (at && self.reference.is_some(), "`at` has no place beside `reference`; `window` says which rows count"),
        ])?;
        if let Some(level) = &self.level {
            let level = level.as_ref().number;
            let direction = self.direction.as_ref().map(|direction| *direction.as_ref());
            return if level.is_finite() {
                Ok(Some(Detail::Level(level, direction.unwrap_or_default())))
            } else {
                Err(format!("level = {level} is no level that a signal can cross; give a finite number"))
            };
        }
        if let Some(percent) = self.percent.as_ref().map(|percent| *percent.as_ref()) {
            return if (0.0..=100.0).contains(&percent) {
                Ok(Some(Detail::Percent(percent)))
            } else {
                Err(format!("percent = {percent} must lie between 0 and 100"))
            };
        }
        let Some(time) = &self.at else { return Ok(None) };
        let time = seconds(time.as_ref())?;
        if time.is_finite() { Ok(Some(Detail::At(time))) } else { Err(format!("at = {time} is not a time")) }
    }

    /// The level of an event and its direction as people read them; its unit is the variable's where it has none of its own.
    pub fn event(&self, unit: Option<&str>) -> Option<String> {
        let level = self.level.as_ref()?.as_ref();
        let way = match self.direction.as_ref().map(|direction| *direction.as_ref()) {
            None | Some(Direction::Either) => "at",
            Some(Direction::Rising) => "rising to",
            Some(Direction::Falling) => "falling to",
        };
        let unit = behind(level.unit.as_deref().or(unit));
        Some(format!("{way} {}{unit}", level.number))
    }
}

/// Refuses a criterion of which something is true that must not be, with the remedy of the first such thing.
///
/// # Errors
/// The remedy.
pub fn first_wrong(wrong: &[(bool, &str)]) -> Result<(), String> {
    wrong.iter().find(|(is_so, _)| *is_so).map_or(Ok(()), |(_, remedy)| Err((*remedy).to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detail(keys: &str) -> Result<Option<Detail>, String> {
        let text = format!("variable = \"v\"\n{keys}");
        toml::from_str::<CriterionText>(&text).unwrap().detail()
    }

    #[test]
    fn details_are_read() {
        assert_eq!(detail(""), Ok(None));
        let percentile = detail("statistic = \"percentile\"\npercent = 95");
        assert_eq!(percentile, Ok(Some(Detail::Percent(95.0))));
        assert_eq!(detail("at = \"12 s\""), Ok(Some(Detail::At(12.0))));
        assert_eq!(detail("at = \"20 ms\""), Ok(Some(Detail::At(0.02))));
        let crossing = detail("statistic = \"crossing\"\nlevel = \"50 N\"\ndirection = \"falling\"");
        assert_eq!(crossing, Ok(Some(Detail::Level(50.0, Direction::Falling))));
    }

    #[test]
    fn a_level_is_shown_with_its_unit() {
        let event = |keys: &str, unit| {
            let text = format!("variable = \"v\"\nstatistic = \"crossing\"\n{keys}");
            toml::from_str::<CriterionText>(&text).unwrap().event(unit)
        };
        let shown = |text: &str| Some(text.to_owned());
        assert_eq!(event("level = 50", Some("N")), shown("at 50 N"));
        let keys = "level = \"0.05 kN\"\ndirection = \"rising\"";
        assert_eq!(event(keys, Some("N")), shown("rising to 0.05 kN"));
        assert_eq!(event("level = 50\ndirection = \"falling\"", None), shown("falling to 50"));
        assert_eq!(event("", Some("N")), None);
    }

    #[test]
    fn what_is_missing_or_too_much_is_refused() {
        for (keys, message) in [
            ("statistic = \"percentile\"", "needs `percent`"),
            ("percent = 5", "add that, or remove"),
            ("statistic = \"mean\"\npercent = 5", "add that, or remove"),
            ("statistic = \"percentile\"\npercent = 101", "between 0 and 100"),
            ("statistic = \"mean\"\nat = 1", "remove `statistic`"),
            ("statistic = \"crossing\"", "needs `level`"),
            ("statistic = \"crossing\"\nlevel = nan", "give a finite number"),
            ("level = 5", "belong to statistic"),
            ("turns = \"drive.angle\"", "belongs to statistic = \"mean\""),
            ("statistic = \"max\"\ndirection = \"rising\"", "belong to statistic"),
            ("statistic = \"crossing\"\nlevel = 5\nat = 1", "no place beside `level`"),
            ("window = 3\nat = 1", "remove `statistic`"),
            ("percent = 5\nat = 1", "add that, or remove"),
            ("at = \"1 N\"", "no unit of time"),
            ("reference = { file = \"a.csv\" }\nat = 1", "beside `reference`"),
        ] {
            let error = detail(keys).unwrap_err();
            assert!(error.contains(message), "{keys}: {error}");
        }
    }
}
