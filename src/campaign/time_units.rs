//! Whether times that count as seconds may be in thousandths of them or less: recordings of one motion
//! last about as long, and a stream is sampled more often than what it is smoothed over.
//!
//! It reads no file and changes no time.

use crate::campaign::declared::RunEntry;
use crate::campaign::dialect::cells;
use crate::campaign::formats::unit_since_1970;
use crate::campaign::header::{TIME, split};
use crate::campaign::spline::{Smoothing, mean_spacing};
use crate::campaign::table::Table;
use crate::campaign::wanted::ADDED;
use crate::diagnostic::{Diagnostic, decimals};
use crate::units::Unit;

/// Units of time that programs write, in parts of a second.
const UNITS: [(f64, &str); 4] = [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")];
/// Durations within such a factor of each other are alike.
const ALIKE: f64 = 4.0;

/// The unit of which a second has so many, about.
fn unit_of(parts: f64) -> Option<&'static str> {
    let is_alike = |size: &f64| (size.recip() * parts.abs()).ln().abs() < ALIKE.ln();
    UNITS.iter().find(|(size, _)| is_alike(size)).map(|(_, unit)| *unit)
}

/// What the stamps of a file of a run are said to be.
#[derive(Clone, Debug)]
pub(crate) struct Stamps {
    /// Its name in the campaign.
    file: String,
    /// All streams of the run, of a stream; else it is the data.
    streams: Option<Vec<String>>,
    /// The column as `columns` names it, without its unit; `None` where it is not to be shown or is
    /// a sum of columns.
    column: Option<Result<String, usize>>,
    /// Whether the header states the unit.
    in_header: bool,
    unit: Unit,
    /// How long it lasts (s), of a stream.
    lasts: f64,
    /// The first one (s).
    first: Option<f64>,
    /// Whether the first rows have whole numbers.
    are_counts: bool,
}

impl Stamps {
    /// Those of a file of a run.
    pub(crate) fn of(entry: &RunEntry, table: &Table) -> Option<Self> {
        let column = table.column(TIME)?;
        let name = table.name();
        let mut streams = entry.signals.iter().map(|one| one.name.text.clone());
        let is_it = |one: &String| one.rsplit(['/', '\\']).next() == Some(name.as_str());
        let stream = streams.clone().find(is_it);
        let data = entry.data.as_ref().map(|one| one.name.text.clone());
        let file = stream.clone().or(data)?;
        let streams = stream.map(|_| streams.by_ref().collect());
        let names = table.layout.header.as_ref().map(|header| header.names()).unwrap_or_default();
        let stated = names.get(column.index).and_then(|(cell, _)| split(cell).1);
        let is_sum = table.columns.iter().any(|one| one.wanted.as_deref() == Some(ADDED));
        let named = match column.is_named {
            true => Ok(column.name.clone()),
            false => Err(column.index + 1),
        };
        let lasts = match table.values(TIME).unwrap_or_default() {
            [first, .., last] => last - first,
            _ => f64::NAN,
        };
        let layout = &table.layout;
        let is_count = |row: &String| {
            let cell = cells(row, layout.separator).nth(column.index);
            let number = cell.and_then(|(cell, _)| cell.parse::<f64>().ok());
            number.is_some_and(|number| number.fract() == 0.0)
        };
        Some(Self {
            file,
            streams,
            column: (!is_sum && !table.is_outside()).then_some(named),
            in_header: stated.is_some_and(|(unit, _)| !unit.trim().is_empty()),
            unit: column.unit.clone(),
            lasts,
            first: table.first_stamp(),
            are_counts: layout.rows.len() > 2 && layout.rows.iter().all(is_count),
        })
    }

