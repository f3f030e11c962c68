//! Reads measured curves and ties them to an FMU.

use crate::{
    Result,
    concern::{ACCEPTS_ZERO, Code, Concern},
};
use std::fmt::Display;

use super::{
    CriterionText, Name, Study, first_wrong,
    limit::{gain, limit},
    reference::{Normalise, OwnNormaliser, ReferenceText},
    window::seconds,
};
use conformity::uncertainty::{Distribution, Uncertainty};
use curves::{Curve, Metric, Pair, iso18571};
use fmu_import::{
    digest,
    quantity::{Quantity, Scale, Sense},
    units::Conversion,
};
use fmu_points::task::{CurveErrors, MeasuredCurve, Resampling};
use number_tables::{Table, files::FileError};
use toml::Spanned;

/// The most samples of a curve whose rating is bootstrapped: the time grows with their square; 256 resamplings of 1,000 take a third
/// of a second.
const MOST_DRAWN: f64 = 1000.0;

/// The rows of a recording that count.
struct RecordedRows {
    curve: Curve,
    /// The expanded uncertainty of each.
    expanded: Option<Vec<f64>>,
    /// The number of the first of them in the file.
    first: u64,
}

/// A criterion on a curve that is tied to an FMU.
pub struct Binder<'a> {
    pub study: &'a Study,
    pub name: &'a Name,
    pub text: &'a CriterionText,
    pub reference: &'a ReferenceText,
    pub metric: Metric,
    pub scale: &'a Scale<'a>,
    /// The whole run, s.
    pub run: [f64; 2],
    /// The times that count, s, where the study states them: rows outside are ignored then.
    pub window: Option<[f64; 2]>,
}

