//! A standard uncertainty to begin with: how much readings scatter about a smooth curve.
//!
//! Divided differences of a higher order leave less of a curve, and as much of white noise. Where one order
//! leaves about as much as the order below it, both are noise. Rows that are too sparse for that show an
//! upper bound at most. Where rows jump from one to the next, those of the same inputs show the noise, or none.

use crate::campaign::begin::log::Log;
use crate::campaign::begin::neighbours::Inputs;
use crate::campaign::begin::survey::Surveyed;
use crate::campaign::begin::word::Word;
use crate::campaign::glitches::least_step;
use crate::campaign::header::TIME;
use crate::statistics::robust;
use crate::units::Unit;

/// The lowest and the highest order of differences.
const ORDERS: [usize; 2] = [2, 6];
/// An order that leaves so much of what the order below it did holds noise.
const NOISE: f64 = 0.8;
/// A part of the way that sparse readings go, below which no scatter is guessed.
const OF_WAY: f64 = 2e-3;
/// Windows of rows that are looked at.
const MOST_WINDOWS: usize = 20_000;
/// Sizes that are easy to read in the unit of the measurand.
const EASY: std::ops::Range<f64> = 1e-2..1e4;
/// Units in which sizes are read, from large to small.
const READABLE: [&str; 10] = ["m", "mm", "um", "nm", "rad", "mrad", "urad", "s", "ms", "us"];

/// The standard uncertainty of a measurand.
#[derive(Clone, Debug)]
pub(super) struct Sigma {
    pub(super) measurand: String,
    /// With its unit; nothing where no row shows it.
    pub(super) value: Option<String>,
    pub(super) unit: Unit,
    /// From what it is guessed, or why it is not.
    pub(super) why: &'static str,
}

impl Sigma {
    /// Of a size in SI; `unit` is that of the measurand.
    pub(super) fn of(measurand: &str, size: f64, unit: &Unit, why: &'static str) -> Self {
        let value = Some(written(size, unit));
        Self { measurand: measurand.to_owned(), value, unit: unit.clone(), why }
    }

    /// Of the columns of a log that are a measurand: the largest of theirs.
    pub(super) fn of_columns(
        measurand: &str,
        words: &[Word],
        log: &Log,
        unit: &Unit,
        inputs: Inputs<'_>,
    ) -> Self {
        let jump = inputs.jump(log);
        let size = |column: &Surveyed| {
            // A smooth course of readings is one, whatever noise an input has beside it.
            if !jump || !log.stands_still() && !column.leaps() {
                return Some(scatter(log, column));
            }
            let scatter = inputs.repeatability(log, column)?;
            Some((scatter, "the scatter of readings at the same inputs"))
        };
        let own = Self::largest(measurand, words, (log, unit), size);
        own.unwrap_or_else(|| Self {
            measurand: measurand.to_owned(),
            value: None,
            unit: unit.clone(),
            why: "rows are in any order, and hardly any has the inputs of another: nothing shows the noise",
        })
    }

    /// The same of what a recorder integrates: its scatter is far smaller than its errors.
    pub(super) fn of_integrated(measurand: &str, words: &[Word], log: &Log, unit: &Unit) -> Self {
        let of_way = |column: &Surveyed| {
            let least = OF_WAY * column.way();
            let why = "0.2 % of the way: the errors of a path of dead reckoning are no scatter";
            Some((scatter(log, column).0.max(least), why))
        };
        let own = Self::largest(measurand, words, (log, unit), of_way);
        own.unwrap_or_else(|| Self::of(measurand, 0.0, unit, "no column"))
    }