    /// What to do where the stamps are in another unit.
    fn read_in(&self, unit: &str) -> String {
        let Self { file, column, .. } = self;
        match column {
            None => format!("state that unit for `{file}`"),
            // A unit of the campaign that the header contradicts would be refused.
            Some(Ok(name)) if self.in_header => {
                format!("write `{name} [{unit}]` in the header of `{file}`")
            }
            Some(column) => {
                let time = match column {
                    Ok(name) => format!("\"{name} [{unit}]\""),
                    Err(number) => format!("{{ column = {number}, unit = \"{unit}\" }}"),
                };
                let own = format!("{{ file = \"{file}\", columns = {{ time = {time} }} }}");
                let quoted = |one: &String| match one == file {
                    true => own.clone(),
                    false => format!("\"{one}\""),
                };
                let all = self.streams.iter().flatten().map(quoted).collect::<Vec<_>>();
                match self.streams {
                    Some(_) => format!("signals = [{}] reads them so", all.join(", ")),
                    None => format!("data = {own} reads them so"),
                }
            }
        }
    }

    /// The unit in which stamps as large count since 1970, and whether it is the one that is stated.
    fn since_1970(&self) -> Option<(&'static str, bool)> {
        let symbol = unit_since_1970(self.first? / self.unit.factor)?;
        let unit = Unit::parse(symbol).ok()?;
        Some((symbol, unit.factor == self.unit.factor))
    }

    /// The unit whose numbers would last `times` as long with the unit that is stated.
    fn smaller(&self, times: f64) -> Option<&'static str> {
        unit_of(times / self.unit.factor)
    }
}

/// Whether samples last `times` as long as their streams because the times of one of them are in another
/// unit, and what to do then; `stamps` are those of the files.
pub(super) fn other_unit(stamps: &[Stamps], times: f64) -> Option<(String, String)> {
    let factor = times.max(times.recip());
    unit_of(factor).filter(|unit| *unit != "s")?;
    let (data, streams): (Vec<&Stamps>, Vec<&Stamps>) =
        stamps.iter().partition(|one| one.streams.is_none());
    let shortest = streams.iter().map(|one| one.lasts).fold(f64::INFINITY, f64::min);
    let is_of_these = |one: &&&Stamps| times < 1.0 || one.lasts < ALIKE * shortest;
    let streams: Vec<&Stamps> = streams.iter().filter(is_of_these).copied().collect();
    let (longer, shorter, what) = match times > 1.0 {
        true => (data, streams, "samples"),
        false => (streams, data, "streams"),
    };
    let (long, short) = (*longer.first()?, *shorter.first()?);
    // A unit that the shorter one states, and the longer one does not, is the one that is doubtful.
    let is_stated = short.unit.factor < long.unit.factor;
    let (doubtful, unit) = match is_stated {
        true => (shorter, unit_of(1.0 / (factor * short.unit.factor))?),
        false => (longer, long.smaller(factor)?),
    };
    let files: Vec<String> = doubtful.iter().map(|one| format!("`{}`", one.file)).collect();
    let each: Vec<String> = doubtful.iter().map(|one| one.read_in(unit)).collect();
    let instead = if is_stated { format!(", not in {}", short.unit.symbol) } else { String::new() };
    let doubt = format!(
        "the {what} last {factor:.0} times as long: are the times of {} in {unit}{instead}?",
        files.join(" and ")
    );
    Some((doubt, each.join(", ")))
}

