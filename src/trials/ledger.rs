//! The file of finished trials: one JSON object a line, the first of which says of what.
//!
//! A trial is written when it is done, so an interrupted run loses what was being diagnosed and
//! nothing else. A line that is cut off or cannot be read is passed over, and its trial made again.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, Write};
use std::path::Path;

use serde::Serialize;

use crate::campaign::lines::read_bytes;
use crate::document::files::{open_regular, reason};

use super::heading::Heading;
use super::outcome::Outcome;

/// Bytes of a file of trials, unpacked: some hundred thousand trials.
const MOST_BYTES: usize = 1 << 28;

/// Why a file of trials cannot be gone on with.
#[derive(Debug, thiserror::Error)]
pub enum LedgerError {
    /// The disk's.
    #[error(transparent)]
    Disk(#[from] io::Error),
    /// It cannot be read; why, in words.
    #[error("{0}")]
    Unread(String),
    /// It is no file of trials.
    #[error("its first line does not say of what the trials are")]
    NoHeading,
    /// It is of another plan or campaign.
    #[error("it holds trials of another {what}")]
    Other {
        /// What differs.
        what: &'static str,
    },
}

/// A file of trials that is only read.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Of what the trials are.
    pub heading: Heading,
    /// The trials in order, each once: the first line of each counts.
    pub outcomes: Vec<Outcome>,
    /// Numbers of the lines (from 1) that could not be read.
    pub unreadable: Vec<usize>,
}

impl Recorded {
    /// Reads a file, plain or `.gz`.
    ///
    /// # Errors
    /// Where it cannot be read or is no file of trials.
    pub fn read(path: &Path) -> Result<Self, LedgerError> {
        let bytes = open_regular(path).and_then(|file| read_bytes(file, MOST_BYTES));
        let bytes = bytes.map_err(|error| LedgerError::Unread(reason(path, &error)))?;
        if bytes.len() > MOST_BYTES {
            return Err(LedgerError::Unread(format!("it has more than {MOST_BYTES} bytes")));
        }
        let mut lines = bytes.split(|byte| *byte == b'\n').zip(1..);
        let heading = lines.next().and_then(|(line, _)| serde_json::from_slice(line).ok());
        let heading = heading.ok_or(LedgerError::NoHeading)?;
        let (mut outcomes, mut unreadable): (Vec<Outcome>, _) = (Vec::new(), Vec::new());
        for (line, number) in lines.filter(|(line, _)| !line.trim_ascii().is_empty()) {
            match serde_json::from_slice(line) {
                Ok(outcome) => outcomes.push(outcome),
                Err(_) => unreadable.push(number),
            }
        }
        outcomes.sort_by_key(|one| one.trial);
        outcomes.dedup_by_key(|one| one.trial);
        Ok(Self { heading, outcomes, unreadable })
    }
}

/// An open file of trials.
#[derive(Debug)]
pub struct Ledger {
    /// What was in it.
    pub outcomes: Vec<Outcome>,
    /// Lines that could not be read.
    pub unreadable: usize,
    file: File,
}

impl Ledger {
    /// Opens a file, or begins it.
    ///
    /// # Errors
    /// Where it is of something else, and the disk's.
    pub fn open(path: &Path, heading: &Heading) -> Result<Self, LedgerError> {
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        let mut reader = BufReader::new(&file);
        let (mut outcomes, mut unreadable, mut good) = (Vec::new(), 0, 0_u64);
        let mut line = Vec::new();
        loop {
            line.clear();
            let read = reader.read_until(b'\n', &mut line)?;
            // The last line counts only if it is whole.
            if read == 0 || line.last() != Some(&b'\n') {
                break;
            }
            if good == 0 {
                let Ok(found) = serde_json::from_slice::<Heading>(&line) else {
                    return Err(LedgerError::NoHeading);
                };
                if let Some(what) = found.differs_from(heading) {
                    return Err(LedgerError::Other { what });
                }
            } else if let Ok(outcome) = serde_json::from_slice(&line) {
                outcomes.push(outcome);
            } else {
                unreadable += 1;
            }
            good += read as u64;
        }
        // What is no beginning of a heading is somebody's.
        if good == 0 && !line_of(heading)?.starts_with(&line) {
            return Err(LedgerError::NoHeading);
        }
        file.set_len(good)?;
        file.seek(io::SeekFrom::Start(good))?;
        if good == 0 {
            append(&mut file, heading)?;
        }
        Ok(Self { outcomes, unreadable, file })
    }

    /// Writes a trial down.
    ///
    /// # Errors
    /// The disk's.
    pub fn add(&mut self, outcome: &Outcome) -> io::Result<()> {
        append(&mut self.file, outcome)
    }
}

/// A line at once: whatever interrupts, at most the last one is cut off.
fn append(file: &mut File, what: &impl Serialize) -> io::Result<()> {
    file.write_all(&line_of(what)?)
}

fn line_of(what: &impl Serialize) -> io::Result<Vec<u8>> {
    let mut line = serde_json::to_vec(what)?;
    line.push(b'\n');
    Ok(line)
}
