//! What is wanted of the columns of a file: by which name, in which unit, and what a campaign states of
//! it.

use crate::campaign::formats::Role;
use crate::formula::Formula;
use crate::units::Unit;

/// The column that must be there in every row and must not run backwards.
pub const TIME: &str = "time";
/// What a column is that is added to the time.
pub(crate) const ADDED: &str = "added to the time";

/// What to do about a column that is two things.
pub(crate) const ONE_COLUMN: &str =
    "a column is one input, one measurand or part of the time: keep the entry that it is";

/// A column of a file, as a campaign names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// By its name; in a file without a header digits mean its number.
    Name(String),
    /// By its number, from 1.
    Number(usize),
}

/// What a campaign states of a wanted column.
#[derive(Clone, Debug, Default)]
pub struct Stated {
    /// Which column it is.
    pub column: Option<Choice>,
    /// Its unit.
    pub unit: Option<Unit>,
    /// What it is computed from, if no column is called like the formula.
    pub formula: Option<Formula>,
    /// What the campaign states of columns that the formula names.
    pub sources: Vec<(String, Stated)>,
    /// Further columns, which are added.
    pub added: Vec<Stated>,
}

/// A column that somebody needs.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// What the model calls it.
    pub name: String,
    /// What the campaign states of it.
    pub stated: Stated,
    /// A unit it may be written in.
    pub unit: Unit,
    /// What formats call it.
    pub role: Option<Role>,
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Name(name) => f.write_str(name),
            Self::Number(number) => number.fmt(f),
        }
    }
}
