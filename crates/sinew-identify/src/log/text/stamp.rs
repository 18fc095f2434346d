//! Time as text: calendar stamps, clock times and durations with their unit.

use crate::log::units;

/// Nanoseconds per second.
const SECOND: i64 = 1_000_000_000;
const DAY: i64 = 86_400 * SECOND;

const MONTHS: [&str; 12] =
    ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];

/// Time since the first stamp of a column.
///
/// A date of three numbers may begin with the day or the month. On one day both give the same time; which it
/// is shows where only one of them is a date, or at midnight, where the right one advances by a day.
#[derive(Default)]
pub(super) struct Stopwatch {
    first: Option<Stamp>,
    order: Option<usize>,
    before: i64,
    /// Days that clocks without a date have begun since.
    midnights: i64,
}

impl Stopwatch {
    /// Nanoseconds from the first cell to this one; `None` where either states no time.
    pub(super) fn nanoseconds(&mut self, cell: &[u8]) -> Option<i64> {
        let now = stamp(cell)?;
        let first = *self.first.get_or_insert(now);
        let elapsed = |order: usize| Some(now[order]?.saturating_sub(first[order]?));
        if self.order.is_none() && elapsed(DAY_FIRST) != elapsed(MONTH_FIRST) {
            let least = |order: &usize| elapsed(*order).map_or(u64::MAX, i64::unsigned_abs);
            self.order = [DAY_FIRST, MONTH_FIRST].into_iter().min_by_key(least);
        }
        let mut elapsed = elapsed(self.order.unwrap_or(DAY_FIRST))?.saturating_add(self.midnights * DAY);
        let is_of_day = now.iter().all(|now| now.is_some_and(|now| (0..DAY).contains(&now)));
        if is_of_day && elapsed < self.before - DAY / 2 {
            self.midnights += 1;
            elapsed += DAY;
        }
        self.before = elapsed;
        Some(elapsed)
    }
}

/// Nanoseconds from an origin that all cells of a form share, with the day and with the month first in a
/// date.
type Stamp = [Option<i64>; 2];
const DAY_FIRST: usize = 0;
const MONTH_FIRST: usize = 1;

/// Whether a cell states time by itself; plain numbers do not.
///
/// | form                 | examples                                                                        |
/// |----------------------|---------------------------------------------------------------------------------|
/// | calendar and clock   | `2026-03-01T12:00:00.005Z`, `2026-03-01 12:00:00+01:00`, `01-Mar-2026 12:00:00`, `01.03.2026 12:00:00,005` |
/// | clock                | `12:00:00.005`, `-0:05.2`                                                        |
/// | duration             | `0.005 sec`, `5 ms`, `0 days 00:00:00.005`                                       |
pub(super) fn is_stamp(cell: &[u8]) -> bool {
    stamp(cell).is_some()
}

fn stamp(cell: &[u8]) -> Option<Stamp> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    // Longer is no stamp, and a stamp holds a digit.
    if text.len() > 48 || !text.bytes().any(|b| b.is_ascii_digit()) || text.parse::<f64>().is_ok() {
        return None;
    }
    let plain = |nanoseconds: i64| [Some(nanoseconds); 2];
    (duration(text).or_else(|| days_and_clock(text)).map(plain))
        .or_else(|| calendar(text))
        .or_else(|| clock(text).map(plain))
}

/// `0.005 sec`.
fn duration(text: &str) -> Option<i64> {
    let end = text.rfind(|c: char| c.is_ascii_digit() || c == '.' || c == ',')? + 1;
    let (number, unit) = text.split_at(end);
    let seconds = units::seconds(unit.trim()).filter(|_| !unit.trim().is_empty())?;
    let number: f64 = number.trim().replace(',', ".").parse().ok()?;
    rounded(number * seconds)
}

fn rounded(seconds: f64) -> Option<i64> {
    let nanoseconds = seconds * SECOND as f64;
    (nanoseconds.abs() < i64::MAX as f64).then_some(nanoseconds.round() as i64)
}

/// `0 days 00:00:00.005`, as pandas writes a duration; `+` may stand before the clock.
fn days_and_clock(text: &str) -> Option<i64> {
    let (days, rest) = text.split_once(" day")?;
    let rest = rest.trim_start_matches('s').trim_start_matches([',', ' ', '+']);
    let days: i64 = days.trim().parse().ok()?;
    let clock = if rest.is_empty() { 0 } else { clock(rest)? };
    days.checked_mul(DAY)?.checked_add(clock)
}

