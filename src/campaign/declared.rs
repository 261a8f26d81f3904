//! What campaign.toml declares of inputs, measurands and runs, before any model is known.

use crate::campaign::form::Form;
use crate::campaign::header::Choice;
use crate::campaign::plan::Leg;
use crate::campaign::run::Role;
use crate::campaign::timing::RunTiming;
use crate::document::entries::{Entry, Item, Named, Quantity};
use crate::formula::Formula;
use crate::units::Unit;

/// What a campaign says of an input: over what the model says.
#[derive(Clone, Debug)]
pub struct InputOverride {
    /// The input's name.
    pub name: Named,
    /// Standard uncertainty of one value, new in every sample.
    pub sigma: Option<Item>,
    /// Resolution.
    pub resolution: Option<Item>,
    /// Its calibration.
    pub calibration: Option<Item>,
    /// Time constant of the smoothing of its stream.
    pub smooth: Option<Item>,
    /// Period by which recorded values jump.
    pub period: Option<Item>,
}

/// What a campaign says of a measurand.
#[derive(Clone, Debug)]
pub struct MeasurandOverride {
    /// The measurand's name.
    pub name: Named,
    /// Standard uncertainty of one reading, see [`crate::campaign::statement`].
    pub said: Vec<Entry>,
    /// The same as a formula.
    pub sigma: Option<Formula>,
}

/// One entry of `columns`: the model's name, and what the file calls it.
#[derive(Clone, Debug)]
pub struct ColumnWord {
    /// The model's name.
    pub name: Named,
    /// As written: `tool_x [m]`.
    pub written: serde_json::Value,
    /// The column of the file, if it says which.
    pub column: Option<Choice>,
    /// Unit, if it says one.
    pub unit: Option<Unit>,
    /// A formula over columns of a file, if it is one and no column is called so.
    pub formula: Option<Formula>,
    /// Further columns, which are added: of the time alone.
    pub added: Vec<(Choice, Option<Unit>)>,
}

impl ColumnWord {
    /// The columns of the file that it names.
    pub(crate) fn columns(&self) -> impl Iterator<Item = &Choice> {
        self.column.iter().chain(self.added.iter().map(|(column, _)| column))
    }
}

/// A file of a run.
#[derive(Clone, Debug)]
pub struct TableEntry {
    /// Its name.
    pub name: Named,
    /// What is stated of its form.
    pub form: Form,
    /// What it calls inputs and measurands, over what the run says.
    pub columns: Vec<ColumnWord>,
    /// What is stated of it beside its name, as written.
    pub written: serde_json::Map<String, serde_json::Value>,
}

/// One `[[runs]]` entry.
#[derive(Clone, Debug)]
pub struct RunEntry {
    /// Its name.
    pub name: Named,
    /// Its setup.
    pub setup: String,
    /// What it is for.
    pub role: Role,
    /// Its data file.
    pub data: Option<TableEntry>,
    /// Its streams.
    pub signals: Vec<TableEntry>,
    /// What files call inputs and measurands.
    pub columns: Vec<ColumnWord>,
    /// Constants of the run.
    pub inputs: Vec<(Named, Quantity)>,
    /// How it will be measured; empty for a run with data.
    pub plan: Vec<Leg>,
    /// What it says of its captures.
    pub timing: RunTiming,
}
