//! Arguments that commands share.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::estimate::transformation::Choice;

/// How results are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Tables and sentences.
    #[default]
    Text,
    /// The keys of docs/formats.md, section 6.
    Json,
}

/// Where the transformation is from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum TransformationChoice {
    /// The reference runs with a delay of each reading, else the joint fit
    #[default]
    Best,
    /// The joint fit of all runs
    Joint,
    /// The reference runs as if nothing were delayed, as in the paper; its bias is reported
    Paper,
    /// The paper's way in turn with the delays, until both agree
    Iterated,
}

impl From<TransformationChoice> for Choice {
    fn from(choice: TransformationChoice) -> Self {
        match choice {
            TransformationChoice::Best => Self::Best,
            TransformationChoice::Joint => Self::Joint,
            TransformationChoice::Paper => Self::Paper,
            TransformationChoice::Iterated => Self::Iterated,
        }
    }
}

/// How much memory a command may take.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct Memory {
    /// Memory to use, about: what does not fit waits in a temporary file (in TMPDIR), and the
    /// result is the same
    #[arg(long, value_name = "SIZE", default_value = "2GB", value_parser = bytes)]
    memory: u64,
}

impl Memory {
    /// A third of it is for samples; the rest for what is made of those that are held.
    pub(super) fn for_samples(self) -> u64 {
        self.memory / 3
    }
}

/// A size below this (bytes) lacks its unit.
const LEAST_MEMORY: f64 = 1e6;

/// Reads `500MB`, `2 GB`, `1.5GiB`, `1000000`.
fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let unit = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(unit);
    let factor = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "kb" => 1e3,
        "mb" => 1e6,
        "gb" => 1e9,
        "tb" => 1e12,
        "kib" => 1024.0,
        "mib" => 1_048_576.0,
        "gib" => 1_073_741_824.0,
        "tib" => 1_099_511_627_776.0,
        _ => return Err(format!("`{unit}` is no unit of memory: use kB, MB, GB or kiB, MiB, GiB")),
    };
    match number.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number * factor < LEAST_MEMORY => {
            Err("no command works in less than 1MB: expected a size such as 500MB or 2GB"
                .to_owned())
        }
        Ok(number) if number > 0.0 && (number * factor).is_finite() => Ok((number * factor) as u64),
        _ => Err("expected a size such as 500MB or 2GB".to_owned()),
    }
}

/// Reads a number of threads.
fn count(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "expected a whole number, 1 or more".to_owned())
}

/// What a command works on, and how.
#[derive(Debug, Args)]
pub(super) struct CampaignArguments {
    /// Campaigns: folders with campaign.toml, or the files themselves
    #[arg(required = true, value_name = "CAMPAIGN")]
    pub(super) campaigns: Vec<PathBuf>,
    /// Add an effect to the model (repeat for more)
    #[arg(long = "with", value_name = "EFFECT")]
    pub(super) with: Vec<String>,
    /// Look for effects in this folder, too (repeat for more)
    #[arg(long = "effects", value_name = "DIR")]
    pub(super) effects: Vec<PathBuf>,
    /// Fix a parameter at a value, as in lever.z="10 mm" or collimation.offset="4 arcsec";
    /// NAME=VALUE~SIGMA states it with a standard uncertainty, NAME@SETUP=VALUE in one setup
    /// (repeat for more)
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(super) set: Vec<String>,
    /// Start the estimate of a parameter there, as in camera.delay="-40 ms" (repeat for more)
    #[arg(long = "start", value_name = "NAME=VALUE")]
    pub(super) start: Vec<String>,
    /// Leave bad rows of data files out, count and list them
    #[arg(long)]
    pub(super) skip_bad_rows: bool,
    /// Leave the readings out that this table lists, as `diagnose --out DIR` writes it into
    /// DIR/left_out.csv (repeat for more)
    #[arg(long, value_name = "FILE")]
    pub(super) leave_out: Vec<PathBuf>,
    /// Read no file outside a campaign's folder: for campaigns of strangers
    #[arg(long)]
    pub(super) confined: bool,
    /// Show in messages what stands in files outside a campaign's folder, too
    #[arg(long, conflicts_with = "confined")]
    pub(super) show_outside: bool,
    /// How the result is written
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: Format,
    /// Write tables into this folder
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// No warnings, no progress
    #[arg(long)]
    pub(super) quiet: bool,
    /// Threads to use, at most four for each processor; the result is the same at any number
    #[arg(long, value_name = "N", value_parser = count)]
    pub(super) threads: Option<NonZeroUsize>,
    #[command(flatten)]
    pub(super) memory: Memory,
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn sizes_are_read_as_people_write_them() {
        assert_eq!(bytes("500MB"), Ok(500_000_000));
        assert_eq!(bytes(" 1.5 GiB"), Ok(1_610_612_736));
        assert_eq!(bytes("5000000"), Ok(5_000_000));
        for wrong in ["", "MB", "-1GB", "5 m", "1e999GB", "nan", "2 GB of it", "5", "4096"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }
}