/// `2026-03-01T12:00:00.005Z`.
fn calendar(text: &str) -> Option<Stamp> {
    let at = text.find(['T', 't', ' ']).filter(|&at| at >= 6)?;
    let (days, rest) = (date(&text[..at])?, text[at + 1..].trim());
    let (rest, zone) = zone(rest)?;
    let of_day = clock(rest)?.checked_sub(zone)?;
    let stamp = days.map(|day| day?.checked_mul(DAY)?.checked_add(of_day));
    stamp.iter().any(Option::is_some).then_some(stamp)
}

/// The clock without its zone, and the zone's nanoseconds east of Greenwich.
fn zone(text: &str) -> Option<(&str, i64)> {
    if let Some(rest) = text.strip_suffix(['Z', 'z']).or_else(|| text.strip_suffix("UTC")) {
        return Some((rest.trim(), 0));
    }
    let Some(at) = text.rfind(['+', '-']).filter(|&at| at > 0) else { return Some((text, 0)) };
    let (rest, zone) = text.split_at(at);
    let digits: String = zone[1..].chars().filter(char::is_ascii_digit).collect();
    let (hours, minutes) = match digits.len() {
        1 | 2 => (digits.as_str(), "0"),
        4 => digits.split_at(2),
        _ => return None,
    };
    let minutes = 60 * hours.parse::<i64>().ok()? + minutes.parse::<i64>().ok()?;
    let sign = if zone.starts_with('-') { -1 } else { 1 };
    Some((rest.trim(), sign * minutes * 60 * SECOND))
}

/// Days since 1970 of `2026-03-01`, `01.03.2026`, `01/03/2026` and `01-Mar-2026`, with the day and with the
/// month first.
fn date(text: &str) -> Option<[Option<i64>; 2]> {
    let mut parts = text.split(['-', '/', '.']);
    let (first, second, third) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() {
        return None;
    }
    let number = |part: &str| part.parse::<i64>().ok().filter(|n| *n >= 0);
    let named = MONTHS.iter().zip(1..).find(|(name, _)| second.eq_ignore_ascii_case(name)).map(|(_, m)| m);
    let month = named.or_else(|| number(second))?;
    let (first_number, third_number) = (number(first)?, number(third)?);
    let day_first = days(third_number, month, first_number);
    let readings = match named {
        _ if first.len() == 4 => [days(first_number, month, third_number); 2],
        Some(_) => [day_first; 2],
        None => [day_first, days(third_number, first_number, month)],
    };
    Some(readings)
}

/// Days since 1970 of a date; `None` of what is none.
fn days(year: i64, month: i64, day: i64) -> Option<i64> {
    let sound = (1..=9999).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    sound.then(|| days_since_1970(year, month, day))
}

/// Days of the Gregorian calendar since 1970-01-01.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    // Years that begin in March, so that the leap day comes last.
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

/// `12:00:00.005`, `12:00`, `0:05.2`, with `AM` or `PM`.
fn clock(text: &str) -> Option<i64> {
    let (text, negative) = text.strip_prefix('-').map_or((text, false), |rest| (rest, true));
    let upper = text.to_ascii_uppercase();
    let half = [("AM", 0), ("PM", 12)]
        .into_iter()
        .find_map(|(mark, hours)| Some((upper.strip_suffix(mark)?.trim_end(), hours)));
    let (digits, half) = half.map_or((text, None), |(rest, hours)| (&text[..rest.len()], Some(hours)));
    let parts: Vec<&str> = digits.split(':').collect();
    let whole = |part: &str| part.parse::<i64>().ok().filter(|n| *n >= 0 && part.len() <= 6);
    let (hours, minutes, seconds) = match parts.as_slice() {
        [minutes, seconds] if seconds.contains(['.', ',']) => (0, whole(minutes)?, *seconds),
        [hours, minutes] => (whole(hours)?, whole(minutes)?, "0"),
        [hours, minutes, seconds] => (whole(hours)?, whole(minutes)?, *seconds),
        _ => return None,
    };
    let hours = half.map_or(hours, |half: i64| hours % 12 + half);
    let total = (60 * hours + minutes).checked_mul(60 * SECOND)?.checked_add(fraction(seconds)?)?;
    Some(if negative { -total } else { total })
}