impl Binder<'_> {
    /// Reads the measured curve.
    pub fn bind(&self) -> Result<MeasuredCurve> {
        let named = |message| self.study.error_of(self.name, message);
        let RecordedRows { curve, expanded, first } = self.read()?;
        let delay = self.text.delay.as_ref().map_or(Ok(0.0), seconds).map_err(named)?;
        let band = self.band(&curve, expanded.as_deref()).map_err(named)?;
        let errors = self.errors(&curve, expanded.as_deref())?;
        // The noise is in the recording, and so in the metric: drawn again it would count twice.
        let drawn = errors.as_ref().map(|(drawn, _)| drawn);
        let (even, drawn) = self.even(&curve, drawn)?;
        let resampling = errors.is_some().then(|| self.resampling(drawn, first));
        // Between the rows of an uneven curve the uncertainty of a single value is not known.
        let errors = errors.filter(|_| even.times() == curve.times());
        let errors = errors.map(|(_, errors)| errors);
        let back = self.scale.conversion.inverse();
        let measured = MeasuredCurve {
            metric: self.metric,
            normaliser: self.normaliser(even.values()).map_err(named)?,
            times: even.times().to_vec(),
            values: even.values().to_vec(),
            band,
            errors,
            resampling: resampling.transpose()?,
            delay,
            factor: back.difference(1.0),
            offset: back.value(0.0),
        };
        self.check_span(&measured)?;
        Ok(measured)
    }

    fn error_in_file(&self, message: impl Display) -> FileError {
        let file = &self.reference.file;
        self.study.error_at(file, format!("{}: {message}", file.as_ref().display()))
    }

    /// How the curve is drawn anew within its uncertainty. Criteria on the same column see the same errors, as do those whose
    /// errors are fully correlated.
    fn resampling(&self, errors: Option<CurveErrors>, first: u64) -> Result<Resampling> {
        let (ideal, tolerance, _) =
            limit(self.text, self.metric, self.scale).map_err(|message| self.study.error_of(self.name, message))?;
        let (sensor, sign) = self.study.sensor(self.name, self.text);
        let name = digest(sensor.as_bytes());
        let name = u64::from_str_radix(&name[..16], 16).expect("a digest is hexadecimal digits");
        Ok(Resampling { errors, sign, seed: self.study.design.seed ^ name, first, ideal, tolerance })
    }

    /// The parts of the rows' errors (shared, gain, own), without noise and with it; none where no uncertainty is stated.
    fn errors(&self, curve: &Curve, expanded: Option<&[f64]>) -> Result<Option<(CurveErrors, CurveErrors)>> {
        let reference = self.reference;
        let named = |message| self.study.error_of(self.name, message);
        let is_rectangular = reference.uncertainty_distribution == Some(Distribution::Rectangular);
        let stray = reference.coverage.is_some()
            && (is_rectangular || !reference.has_uncertainty() && reference.gain_uncertainty.is_none());
        first_wrong(&[
            (
                stray && is_rectangular,
                "a rectangular uncertainty is the half-width of its limits, which no coverage factor expands; remove `coverage` from \
                 the reference",
            ),
            (
                stray,
                "`coverage` says how many standard uncertainties the reference's `uncertainty` is; add it, or remove `coverage`",
            ),
            (
                reference.uncertainty_distribution.is_some() && !reference.has_uncertainty(),
                "`uncertainty-distribution` says how the reference's `uncertainty` is meant; add `uncertainty` or remove it",
            ),
            (
                reference.correlation.is_some() && !reference.has_uncertainty(),
                "`correlation` splits the reference's `uncertainty`; add `uncertainty` or remove it",
            ),
            (
                reference.noise_estimate.is_some() && reference.noise.is_none(),
                "`noise-estimate` says how well the reference's `noise` is known; add `noise` or remove it",
            ),
            (
                reference.noise_estimate.as_ref().is_some_and(|noise| !noise.as_ref().is_sound()),
                "`noise-estimate` needs a positive `freedom`, a `correlation` from -1 to 1, and 1 or more for `rows`",
            ),
        ])
        .map_err(named)?;
        let correlation = self.correlation()?;
        if !reference.is_uncertain() {
            return Ok(None);
        }
        let stated = reference.coverage.as_ref();
        let coverage = stated.map_or(Uncertainty::USUAL, |coverage| *coverage.as_ref());
        if !(coverage > 0.0 && coverage.is_finite()) {
            return Err(named(format!("the coverage factor {coverage} must be a positive, finite number")));
        }
        let of_offset = if is_rectangular { Uncertainty::rectangular(1.0) } else { Uncertainty::normal(1.0, coverage) };
        let gain = reference
            .gain_uncertainty
            .as_ref()
            .map(|stated| gain(stated.as_ref()).map_err(|message| self.study.error_at(stated, message)));
        let noise =
            reference.noise.as_ref().map(|stated| self.widths(stated, curve.values())).transpose().map_err(named)?;
        let rows = 0..curve.values().len();
        let standard = |row: usize| expanded.map_or(0.0, |widths| widths[row] * of_offset.offset());
        let [shared, own] = [correlation, 1.0 - correlation].map(f64::sqrt);
        let noise = |row: usize| noise.as_ref().map_or(0.0, |noise| noise[row]);
        let without = CurveErrors {
            shared: rows.clone().map(|row| shared * standard(row)).collect(),
            gain: gain.transpose()?.unwrap_or(0.0) / coverage,
            own: rows.clone().map(|row| own * standard(row)).collect(),
            coverage: [of_offset.coverage, coverage],
            rectangular: is_rectangular,
        };
        let with = rows.map(|row| without.own[row].hypot(noise(row)));
        let with = CurveErrors { own: with.collect(), ..without.clone() };
        Ok(Some((without, with)))
    }

    /// The correlation of the errors of any two rows.
    fn correlation(&self) -> Result<f64> {
        if let Some(stated) = &self.reference.correlation
            && !(0.0..=1.0).contains(stated.as_ref())
        {
            return Err(self.study.error_at(stated, format!(
                "{}: the correlation of the reference's errors is {}; it must be from 0 (noise) to 1 (an offset that all rows \
                 share)",
                self.name.as_ref(),
                stated.as_ref()
            )));
        }
        Ok(self.reference.row_correlation())
    }

    /// The rows that count, and the expanded uncertainty of each, in the criterion's unit.
    fn read(&self) -> Result<RecordedRows> {
        let reference = self.reference;
        let named = |message| self.study.error_of(self.name, message);
        let at_file = |message| self.study.error_at(&reference.file, message);
        let path = self.study.path_of(reference.file.as_ref());
        let time = reference.time.as_deref().unwrap_or("time");
        let column = self.text.recorded_column();
        let mut columns = vec![number_tables::column(column, format!("the criterion {}", self.name.as_ref()))];
        if let Some(column) = &reference.uncertainty_column {
            columns.push(number_tables::column(column, "the uncertainty"));
        }
        let table = Table::read_over_time(&path, reference.time.as_deref(), columns)
            .map_err(|error| at_file(error.to_string()))?;
        let in_file = |message| at_file(format!("{}: {message}", path.display()));
        let unit = number_tables::agreed(column, table.units[1].as_deref(), reference.unit.as_deref());
        let conversion =
            unit.map_err(in_file)?.map_or(Ok(Conversion::IDENTITY), |unit| self.scale.from(unit)).map_err(named)?;
        let cells = |place: usize| table.rows.iter().map(move |row| row[place]);
        let values = cells(1).map(|value| conversion.value(value)).collect();
        let curve = Curve::new(cells(0).collect(), values).map_err(|fault| {
            let (row, remedy) = match fault.row() {
                Some(row) => (format!(" row {}:", row + 1), "correct or remove the row"),
                None => (String::new(), "record a curve, or state the value as `nominal`"),
            };
            at_file(format!("{}:{row} {fault} (columns `{time}` and `{column}`); {remedy}", path.display()))
        })?;
        let expanded = match (&reference.uncertainty, &reference.uncertainty_column) {
            (Some(_), Some(_)) => {
                return Err(named("the reference has both uncertainty and uncertainty-column; keep one".to_owned()));
            }
            (Some(stated), None) => Some(self.widths(stated, curve.values()).map_err(named)?),
            (None, Some(_)) => Some(cells(2).map(|value| conversion.difference(value)).collect()),
            (None, None) => None,
        };
        self.cut(curve, expanded)
    }

    /// The rows inside the window that the study states.
    fn cut(&self, curve: Curve, expanded: Option<Vec<f64>>) -> Result<RecordedRows> {
        let is_width = |width: &f64| *width >= 0.0 && width.is_finite();
        let wrong = expanded.iter().flatten().position(|width| !is_width(width));
        if let Some(row) = wrong {
            return Err(self.error_in_file(format!("row {}: the uncertainty must be 0 or more", row + 1)));
        }
        let Some([from, to]) = self.window else { return Ok(RecordedRows { curve, expanded, first: 0 }) };
        let rounding = 1e-9 * (from.abs() + to.abs());
        let window = [from - rounding, to + rounding];
        let rows = curve.rows(window);
        let cut = curve.cut(window).map_err(|_| {
            let [first, last] = curve.span();
            self.error_in_file(format_args!(
                "{} rows lie in the window from {from} s to {to} s, and a curve needs two; the measurement goes from \
                 {first} s to {last} s",
                rows.len()
            ))
        })?;
        Ok(RecordedRows {
            curve: cut,
            first: rows.start as u64,
            expanded: expanded.map(|widths| widths[rows].to_vec()),
        })
    }

    /// A width at each value: a constant, or a part of the value.
    fn widths(&self, stated: &Quantity, values: &[f64]) -> Result<Vec<f64>, String> {
        let widths: Vec<f64> = match stated.unit.as_deref() {
            Some("%") => values.iter().map(|value| 0.01 * stated.number * value.abs()).collect(),
            _ => vec![self.scale.number(stated, Sense::Difference)?; values.len()],
        };
        if stated.number > 0.0 && stated.number.is_finite() {
            Ok(widths)
        } else {
            Err(format!("the width {stated} must be a positive, finite number"))
        }
    }

    fn band(&self, curve: &Curve, expanded: Option<&[f64]>) -> Result<Vec<f64>, String> {
        if self.metric != Metric::Corridor {
            return Ok(Vec::new());
        }
        match (&self.text.band, expanded) {
            (Some(band), _) => self.widths(band, curve.values()),
            (None, Some(expanded)) => Ok(expanded.to_vec()),
            (None, None) => Err(
                "a corridor needs its half width: add band = \"0.02 N.m\" or \"5 %\", or the uncertainty of the reference"
                    .to_owned(),
            ),
        }
    }

    /// The curve at even times, where the metric needs them, with the errors of its values where they are known there.
    fn even(&self, curve: &Curve, errors: Option<&CurveErrors>) -> Result<(Curve, Option<CurveErrors>)> {
        if !self.metric.needs_even_times() {
            return Ok((curve.clone(), errors.cloned()));
        }
        let (least, most) = (iso18571::LEAST, iso18571::MOST);
        let count = curve.even_count();
        if count < least as f64 || count > most as f64 {
            return Err(self.study.error_of(
                self.name,
                format!(
                    "{} needs {least} to {most} evenly spaced samples, and the reference has {count}; resample it",
                    self.metric.name()
                ),
            ));
        }
        // An error that all rows share goes along the same straight lines as the values; that of a single row does not.
        let known = |errors: &&CurveErrors| {
            let shared_alone = errors.own.iter().all(|own| *own == 0.0);
            count <= MOST_DRAWN && (curve.is_even() || shared_alone)
        };
        let evenly =
            |widths: &[f64]| Some(Curve::new(curve.times().to_vec(), widths.to_vec()).ok()?.evenly().values().to_vec());
        let errors = errors.filter(known).and_then(|errors| {
            Some(CurveErrors { shared: evenly(&errors.shared)?, own: evenly(&errors.own)?, ..errors.clone() })
        });
        Ok((curve.evenly(), errors))
    }

    fn normaliser(&self, values: &[f64]) -> Result<f64, String> {
        if self.metric != Metric::Nrmse {
            return Ok(1.0);
        }
        let (by, what) = match &self.text.normalise {
            Some(Normalise::Value(value)) => (self.scale.number(value, Sense::Difference)?, "value"),
            Some(Normalise::Own(OwnNormaliser::Mean)) => {
                ((values.iter().sum::<f64>() / values.len() as f64).abs(), "mean")
            }
            Some(Normalise::Own(OwnNormaliser::Range)) | None => {
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                (most - least, "range")
            }
        };
        if by > 0.0 && by.is_finite() {
            Ok(by)
        } else {
            Err(format!("nrmse divides by the {what} of the reference, which is {by}; choose another `normalise`"))
        }
    }

    /// Refuses a measurement that the run does not cover.
    fn check_span(&self, measured: &MeasuredCurve) -> Result {
        let ([from, to], [start, stop]) = (measured.needs(), self.run);
        let rounding = 1e-9 * (start.abs() + stop.abs());
        if from >= start - rounding && to <= stop + rounding {
            return Ok(());
        }
        let after = match measured.delay {
            0.0 => String::new(),
            delay => format!(" after the delay of {delay} s"),
        };
        let [from, to] = [from, to].map(|time| (time * 1e6).round() / 1e6);
        Err(self.error_in_file(format_args!(
            "the measurement from {from} s to {to} s{after} is not within the run from {start} s to {stop} s; set `window` \
             on the criterion to the common part, or change start and stop under [simulation]"
        )))
    }
}

