//! A campaign as it was read: what its file declares, its runs, what was left out, and how to read.

use std::path::PathBuf;

use crate::campaign::calibration::InputSpread;
use crate::campaign::declared::{InputOverride, RunEntry};
use crate::campaign::delay_range::DelayRange;
use crate::campaign::run::Run;
use crate::campaign::specification::Specification;
use crate::campaign::table::Skipped;
use crate::campaign::timing::Timing;
use crate::campaign::timing::replies::RequestToReply;
use crate::diagnostic::{Diagnostic, Source};
use crate::document::entries::Named;
use crate::document::files::Files;
use crate::model::Override;
use crate::progress::Progress;
use crate::units::{DisplayUnits, Unit};

/// The unit in which a column is read.
#[derive(Clone, Debug, PartialEq)]
pub struct HeadUnit {
    /// The model's name.
    pub name: String,
    /// The unit.
    pub unit: Unit,
    /// Whether the header of the file states it.
    pub is_in_header: bool,
}

/// How to read the data.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Leave bad rows out, count and list them.
    pub skip_bad_rows: bool,
    /// The greatest delay to either side (s), over what the campaign says.
    pub delay_range: Option<f64>,
    /// Bytes of memory for the samples of all runs; those that go beyond wait in a temporary file.
    pub memory: u64,
    /// Refuse files outside the campaign's folder, links followed.
    pub confined: bool,
    /// Show in messages what stands in files outside the campaign's folder.
    pub show_outside: bool,
    /// Who is told how far reading has come.
    pub progress: Progress,
}

/// Memory for samples (bytes), unless stated.
pub const MEMORY: u64 = 1_000_000_000;

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            skip_bad_rows: false,
            delay_range: None,
            memory: MEMORY,
            confined: false,
            show_outside: false,
            progress: Progress::default(),
        }
    }
}

/// Samples of a run whose readings are not used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The run.
    pub run: String,
    /// How many samples.
    pub samples: usize,
    /// Why.
    pub why: String,
}

/// A campaign, ready to be explained by its model.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// `title`, else the folder's name.
    pub title: String,
    /// Name of its folder: how it is called where several are used together.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Its campaign.toml.
    pub source: Source,
    /// Name of the model, as written.
    pub model: Named,
    /// Name of the instrument: campaigns of the same one share its parameters.
    pub instrument: Option<String>,
    /// Name of the rig.
    pub rig: Option<String>,
    /// Effects that are part of the nominal model.
    pub effects: Vec<Named>,
    /// Free data, carried into every result (an object).
    pub metadata: serde_json::Value,
    /// Names of the setups, in order of appearance.
    pub setups: Vec<String>,
    /// Runs, in the order written.
    pub runs: Vec<Run>,
    /// What was written of each run, in the same order.
    pub entries: Vec<RunEntry>,
    /// Parameters as overridden; to be applied by name once effects are known.
    pub parameters: Vec<Override>,
    /// What was written of inputs.
    pub inputs: Vec<InputOverride>,
    /// Standard uncertainty (SI) of each input of the model as it scatters from sample to sample,
    /// if known.
    pub input_sigma: Vec<Option<f64>>,
    /// What it is made of, and what calibration leaves open.
    pub input_spread: Vec<InputSpread>,
    /// Standard uncertainty (SI) of one reading of each measurand of the model; 1 for one that the
    /// campaign neither states nor reads.
    pub measurand_sigma: Vec<f64>,
    /// Units of results that it states.
    pub output: DisplayUnits,
    /// What the maker of the instrument promises to follow.
    pub specification: Specification,
    /// Degrees of freedom on which that rests, if few.
    pub measurand_degrees_of_freedom: Vec<Option<f64>>,
    /// Between which delays readings may lie: streams must be there for all of them.
    pub delay_range: DelayRange,
    /// From when the times of samples count (s): more digits of stamps are kept like that.
    pub zero: i64,
    /// How reference times were captured, if the campaign says so.
    pub timing: Option<Timing>,
    /// The time from request to reply in each run that captured it.
    pub request_to_reply: Vec<RequestToReply>,
    /// The units in which columns are read, each once.
    pub head_units: Vec<HeadUnit>,
    /// What the user should look at.
    pub warnings: Vec<Diagnostic>,
    /// Rows left out, of each file the first [`MOST_LISTED`](super::table::MOST_LISTED).
    pub skipped: Vec<Skipped>,
    /// How many in all.
    pub skipped_count: usize,
    /// Samples whose readings are not used.
    pub left_out: Vec<LeftOut>,
    /// What was recognised of the layout of its files, where it is unusual.
    pub recognised: Vec<String>,
    /// The files that were read: whoever writes asks whether one of them would be replaced.
    pub files: Files,
}