    /// The largest of some columns, if each has a size.
    fn largest(
        measurand: &str,
        words: &[Word],
        (log, unit): (&Log, &Unit),
        size: impl Fn(&Surveyed) -> Option<(f64, &'static str)>,
    ) -> Option<Self> {
        let is_own = |word: &&Word| {
            word.name == measurand
                || word.name.strip_prefix(measurand).is_some_and(|rest| rest.starts_with('_'))
        };
        let own = words.iter().filter(is_own).filter(|word| word.name != TIME);
        let varies = |word: &&Word| log.survey.columns[word.candidate.column].range() > 0.0;
        if own.clone().next().is_some() && !own.clone().any(|word| varies(&word)) {
            let why = "all of its readings are the same: nothing shows the noise";
            let measurand = measurand.to_owned();
            return Some(Self { measurand, value: None, unit: unit.clone(), why });
        }
        let all = own.filter(varies).map(|word| {
            let (scatter, why) = size(&log.survey.columns[word.candidate.column])?;
            // The angle of a rotation is two times that of its quaternion.
            let times = if word.name == measurand { 1.0 } else { 2.0 };
            Some((times * scatter * word.candidate.unit.factor, why))
        });
        let all: Option<Vec<(f64, &'static str)>> = all.collect();
        let (size, why) = all?.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Self::of(measurand, size, unit, why))
    }
}

/// The scatter of a column, and from what it follows: at least that of rounding to the smallest step.
fn scatter(log: &Log, column: &Surveyed) -> (f64, &'static str) {
    let values = &column.values;
    let times = log.guess.time.as_ref().map(|time| time.values.as_slice());
    let smallest = least_step(values);
    let rounding = if smallest.is_finite() { smallest / 12_f64.sqrt() } else { 0.0 };
    let [lowest, highest] = ORDERS;
    let of_order: Vec<f64> =
        (lowest..=highest).map(|order| differences(times, values, order)).collect();
    let is_noise = |pair: &&[f64]| pair[1] >= NOISE * pair[0];
    let noise = of_order.windows(2).find(is_noise).filter(|_| !column.leaps());
    match noise {
        Some(pair) => {
            (pair[0].min(pair[1]).max(rounding), "the scatter of its readings about a smooth curve")
        }
        // What a model leaves out is more than noise: a part of the way, at least.
        None => (
            of_order[1].max(rounding).max(OF_WAY * column.way()),
            "third differences, at least 0.2 % of the way: the rows are too sparse for a smooth curve, or scatter over most of the way",
        ),
    }
}

/// The standard deviation of values in divided differences of an order over their times, robustly; over
/// their rows where there are no times.
fn differences(times: Option<&[f64]>, values: &[f64], order: usize) -> f64 {
    let time = |row: usize| times.map_or(row as f64, |times| times[row]);
    let rows = (0..values.len()).filter(|row| values[*row].is_finite() && time(*row).is_finite());
    let rows: Vec<usize> = rows.collect();
    let of_window = |window: &[usize]| {
        let part = |row: &usize| {
            let others = window.iter().filter(|other| *other != row);
            others.map(|other| time(*row) - time(*other)).product::<f64>().recip()
        };
        let parts: Vec<f64> = window.iter().map(part).collect();
        let length = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        let first = values[window[0]];
        let sum = window.iter().zip(&parts).map(|(row, part)| part * (values[*row] - first));
        (sum.sum::<f64>() / length).abs()
    };
    let windows = rows.windows(order + 1).step_by(rows.len() / MOST_WINDOWS + 1);
    let all: Vec<f64> = windows.map(of_window).filter(|one| one.is_finite()).collect();
    robust(&all).unwrap_or(0.0)
}

/// A size in SI to two digits, or to whole ones: in the unit of the measurand, of one in SI in one in which
/// it is easy to read.
fn written(size: f64, unit: &Unit) -> String {
    let size = size.max(1e-12 * unit.factor);
    let own = unit.of_differences();
    let is_like =
        |other: &Unit| other.dimension == own.dimension && other.is_angle() == own.is_angle();
    let readable = READABLE.iter().filter_map(|symbol| Unit::parse(symbol).ok());
    let is_long = own.factor == 1.0 || !EASY.contains(&(size / own.factor));
    let readable: Vec<Unit> = readable.filter(is_like).filter(|_| is_long).collect();
    let fits = readable.iter().find(|unit| size >= unit.factor).or(readable.last());
    let unit = fits.unwrap_or(&own);
    let scaled = size / unit.factor;
    let number = match (1e-4..1e6).contains(&scaled) {
        true => format!("{scaled:.*}", (1.0 - scaled.log10().floor()).max(0.0) as usize),
        false => format!("{scaled:.1e}"),
    };
    format!("{number} {}", unit.symbol)
}