/// What makes a criterion on a measured curve hardly refuse anything.
pub fn doubt(name: &str, curve: &MeasuredCurve, (ideal, tolerance, _): (f64, f64, String)) -> Option<Concern> {
    const COVERAGE: f64 = 2.0;
    let MeasuredCurve { metric, times, values, band, errors, normaliser, .. } = curve;
    if times.len() < 3 {
        let text = format!("{name}: the recording has {} rows that count, and two rows are no curve", times.len());
        let remedy = "Record more rows, widen `window`, or judge single values (`nominal`).";
        return Some(Concern::new(Code::FewRows, text).remedied(remedy));
    }
    let accuracy = |row: usize| errors.as_ref().map_or(0.0, |errors| errors.shared[row].hypot(errors.own[row]));
    let is_zero = values.iter().enumerate().all(|(row, value)| value.abs() <= COVERAGE * accuracy(row));
    let zeros = vec![0.0; values.len()];
    let pair = Pair { reference: values, model: &zeros, band, normaliser: *normaliser };
    let accepts = *metric != Metric::Iso18571 && (metric.compare(&pair) - ideal).abs() <= tolerance;
    (accepts && !is_zero).then(|| {
        let text = format!("{name}: with its tolerance even 0 throughout is accepted in place of the recording");
        Concern::new(Code::WideTolerance, text).remedied(ACCEPTS_ZERO)
    })
}

