//! Where unknown structure sits: what is wrong, as a function of what, and the phrase that says so.

/// The covariate of a block with a value for each run.
pub(super) const RUN: &str = "run";
/// What the channel of a timing error is called before whose it is, and all readings there.
pub(super) const TIME_OF: &str = "time of ";
pub(in crate::diagnose) const ALL_READINGS: &str = "all readings";
/// What the channel of another value of a parameter is called before its name.
pub(super) const OF_PARAMETER: &str = "parameter ";
/// What has no parameter of its own: where the instrument stands and how it is turned.
pub(super) const POSE: &str = "pose of the instrument";
/// The covariate of a block with a value for each setup.
pub(super) const SETUP: &str = "setup";
/// The covariate of what a setup does in its course.
pub(super) const TIME: &str = "time";
/// The channel of stated values.
const STATED: &str = "stated values";
/// The covariate of what is too small for a name.
const SMALL: &str = "small";
/// The same of what a search takes in and out by turns.
const UNSETTLED: &str = "unsettled";
/// The covariate of a wave in time with phases of each run's own.
pub(super) const OSCILLATION: &str = "oscillation";

/// Where unknown structure sits.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The measurand whose reading or time is wrong, or the channel (`target tangential`).
    pub of: Of,
    /// What it is a function of.
    pub covariate: String,
    /// Where it is waves over a turn, a cosine and a sine of each order, how many orders.
    pub orders: usize,
    /// A phrase; `{member}` stands for the member of a family.
    pub words: String,
    /// The run that it is in, where it is in one alone.
    pub run: Option<String>,
    /// Rows of that run's data file: the first, and the last where it does not go on to the end.
    pub rows: Option<(usize, Option<usize>)>,
}

/// How much of a campaign, by a run of it and rows of its file.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnose) enum Extent {
    /// The run.
    Run,
    /// It and the later ones.
    FromRun,
    /// From a row of it on, with the later runs.
    From(usize),
    /// Of it, from a row to another.
    Rows(usize, usize),
    /// From this row of a run to its last.
    ToItsEnd(usize, usize),
}

impl Place {
    /// Whether it is that of an effect that is no row.
    pub fn is_effect(&self) -> bool {
        [SMALL, UNSETTLED].contains(&self.covariate.as_str())
    }

    /// Of all runs.
    pub(in crate::diagnose) fn new(of: Of, covariate: &str, words: String) -> Self {
        Self { of, covariate: covariate.to_owned(), orders: 0, words, run: None, rows: None }
    }

    /// Of a term with the form of an effect that is no row: too small for one, or in turn with another one.
    pub(in crate::diagnose) fn like(effect: &str, is_small: bool) -> Self {
        let (covariate, why) = match is_small {
            true => (SMALL, "too small for a name"),
            false => (UNSETTLED, "on which the search did not settle"),
        };
        Self::new(Of::Channel(effect.to_owned()), covariate, format!("`{effect}`, {why}"))
    }

    /// The same in a run or from there on.
    pub(in crate::diagnose) fn within(&self, run: &str, extent: Extent) -> Self {
        let words = self.words.trim_end_matches(" over run");
        let (when, rows) = match extent {
            Extent::Run => (format!("in run `{run}`"), None),
            Extent::FromRun => (format!("from run `{run}` on"), None),
            Extent::From(row) => {
                (format!("that changes in run `{run}` at row {row}"), Some((row, None)))
            }
            Extent::Rows(row, last) => {
                (format!("in run `{run}` from row {row} to row {last}"), Some((row, Some(last))))
            }
            Extent::ToItsEnd(row, last) => {
                (format!("in run `{run}` from row {row} to its end"), Some((row, Some(last))))
            }
        };
        Self { words: format!("{words} {when}"), run: Some(run.to_owned()), rows, ..self.clone() }
    }

    /// The same in a campaign of one setup, where a value for each setup is a constant.
    pub(in crate::diagnose) fn in_one_setup(&self) -> Self {
        let whole = self.words.strip_suffix(" over setup").filter(|_| self.covariate == SETUP);
        let what = whole.and_then(|words| words.strip_prefix("an ").or(words.strip_prefix("a ")));
        let words = what.map_or_else(|| self.words.clone(), |what| format!("a constant {what}"));
        Self { words, ..self.clone() }
    }

    /// Whether it is a value for each run.
    pub fn is_of_runs(&self) -> bool {
        self.covariate == RUN
    }

    /// Whether it is an error of a reading over that reading.
    pub(in crate::diagnose) fn is_over_itself(&self) -> bool {
        matches!(&self.of, Of::Measurand(name) if self.covariate.contains(name.as_str()))
    }

    /// Whose readings have another delay in each run: a measurand, or all readings.
    pub fn delayed_by_run(&self) -> Option<&str> {
        let Of::Channel(channel) = &self.of else { return None };
        channel.strip_prefix(TIME_OF).filter(|_| self.is_of_runs() && self.run.is_none())
    }