/// Nanoseconds of `05.25`: exact, as no float would be.
fn fraction(seconds: &str) -> Option<i64> {
    let (whole, rest) = seconds.split_once(['.', ',']).unwrap_or((seconds, ""));
    if whole.is_empty() || whole.len() > 6 || !whole.bytes().chain(rest.bytes()).all(|b| b.is_ascii_digit()) {
        return None;
    }
    let digits: String = rest.chars().chain("000000000".chars()).take(9).collect();
    Some(whole.parse::<i64>().ok()? * SECOND + digits.parse::<i64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elapsed(cells: &[&str]) -> Vec<Option<i64>> {
        let mut watch = Stopwatch::default();
        cells.iter().map(|cell| watch.nanoseconds(cell.as_bytes())).collect()
    }

    #[test]
    fn every_form_of_a_stamp_counts_the_same_five_milliseconds() {
        for (before, after) in [
            ("2026-03-01T12:00:00", "2026-03-01T12:00:00.005"),
            ("2026-03-01T12:00:00Z", "2026-03-01T12:00:00.005000Z"),
            ("2026-03-01 13:00:00+01:00", "2026-03-01 12:00:00.005 +0000"),
            ("2024-02-28 23:59:59.999", "2024-02-29 00:00:00.004"),
            ("2023-12-31 23:59:59.998000000", "2024-01-01 00:00:00.003000000"),
            ("01-Mar-2026 12:00:00.000", "01-Mar-2026 12:00:00.005"),
            ("01.03.2026 12:00:00,000", "01.03.2026 12:00:00,005"),
            ("3/31/2026 11:59:59.995 PM", "4/1/2026 12:00:00.000 AM"),
            ("12:00:00", "12:00:00.005"),
            ("0:00.000", "0:00.005"),
            ("0 sec", "0.005 sec"),
            ("0 ms", "5 ms"),
            ("0 s", "0.005 s"),
            ("-5 ns", "4999995 ns"),
            ("0 days 00:00:00", "0 days 00:00:00.005000"),
            ("1 days 00:00:00", "1 days 00:00:00.005"),
        ] {
            assert_eq!(elapsed(&[before, after]), [0, 5_000_000].map(Some), "{before} {after}");
        }
    }

    #[test]
    fn midnight_shows_whether_the_day_or_the_month_comes_first() {
        for (evening, night, noon) in [
            ("1/4/2026", "1/5/2026", "1/5/2026"),
            ("4/1/2026", "5/1/2026", "5/1/2026"),
            ("11.12.2026", "12.12.2026", "12.12.2026"),
            ("12/12/2026", "12/13/2026", "12/13/2026"),
            ("12/12/2026", "13/12/2026", "13/12/2026"),
            ("12/31/2026", "1/1/2027", "1/1/2027"),
            ("31/12/2026", "1/1/2027", "1/1/2027"),
            ("4/30/2026", "5/1/2026", "5/1/2026"),
        ] {
            let cells =
                [format!("{evening} 23:59:59"), format!("{night} 00:00:00"), format!("{noon} 12:00:00")];
            let expected = [0, 1, 1 + 43_200].map(|seconds| Some(seconds * SECOND));
            assert_eq!(elapsed(&cells.each_ref().map(String::as_str)), expected, "{evening} {night}");
        }
        assert_eq!(elapsed(&["31/12/2026 00:00:00", "12/31/2026 00:00:01"]), [Some(0), None]);
    }

    #[test]
    fn a_clock_without_a_date_runs_on_over_midnight() {
        let cells = ["23:59:59.995", "00:00:00.005", "00:00:01.005", "12:00:00", "23:00:00", "01:00:00"];
        let seconds = [0.0, 0.01, 1.01, 43_200.005, 82_800.005, 90_000.005];
        assert_eq!(elapsed(&cells), seconds.map(|s: f64| Some((s * 1e9).round() as i64)));
    }

    #[test]
    fn what_is_no_stamp_is_none() {
        for text in [
            "",
            "1.5",
            "-1e-3",
            "abc",
            "NaN",
            "12 N",
            "2026-03-01",
            "run 3",
            "1:2:3:4",
            "2026-13-01 00:00:00",
            "5x",
            "12:",
            ":5",
        ] {
            assert!(!is_stamp(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn the_calendar_agrees_with_known_days() {
        for ((year, month, day), expected) in
            [((1970, 1, 1), 0), ((2000, 2, 29), 11_016), ((2026, 11, 26), 20_783), ((1969, 12, 31), -1)]
        {
            assert_eq!(days_since_1970(year, month, day), expected);
        }
    }
}
