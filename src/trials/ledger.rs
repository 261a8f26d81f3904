//! The file of finished trials: one JSON object a line, the first of which says of what.
//!
//! A trial is written when it is done, so an interrupted run loses what was being diagnosed and
//! nothing else. A line that is cut off or cannot be read is passed over, and its trial made again.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::design::Design;
use super::outcome::Outcome;
use super::plan::Plan;

/// Of what the trials of a file are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heading {
    /// Seed of the plan.
    pub seed: u64,
    /// The plan's strata.
    pub plan: String,
    /// Models, times, inputs, noise, effects and truth of the campaign.
    pub design: String,
    /// Version of the program that diagnosed.
    #[serde(default)]
    pub version: String,
}

impl Heading {
    /// Of a plan on a design.
    pub fn of(plan: &Plan, design: &Design) -> Self {
        let stratum = |one: &super::plan::Stratum| {
            format!("{} {:?} {:.4}", one.kind.word(), one.size, one.weight)
        };
        let strata: Vec<String> = plan.strata.iter().map(stratum).collect();
        Self {
            seed: plan.seed,
            plan: strata.join("; "),
            design: format!("{:016x}", design.stamp()),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

/// Why a file of trials cannot be gone on with.
#[derive(Debug, thiserror::Error)]
pub enum LedgerError {
    /// The disk's.
    #[error(transparent)]
    Disk(#[from] io::Error),
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
                match serde_json::from_slice::<Heading>(&line) {
                    Ok(found) => same(&found, heading)?,
                    Err(_) => return Err(LedgerError::NoHeading),
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

fn same(found: &Heading, wanted: &Heading) -> Result<(), LedgerError> {
    let other = |what| Err(LedgerError::Other { what });
    if found.seed != wanted.seed {
        return other("seed");
    }
    if found.version != wanted.version {
        return other("version of homepoint");
    }
    if found.design != wanted.design {
        return other("campaign or library");
    }
    if found.plan != wanted.plan {
        return other("plan");
    }
    Ok(())
}
