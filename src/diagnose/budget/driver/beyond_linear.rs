//! Effects that at their usual size move readings so far that the slope at zero says nothing, such
//! as a clock that was set by seconds. Where residuals are far beyond what is stated they are fitted
//! from their usual values; one that takes off nearly all of chi squared enters the nominal fit, and
//! the search begins anew: what was found beside so wrong a model is worth nothing.

use crate::diagnose::budget::answer::FAR_BEYOND_STATED;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::Term;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::relaxed::Variants;
use crate::diagnose::library::wanted::Wanted;
use crate::estimate::batch::FitError;

use super::{Competed, Search};

/// Part of chi squared, in units of the noise, that an effect of the usual size has at least.
const LEAST: f64 = 0.1;
/// Part of chi squared that it leaves at most.
const LEAVES: f64 = 0.1;

impl Search<'_> {
    /// Lets the best of them enter; whether there is one.
    pub(super) fn take_beyond_linear(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let Competed { linear, judged, scale } = competed;
        if scale.iter().all(|one| *one <= FAR_BEYOND_STATED) {
            return Ok(false);
        }
        let selection = self.selection_of(competed);
        let chi_squared = selection.chi_squared(&judged.model);
        let mut best: Option<(usize, Fitted)> = None;
        for (term, own) in linear.terms.iter().enumerate() {
            let is_open = own.is_effect() && selection.live[term] && own.variant.is_none();
            let is_in_fit = self.rows.iter().any(|row| row.name == own.name);
            if !is_open || is_in_fit || usual_length(own, &selection) < LEAST * chi_squared {
                continue;
            }
            let plain = &linear.candidates[own.candidate].selected;
            for later in starts_of_delays(&self.nominal) {
                let nominal = &self.nominal;
                let with = self.fit_from_usual_values(nominal, plain, None, later)?;
                let Some(with) = with else { continue };
                let all = nominal.fit.cost;
                let least = best.as_ref().map_or(LEAVES * all, |best| best.1.fit.cost);
                if with.fit.cost < least && linear.is_plausible(&with, term) {
                    best = Some((term, with));
                }
            }
        }
        let Some((term, fitted)) = best else { return Ok(false) };
        let mut log = std::mem::take(&mut self.log);
        log.push(format!("{} enters the fit from its usual values", linear.terms[term].name));
        let wanted = Wanted { variants: Variants::default(), ..self.wanted.clone() };
        let anew = Search::new(self.nominal.clone(), &wanted, self.options);
        *self = Search { fitted, rows: vec![linear.row(term)], log, ..anew };
        self.grow()
    }
}

/// Squared length of an effect's columns at its usual size, in units of the noise.
fn usual_length(own: &Term, selection: &Selection<'_>) -> f64 {
    let of = |column: &Vec<(usize, f64)>| {
        let usual = column.first().and_then(|(at, _)| selection.sums.typical_of(*at));
        usual.map_or(0.0, |usual| usual * usual * selection.square(column))
    };
    own.columns.iter().map(of).sum()
}

/// By how much later delays begin (s): the fit holds for stamps before a jump or for those after it.
fn starts_of_delays(fitted: &Fitted) -> Vec<f64> {
    let runs = fitted.problem.parts.iter().flat_map(|part| &part.runs);
    let first = runs.filter_map(|run| run.record.head(1).jump_time.first().copied());
    let mut starts: Vec<f64> = std::iter::once(0.0).chain(first.take(1)).collect();
    starts.dedup();
    starts
}
