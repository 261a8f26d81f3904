//! Arguments that commands share.

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
    /// The reference runs with their own delays, else the joint fit
    #[default]
    Best,
    /// The joint fit of all runs
    Joint,
    /// The reference runs as if nothing were delayed, as in the paper; its bias is told
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
    /// State a parameter's value, as in collimation.offset="4 arcsec" (repeat for more)
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(super) set: Vec<String>,
    /// Leave bad rows of data files out, count and list them
    #[arg(long)]
    pub(super) skip_bad_rows: bool,
    /// How the result is written
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: Format,
    /// Write tables into this folder
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// No warnings
    #[arg(long)]
    pub(super) quiet: bool,
    /// Threads to use; the result is the same at any number
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
}

impl CampaignArguments {
    /// Lets the number of threads count.
    pub(super) fn apply_threads(&self) {
        if let Some(threads) = self.threads.filter(|threads| *threads > 0) {
            // Only the first call can set it; one process runs one command.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        }
    }
}
