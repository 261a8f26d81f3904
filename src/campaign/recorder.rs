//! Takes the samples of runs in their order and keeps them: in memory while the budget lasts, else
//! in a temporary file.
//!
//! On the way it puts the nearest earlier (else later) value where a captured one is missing: the
//! readings of such samples are left out, but an engine still evaluates them.

use std::io;
use std::sync::OnceLock;

use crate::campaign::record::Record;
use crate::campaign::samples::{Samples, shape};
use crate::campaign::signal::Track;
use crate::campaign::spill::{BLOCK, Spill, Table};
use crate::campaign::spilled::Spilled;
use crate::campaign::stamps;
use crate::campaign::uniform::Uniform;

/// Memory and, where that does not suffice, disk for the records of several runs.
#[derive(Debug)]
pub struct Store {
    /// Bytes that may still be held.
    memory: u64,
    spill: Option<Spill>,
    /// From when the stamps of all files count (s), once the first one is known.
    zero: Option<i64>,
}

impl Store {
    /// A store that holds at most so many bytes in memory.
    pub fn new(memory: u64) -> Self {
        Self { memory, spill: None, zero: None }
    }

    /// From when stamps count (s), where the first one is this.
    pub(crate) fn zero(&mut self, first: Option<f64>) -> i64 {
        match (self.zero, first) {
            (Some(zero), _) => zero,
            (None, Some(first)) => *self.zero.insert(stamps::zero(first)),
            (None, None) => 0,
        }
    }

    fn spill(&mut self) -> io::Result<&mut Spill> {
        if self.spill.is_none() {
            self.spill = Some(Spill::new()?);
        }
        self.spill.as_mut().ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

/// One run being recorded.
#[derive(Debug)]
pub struct Recorder {
    /// Samples that are not written: all, or those of the block at hand.
    pending: Samples,
    table: Option<Table>,
    first_time: f64,
    /// For each captured column, its first value and its latest.
    lead: Vec<f64>,
    last: Vec<f64>,
    inputs: Vec<Track>,
    readings: usize,
}

impl Recorder {
    /// A run without samples yet. `inputs` say where each input comes from, by tracks whose columns
    /// are not looked at; `readings` is the number of reading columns.
    pub fn new(inputs: &[Track], readings: usize) -> Self {
        let mut pending = Samples::default();
        shape(&mut pending, inputs, readings);
        let captured = pending.columns().count() - 1 - readings;
        Self {
            pending,
            table: None,
            first_time: 0.0,
            lead: vec![f64::NAN; captured],
            last: vec![f64::NAN; captured],
            inputs: inputs.iter().map(Track::without_values).collect(),
            readings,
        }
    }

    /// Adds samples of the same shape: times, captured columns, readings and rows. Other clocks are
    /// not looked at.
    ///
    /// # Errors
    /// The disk's.
    pub fn push(&mut self, store: &mut Store, samples: &Samples) -> io::Result<()> {
        if let (Some(first), true) = (samples.time.first(), self.is_empty()) {
            self.first_time = *first;
        }
        self.pending.is_untimed = samples.is_untimed;
        let from = self.pending.len();
        for (to, from) in self.pending.columns_mut().zip(samples.columns()) {
            to.extend_from_slice(from);
        }
        self.pending.rows.extend_from_slice(&samples.rows);
        let captured = self.pending.columns_mut().skip(1);
        for (column, (lead, last)) in captured.zip(self.lead.iter_mut().zip(&mut self.last)) {
            for value in &mut column[from..] {
                if value.is_nan() {
                    *value = *last;
                } else {
                    if last.is_nan() {
                        *lead = *value;
                    }
                    *last = *value;
                }
            }
        }
        if self.table.is_none() && self.pending.bytes() > store.memory {
            let columns = self.pending.columns().count() + 1;
            self.table = Some(store.spill()?.table(columns));
        }
        if self.table.is_some() && self.pending.len() >= BLOCK {
            self.write(store, BLOCK)?;
        }
        Ok(())
    }

    fn is_empty(&self) -> bool {
        self.table.is_none() && self.pending.is_empty()
    }

    /// Writes what is pending, as long as it makes blocks of `least` samples at least.
    fn write(&mut self, store: &mut Store, least: usize) -> io::Result<()> {
        let Some(table) = &mut self.table else { return Ok(()) };
        let mut done = 0;
        while self.pending.len() - done >= least.max(1) {
            let block = done..self.pending.len().min(done + BLOCK);
            let rows: Vec<f64> =
                self.pending.rows[block.clone()].iter().map(|row| *row as f64).collect();
            let columns = self.pending.columns().map(|column| &column[block.clone()]);
            let columns = columns.chain(std::iter::once(rows.as_slice()));
            store.spill()?.append(table, columns, block.len())?;
            done = block.end;
        }
        for column in self.pending.columns_mut() {
            column.drain(..done);
            column.shrink_to(2 * BLOCK);
        }
        self.pending.rows.drain(..done);
        self.pending.rows.shrink_to(2 * BLOCK);
        Ok(())
    }

    /// The run's record.
    ///
    /// # Errors
    /// The disk's.
    pub fn finish(mut self, store: &mut Store) -> io::Result<Record> {
        self.write(store, 1)?;
        for lead in self.lead.iter_mut().filter(|lead| lead.is_nan()) {
            *lead = 0.0;
        }
        let Some(table) = self.table else {
            let mut samples = self.pending;
            for (column, lead) in samples.columns_mut().skip(1).zip(&self.lead) {
                column.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = *lead);
            }
            samples.columns_mut().for_each(Vec::shrink_to_fit);
            samples.set_clocks();
            store.memory = store.memory.saturating_sub(samples.bytes());
            return Ok(Record::held(samples));
        };
        let mut spilled = Spilled {
            table,
            inputs: self.inputs,
            readings: self.readings,
            lead: self.lead,
            first_time: self.first_time,
            is_untimed: self.pending.is_untimed,
            uniform: Uniform::default(),
            fault: OnceLock::new(),
        };
        spilled.uniform = Uniform::through(spilled.table.len(), |visit| {
            spilled.each_time(&mut |time| visit(time - self.first_time));
        });
        match spilled.fault.get() {
            Some(why) => Err(io::Error::other(why.clone())),
            None => Ok(Record::spilled(spilled)),
        }
    }
}
