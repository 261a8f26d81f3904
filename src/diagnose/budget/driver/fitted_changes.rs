//! Large change points, such as a clock that was set by seconds or a knock of centimetres: beside them
//! the model is not linear, and what they leave looks like other structure. They enter the fit, with
//! the moment that was found. They are no rows: no effect of the library explains them.

use crate::diagnose::budget::in_fit::{Row, columns_of};
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::{Change, Term};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::place::Place;
use crate::diagnose::library::windowed::{FROM, NEVER, SIZES, UNTIL, windowed};
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::LARGE_CHANGE;
use crate::engine::layout::Instance;
use crate::estimate::batch::FitError;

use super::Search;

/// Changes in the fit at most.
const MOST: usize = 4;

impl Search<'_> {
    /// Lets the large changes of a model enter the fit; whether there were such.
    pub(super) fn take_changes(
        &mut self,
        linear: &Linear,
        selection: &Selection<'_>,
        model: &[usize],
    ) -> Result<bool, FitError> {
        let values = selection.values(model);
        let values = values.as_slice();
        let mut large: Vec<(Gain, &Term, &Change, &[f64])> = model
            .iter()
            .zip(selection.contributions(model))
            .zip(selection.ranges(model))
            .filter_map(|((term, gain), range)| {
                let own = &selection.terms[*term];
                let change = own.appended().filter(|_| !own.is_form_in_run())?;
                Some((gain, own, change, &values[range]))
            })
            .filter(|(gain, ..)| gain.gain >= LARGE_CHANGE)
            .collect();
        large.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
        let mut is_taken = false;
        for (_, own, change, sizes) in large {
            let Some(place) = &own.place else { continue };
            if self.tried_changes.len() < MOST && self.fit_change(linear, change, place, sizes)? {
                self.log.push(format!("{} enters the fit", own.name));
                is_taken = true;
            }
        }
        Ok(is_taken)
    }

    /// Lets a change enter the fit from its values, if that is sound and better and was not tried before;
    /// whether it is.
    pub(super) fn fit_change(
        &mut self,
        linear: &Linear,
        change: &Change,
        place: &Place,
        values: &[f64],
    ) -> Result<bool, FitError> {
        let block = &linear.candidates[change.base.candidate];
        let tried = (block.name.clone(), change.at, change.end);
        if self.tried_changes.contains(&tried) {
            return Ok(false);
        }
        self.tried_changes.push(tried);
        let name = format!("unknown_change_{}", self.tried_changes.len());
        let Some(with) = self.with_change(linear, change, &name, values)? else { return Ok(false) };
        let (members, change) = (change.members, Some((change.clone(), place.clone())));
        self.rows.push(Row { name, variant: None, members, ln_prior: 0.0, change });
        self.fitted = with;
        Ok(true)
    }

    /// The fit with a change, if that is sound and better.
    fn with_change(
        &self,
        linear: &Linear,
        change: &Change,
        name: &str,
        values: &[f64],
    ) -> Result<Option<Fitted>, FitError> {
        let block = &linear.candidates[change.base.candidate].selected.effect;
        let own = change.base.signature..change.base.signature + change.width;
        let Some(selected) = windowed(block, own, name) else { return Ok(None) };
        let names = self.fitted.problem.run_names();
        let acts = |run: &str| -> [f64; 2] {
            let Some(run) = names.iter().position(|own| own == run) else { return [NEVER; 2] };
            let first = if run == change.at.0 { change.at.1 } else { 0 };
            let last = change.end.map_or(NEVER, |end| end as f64);
            if linear.acts(change, (run, first)) { [first as f64, last] } else { [NEVER; 2] }
        };
        let start = |one: &Instance, _| {
            let (effect, local) = one.name.rsplit_once('.')?;
            let of_run = |at: usize| one.whose().map(|run| acts(run)[at]);
            match local {
                _ if effect != name => None,
                FROM => of_run(0),
                UNTIL => of_run(1),
                size => values.get(SIZES.iter().position(|own| *own == size)?).copied(),
            }
        };
        let with = self.fitted.with_starts(&selected, start, self.options)?;
        // Campaigns of several rigs have values of their own each.
        let is_better = |with: &Fitted| {
            let is_one = columns_of(with, name).len() == change.width;
            is_one && with.is_sound() && with.fit.cost < self.fitted.fit.cost
        };
        Ok(with.filter(is_better))
    }
}
