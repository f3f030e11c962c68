//! Time stamps as loggers write them.

use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike};

/// A time stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// Since 1970, or since midnight where the stamp has no day.
    pub nanoseconds: i64,
    /// What it counts from.
    pub clock: Clock,
}

/// What time stamps count from: stamps of one kind can be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The stamp has a zone.
    Zone,
    /// A date without a zone.
    Local,
    /// A time of day alone.
    Day,
}

const ZONED: [&str; 2] = ["%Y-%m-%dT%H:%M:%S%.f%#z", "%Y%m%dT%H%M%S%.f%#z"];
/// A year of two digits stands before one of four, as it ends where the other one goes on.
const LOCAL: [&str; 8] = [
    "%Y-%m-%dT%H:%M:%S%.f",
    "%d.%m.%yT%H:%M:%S%.f",
    "%d.%m.%YT%H:%M:%S%.f",
    "%Y/%m/%dT%H:%M:%S%.f",
    "%Y%m%dT%H%M%S%.f",
    "%m/%d/%YT%I:%M:%S%.f %p",
    "%d.%m.%YT%H:%M",
    "%Y-%m-%dT%H:%M",
];

/// A stamp: after ISO 8601, as in German (`22.11.2026 13:15:07,25`), a time of day, or as `form` says in chrono's letters.
pub fn stamp(cell: &str, form: Option<&str>) -> Option<Stamp> {
    if !cell.starts_with(|first: char| first.is_ascii_digit()) && form.is_none() {
        return None;
    }
    let of = |clock| move |nanoseconds| Stamp { nanoseconds, clock };
    let local = |text: &str, form: &str| {
        let time = NaiveDateTime::parse_from_str(text, form).ok()?;
        time.and_utc().timestamp_nanos_opt().map(of(Clock::Local))
    };
    let day = |text: &str, form: &str| {
        let time = NaiveTime::parse_from_str(text, form).ok()?;
        let seconds = i64::from(time.num_seconds_from_midnight());
        Some(of(Clock::Day)(seconds * 1_000_000_000 + i64::from(time.nanosecond())))
    };
    let zoned = |text: &str, form: &str| {
        let time = DateTime::parse_from_str(text, form).ok()?;
        time.timestamp_nanos_opt().map(of(Clock::Zone))
    };
    if let Some(form) = form {
        return zoned(cell, form).or_else(|| local(cell, form)).or_else(|| day(cell, form));
    }
    // Only a stamp has two of these.
    if cell.matches([':', 'T']).count() < 1 || cell.len() < 7 {
        return None;
    }
    let iso = cell.replacen(' ', "T", 1).replace(',', ".");
    let utc = iso.strip_suffix(['Z', 'z']).map(|iso| format!("{iso}+00:00"));
    let with_zone = utc.as_ref().unwrap_or(&iso);
    let local = LOCAL.iter().find_map(|form| local(&iso, form));
    let zoned = || ZONED.iter().find_map(|form| zoned(with_zone, form));
    local.or_else(zoned).or_else(|| day(&iso, "%H:%M:%S%.f"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_stamps_are_understood() {
        let at = |cell: &str| stamp(cell, None).unwrap_or_else(|| panic!("{cell}"));
        let noon = at("2026-11-22T12:00:00Z");
        assert_eq!(noon.clock, Clock::Zone);
        for same in
            ["2026-11-22T13:00:00+01:00", "2026-11-22 07:30:00-0430", "2026-11-22T13:00:00.000+01", "20261122T120000Z"]
        {
            assert_eq!(at(same), noon, "{same}");
        }
        let later = at("2026-11-22T12:00:00,250000001Z");
        assert_eq!(later.nanoseconds - noon.nanoseconds, 250_000_001);
        let local = at("2026-11-22T12:00:00.25");
        assert_eq!(local.clock, Clock::Local);
        for same in ["22.11.2026 12:00:00,25", "2026/11/22 12:00:00.250", "11/22/2026 12:00:00.25 PM"] {
            assert_eq!(at(same), local, "{same}");
        }
        let minute = at("22.11.2026 12:01");
        assert_eq!(minute.nanoseconds - local.nanoseconds, 59_750_000_000);
        assert_eq!(at("12:00:00,5").nanoseconds, 43_200_500_000_000);
        // The third of November or the eleventh of March: the settings say.
        assert_eq!(stamp("03/11/2026 12:00:00", None), None);
        let said = stamp("03/11/2026 12:00:00", Some("%d/%m/%Y %H:%M:%S")).unwrap();
        assert_eq!(said, at("2026-11-03 12:00:00"));
        for none in ["", "2026-11-22", "2026-13-01T00:00:00Z", "s", "1.5", "12:00", "T"] {
            assert_eq!(stamp(none, None), None, "{none}");
        }
    }
}