    /// Whether it is another value of a parameter of the model.
    pub(in crate::diagnose) fn is_of_a_parameter(&self) -> bool {
        self.parameter().is_some()
    }

    /// The parameter of which it is another value, without the component.
    pub(in crate::diagnose) fn parameter(&self) -> Option<&str> {
        self.component().map(|(name, _)| name)
    }

    /// The same with the component of a vector or a rotation.
    pub(in crate::diagnose) fn component(&self) -> Option<(&str, Option<usize>)> {
        let Of::Channel(channel) = &self.of else { return None };
        let name = channel.strip_prefix(OF_PARAMETER)?;
        let axes = [".x", ".y", ".z", " x", " y", " z"];
        let of_axis =
            |(number, axis): (usize, &&str)| Some((name.strip_suffix(*axis)?, Some(number % 3)));
        Some(axes.iter().enumerate().find_map(of_axis).unwrap_or((name, None)))
    }

    /// Whether an effect may have its form: not that of a stated value, nor of a term that is no row.
    pub fn is_of_an_effect(&self) -> bool {
        !self.is_effect() && self.stated().is_none()
    }

    /// Whether it is a wave in time.
    pub fn is_oscillation(&self) -> bool {
        self.covariate == OSCILLATION
    }

    /// Whether it is a function of the time of a setup.
    pub(in crate::diagnose) fn is_over_time(&self) -> bool {
        self.covariate == TIME
    }

    /// Of a parameter whose stated value the readings contradict.
    pub(in crate::diagnose) fn of_stated(parameter: &str, of: Option<&str>) -> Self {
        let of = of.map_or_else(String::new, |of| format!(" of `{of}`"));
        let words = format!("a wrong stated value of `{parameter}`{of}");
        Self::new(Of::Channel(STATED.to_owned()), parameter, words)
    }

    /// The parameter whose stated value it is.
    pub fn stated(&self) -> Option<&str> {
        (self.of == Of::Channel(STATED.to_owned())).then_some(self.covariate.as_str())
    }

    /// Whether it is the stated value of a parameter.
    pub(in crate::diagnose) fn is_of_stated(&self, parameter: &str) -> bool {
        self.stated() == Some(parameter)
    }

    /// Of a reading whose error depends on several inputs together, or on one in a form of no block.
    pub(in crate::diagnose) fn of_inputs(measurand: &str, only: Option<&str>) -> Self {
        let over = only.unwrap_or("several inputs together");
        let words = format!("an error of `{measurand}` over {over}");
        Self::new(Of::Measurand(measurand.to_owned()), "inputs", words)
    }

    /// Of a family, with the member that was found.
    pub fn at(&self, member: f64) -> Self {
        let digits = (2.0 - member.abs().log10().floor()).clamp(0.0, 6.0) as usize;
        let mut text = format!("{member:.digits$}");
        if digits > 0 {
            text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
        }
        let words = match text.as_str() {
            "1" => self.words.replace("{member} waves", "{member} wave"),
            _ => self.words.clone(),
        };
        Self { words: words.replace("{member}", &text), ..self.clone() }
    }
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum Of {
    /// The reading of a measurand.
    Measurand(String),
    /// A part of the rig, or the time of a reading.
    Channel(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_the_same_in_the_only_setup_is_constant() {
        let words = |covariate: &str, words: &str| {
            let of = Of::Measurand("x".to_owned());
            Place::new(of, covariate, words.to_owned()).in_one_setup().words
        };
        assert_eq!(words(SETUP, "an error of `x` over setup"), "a constant error of `x`");
        let displacement = "a radial displacement of the target over setup";
        let constant = "a constant radial displacement of the target";
        assert_eq!(words(SETUP, displacement), constant);
        assert_eq!(words(RUN, "an error of `x` over run"), "an error of `x` over run");
    }

    #[test]
    fn a_member_has_its_number() {
        let of = Of::Measurand("x".to_owned());
        let place = Place::new(of, "c", "over c, {member} waves a turn".to_owned());
        assert_eq!(place.at(2.0).words, "over c, 2 waves a turn");
        assert_eq!(place.at(1.0).words, "over c, 1 wave a turn");
        assert_eq!(place.at(0.5).words, "over c, 0.5 waves a turn");
    }

    #[test]
    fn an_extent_has_its_words_and_rows() {
        let of = Of::Measurand("x".to_owned());
        let place = Place::new(of, RUN, "an error of `x` over run".to_owned());
        let at = |extent| {
            let found = place.within("b", extent);
            (found.words, found.rows)
        };
        let due = |words: &str, rows| (format!("an error of `x` {words}"), rows);
        assert_eq!(at(Extent::Run), due("in run `b`", None));
        assert_eq!(at(Extent::FromRun), due("from run `b` on", None));
        let from = due("that changes in run `b` at row 7", Some((7, None)));
        assert_eq!(at(Extent::From(7)), from);
        let rows = due("in run `b` from row 7 to row 9", Some((7, Some(9))));
        assert_eq!(at(Extent::Rows(7, 9)), rows);
    }
}
