//! Whether successive rows are neighbours: between poses in any order readings differ by their model, and
//! differences from row to row are no noise. Rows of the same inputs show it there.

use std::collections::HashMap;

use crate::campaign::begin::log::Log;
use crate::campaign::begin::survey::Surveyed;
use crate::campaign::begin::word::Word;
use crate::campaign::glitches::least_step;
use crate::campaign::header::TIME;
use crate::statistics::robust;

/// So many pairs of rows with the same inputs make a scatter.
const LEAST_PAIRS: usize = 6;
/// From so many of its rows an input leaps that goes along the lines of a grid, and back at their ends.
const IN_A_GRID: f64 = 0.1;

/// The columns that are the inputs of readings.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'l> {
    pub(super) log: &'l Log,
    pub(super) words: &'l [Word],
    /// Whether each input of the model is one of them.
    pub(super) is_whole: bool,
}

impl<'l> Inputs<'l> {
    fn columns(&self) -> impl Iterator<Item = &'l Surveyed> + use<'l> {
        let (log, words) = (self.log, self.words);
        let own = words.iter().filter(|word| word.name != TIME);
        own.map(|word| &log.survey.columns[word.candidate.column])
    }

    /// Whether they jump from row to row of the readings: between stops in most of the lines of a grid, too.
    pub(super) fn jump(&self, data: &Log) -> bool {
        if std::ptr::eq(self.log, data) {
            let are_unknown = !self.is_whole && data.guess.time.is_none();
            let most = if data.stands_still() { IN_A_GRID } else { 0.5 };
            return are_unknown || self.columns().any(|column| column.leaping(1) > most);
        }
        // A stream is smooth at its own rate; one that leaps there is noise.
        let spacings = data.spacing().zip(self.log.spacing());
        let every = spacings.map_or(1, |(slow, fast)| (slow / fast).round() as usize);
        self.columns().any(|column| !column.leaps() && column.leaping(every) > 0.5)
    }

    /// The scatter of readings in rows with the same inputs, if there are such rows: at least that of rounding.
    pub(super) fn repeatability(&self, data: &Log, readings: &Surveyed) -> Option<f64> {
        if !self.is_whole || !std::ptr::eq(self.log, data) {
            return None;
        }
        let mut last: HashMap<Vec<u64>, f64> = HashMap::new();
        let of_row = |(row, value): (usize, &f64)| {
            // Inputs that are missing are not the same; -0 is 0.
            let bits = |value: f64| value.is_finite().then(|| (value + 0.0).to_bits());
            let inputs: Option<Vec<u64>> =
                self.columns().map(|column| bits(column.values[row])).collect();
            Some(value - last.insert(inputs?, *value)?)
        };
        let pairs = readings.values.iter().enumerate().filter(|(_, value)| value.is_finite());
        let pairs: Vec<f64> = pairs.filter_map(of_row).collect();
        let steps = pairs.iter().map(|pair| pair.abs()).filter(|step| *step > 0.0);
        // Where all of them agree they are rounded to more than their noise.
        let step = steps.reduce(f64::min).unwrap_or_else(|| least_step(&readings.values));
        let rounding = Some(step / 12_f64.sqrt()).filter(|rounding| rounding.is_finite())?;
        let scatter = robust(&pairs)? / std::f64::consts::SQRT_2;
        (pairs.len() >= LEAST_PAIRS).then_some(scatter.max(rounding))
    }
}