impl Study {
    /// The sensor whose errors a measured curve has, with a sign: the column of its recording, or the one that stands for all
    /// curves whose errors are fully correlated with its own. Their errors go with that sensor's (1) or against them (-1).
    pub fn sensor(&self, name: &Name, text: &CriterionText) -> (String, f64) {
        let pairs = self.uncertainty_correlations.iter().map(Spanned::as_ref);
        let pairs: Vec<&super::Pair> = pairs.collect();
        let mut tied: Vec<(&str, f64)> = vec![(name.as_ref(), 1.0)];
        let mut next = 0;
        while let Some(&(from, sign)) = tied.get(next) {
            for super::Pair { between: [a, b], coefficient, .. } in &pairs {
                for [a, b] in [[a, b], [b, a]].map(|pair| pair.map(|name| name.as_ref().as_str())) {
                    if a == from && tied.iter().all(|(other, _)| *other != b) {
                        tied.push((b, sign * coefficient.signum()));
                    }
                }
            }
            next += 1;
        }
        match &tied[..] {
            [_] => {
                let file = text.reference.as_ref().map(|reference| reference.file.as_ref().display());
                let file = file.map(|file| file.to_string()).unwrap_or_default();
                (format!("{file}\0{}", text.recorded_column()), 1.0)
            }
            several => {
                let (first, sign) = several.iter().min_by_key(|(name, _)| *name).expect("one is there");
                ((*first).to_owned(), *sign)
            }
        }
    }
}