/// What to do where samples, from and to these times (s) and so far apart, lie outside streams, and would
/// lie within them, about as dense, if whole numbers counted a smaller unit than stated.
pub(super) fn counted_in(
    stamps: &[Stamps],
    (samples, spacing): ((f64, f64), f64),
    (streams, of_streams): ((f64, f64), f64),
) -> Option<String> {
    let within = |(first, last): (f64, f64), (from, to)| from <= first && last <= to;
    let by = |(from, to): (f64, f64), size: f64| (from / size, to / size);
    let apart = |spacing: f64, of_streams: f64| (spacing / of_streams).ln().abs();
    let are_data = |one: &Stamps, size: f64| {
        one.streams.is_none()
            && within(by(samples, size), streams)
            && apart(spacing / size, of_streams) < apart(spacing, of_streams)
    };
    let are_streams = |one: &Stamps, size: f64| {
        one.streams.is_some()
            && within(samples, by(streams, size))
            && apart(spacing, of_streams / size) < apart(spacing, of_streams)
    };
    let counts = stamps.iter().filter(|one| one.are_counts);
    counts.flat_map(|one| UNITS[1..].iter().map(move |(size, _)| (one, *size))).find_map(
        |(one, size)| {
            let is_meant = are_data(one, size) || are_streams(one, size);
            let unit = one.smaller(size).filter(|_| is_meant)?;
            Some(format!(
                "in {unit} the whole numbers of `{}` would be times within the streams: {}",
                one.file,
                one.read_in(unit)
            ))
        },
    )
}

/// The part of samples, from `first` to `last`, that streams from `from` to `to` would cover if their times
/// were in so many parts of a second as make both last about as long.
pub(super) fn covered_in_parts((first, last): (f64, f64), (from, to): (f64, f64)) -> f64 {
    let is_alike =
        |(size, _): &&(f64, &str)| ((to - from) / (last - first) / size).ln().abs() < ALIKE.ln();
    let parts = UNITS[1..].iter().find(is_alike).map(|(size, _)| size);
    let within = |parts: &f64| (last.min(to / parts) - first.max(from / parts)) / (last - first);
    parts.map_or(0.0, within)
}

/// What to do where stamps of one file of a run count since 1970 as they are stated, and those of another
/// one would in another unit: by themselves these may count from when a computer was started.
pub(super) fn other_unit_since_1970(stamps: &[Stamps]) -> Option<String> {
    let is_right = |one: &Stamps| one.since_1970().is_some_and(|(_, is_stated)| is_stated);
    let wrong = stamps.iter().find_map(|one| match one.since_1970() {
        Some((symbol, false)) => Some((one, symbol)),
        _ => None,
    });
    let (one, symbol) = wrong.filter(|_| stamps.iter().any(is_right))?;
    Some(format!(
        "stamps as large as those of `{}` count in {symbol} since 1970, not in `{}`: {}",
        one.file,
        one.unit.symbol,
        one.read_in(symbol)
    ))
}

/// Warns of a stream whose times are whole numbers and farther apart than what it is to be smoothed
/// over, which they would not be in a smaller unit.
pub(super) fn coarse(
    times: &[f64],
    smoothing: Smoothing,
    stamps: Option<&Stamps>,
) -> Option<Diagnostic> {
    let Smoothing::TimeConstant(time) = smoothing else { return None };
    let (period, spacing) = (time * std::f64::consts::TAU, mean_spacing(times));
    let are_counts = times.len() > 2 && times.iter().all(|time| time.fract() == 0.0);
    if !are_counts || spacing.is_nan() || spacing <= period {
        return None;
    }
    let (_, unit) = UNITS[1..].iter().find(|(size, _)| spacing < size * period)?;
    let message = format!(
        "samples of a stream are {} s apart, and it is to be smoothed over {} s",
        decimals(spacing, 3),
        decimals(period, 3)
    );
    let what = stamps.map_or_else(String::new, |one| format!(" {}", one.read_in(unit)));
    Some(Diagnostic::warning(message).help(format!("are its times in {unit}?{what}")))
}

#[cfg(test)]
mod tests {
    use super::unit_of;

    #[test]
    fn durations_a_thousand_times_as_long_are_in_thousandths() {
        assert_eq!(unit_of(963.0), Some("ms"));
        assert_eq!(unit_of(2.2e6), Some("us"));
        assert_eq!(unit_of(0.4e9), Some("ns"));
        assert_eq!(unit_of(60.0), None);
        assert_eq!(unit_of(1.0), Some("s"));
    }
}
