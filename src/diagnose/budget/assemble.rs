//! The answer, put together from what the driver found. It looks for nothing.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnose::fitted::Fitted;
use crate::diagnose::gap::{Steps, gap};
use crate::diagnose::library::prior::Prior;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::finish;
use crate::estimate::contradicted::contradicted;
use crate::estimate::linear_range::{BeyondRange, beyond_range};
use crate::system::Selected;

use super::answer::{Diagnosis, Doubtful, FAR_BEYOND_STATED, Findings, Row, decide};
use super::confounded::confounded;
use super::driver::{Competed, Found};
use super::held_out::Folded;
use super::in_fit::effect_of;
use super::judge::Objection;
use super::linear::Linear;
use super::member::member_uncertainties;
use super::noise_scale::{autocorrelation, levels, scale_noise, scatter, white_scale};
use super::pieces::Pieces;
use super::search::Pools;
use super::selection::{Ranked as RankedTerm, Selection};
use super::solved::{Solved, ratio_to_typical};
use super::stamp_jumps::stamp_jumps;
use super::terms::without;
use crate::diagnose::price::{Gain, ROUNDING, posterior};
use crate::diagnose::thresholds::{ENTER, TIE};

mod candidates;
mod remainder;
mod size;

/// Effects that are compared with a row.
const RIVALS: usize = 8;

impl Diagnosis {
    /// Puts the answer together beside the nominal calibration.
    pub fn of(mut self, found: Found, prior: &Prior, options: &Options) -> Result<Self, FitError> {
        let Found { competed, left_out, noise, unseen, objections, log } = found;
        let Competed { linear, judged, scale } = competed;
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
        selection.adopt_scale(&scale);
        // What did not stand is a rival of a row still, and whole blocks that were reduced beside it.
        let reduced: Vec<_> = linear.terms.iter().filter_map(|term| term.reduced_from).collect();
        for (number, term) in selection.terms.iter_mut().enumerate() {
            if term.is_effect()
                && term.variant.is_none()
                && !judged.model.contains(&number)
                && unseen.has(&term.name)
            {
                term.columns.clear();
            }
            let is_rival = term.is_effect() || term.may_enter || reduced.contains(&number);
            term.may_enter = is_rival && !term.columns.is_empty();
        }
        let budget = Budget::new(&linear, &selection, &judged.model);
        self.left_out.extend(left_out);
        self.noise = noise;
        self.levels = levels(&linear, &scale);
        self.autocorrelation = autocorrelation(&linear.fitted.problem);
        self.log = log;
        let in_fit = selection.rows_of(&linear.rows());
        let stands: Vec<usize> = (0..judged.model.len())
            .filter(|at| {
                in_fit.contains(&judged.model[*at]) && !judged.nameless.contains(&judged.model[*at])
            })
            .collect();
        let rest: Vec<usize> = (0..judged.model.len()).filter(|at| !stands.contains(at)).collect();
        let gains = selection.contributions(&judged.model);
        let parts = budget.parts(&rest);
        // What a block was reduced by may be in the remainder all the same.
        let whole: Vec<usize> = judged.model.iter().map(|term| selection.whole(*term)).collect();
        let solved = Solved::of(&selection, &judged.model, &rest, &gains);
        let mut of_rows = Solved::of(&selection, &whole, &rest, &gains);
        if !stands.is_empty() {
            // Change points that are in the fit are not explained: rows are judged beside them.
            let changes: Vec<usize> =
                linear.rows().into_iter().filter(|row| !in_fit.contains(row)).collect();
            let fitted = [changes.clone(), in_fit.clone()].concat();
            let folded_rows = |cut: Cut| {
                let (folded, pieces) = budget.folded(&fitted, cut);
                (folded.with_nominal_terms(changes.len()), pieces)
            };
            let (mut rows_folded, mut pieces) = folded_rows(Pieces::new);
            let mut folded = budget.folded(&judged.model, Pieces::new).0;
            if !rows_folded.is_shown() {
                (rows_folded, pieces) = folded_rows(Pieces::within_runs);
                folded = budget.folded(&judged.model, Pieces::within_runs).0;
            }
            let mut with_rows = linear.fitted.clone();
            scale_noise(&mut with_rows.problem, &linear, &scale);
            let with_rows = with_rows.again(options)?;
            let of_terms = |terms: &[usize]| -> Vec<Selected> {
                let named = terms.iter().map(|row| &linear.terms[*row].name);
                named.filter_map(|name| effect_of(&with_rows, name).cloned()).collect()
            };
            let selected = of_terms(&in_fit);
            let changes = of_terms(&changes);
            let rows_alone = match changes.as_slice() {
                [] => with_rows.clone(),
                all => with_rows.without(&all.iter().collect::<Vec<_>>(), options)?,
            };
            let steps = Steps::of(&rows_alone, &selected, options)?;
            let degrees = stands.iter().map(|at| gains[*at].degrees).sum();
            let leftover: f64 = parts.iter().sum();
            let drops = rows_folded.drops(&selection, &pieces);
            let gap = gap(&steps, &drops, degrees, leftover);
            let all = (gap.held_out_drop.max(0.0) + leftover).max(f64::MIN_POSITIVE);
            self.gap = Some(gap);
            let members = member_uncertainties(&with_rows, &selected, options)?;
            let Fitted { problem, fit, .. } = with_rows.clone();
            let explained = finish(problem, fit, Vec::new(), Vec::new())?;
            let of_rest = (whole.as_slice(), rest.as_slice(), gains.as_slice());
            let confounded = confounded(&linear, &selection, &mut of_rows, of_rest, &stands);
            for (at, confounded) in stands.iter().zip(confounded) {
                let term = judged.model[*at];
                let name = &linear.terms[term].name;
                // Beside the other rows: what the remainder could take over from it is the row's. Beside
                // the remainder, too, where that hides all of it.
                let row = in_fit.iter().position(|own| *own == term);
                let beside_rows = row.map_or(0.0, |row| rows_folded.squares_drop(row));
                let drop = if beside_rows > 0.0 { beside_rows } else { folded.squares_drop(*at) };
                let closes = (drop.max(0.0) / all).min(1.0);
                let mut values = of_rows.values(&linear, name, *at, &explained);
                let own = || members.iter().filter(|one| one.effect == *name);
                for (instance, share) in own().flat_map(|one| &one.shares) {
                    let own = values.iter_mut().filter(|value| value.instance == Some(*instance));
                    own.for_each(|value| value.sigma = value.sigma.map(|own| own.hypot(*share)));
                }
                self.rows.push(Row {
                    closes,
                    confounded,
                    member_sigma: own().map(|one| (one.family.clone(), one.sigma)).collect(),
                    ratio_to_typical: ratio_to_typical(&linear.fitted.problem, &values),
                    values,
                    ..budget.row(*at, &gains, &folded)
                });
            }
            self.rows.sort_by(|a, b| b.gain.gain.total_cmp(&a.gain.gain));
            self.contradicted = contradicted(&explained);
            self.steps = Some(steps);
            self.explained = Some(explained);
        }
        let last = self.explained.as_ref().unwrap_or(&self.nominal);
        self.beyond_range = beyond_range(&last.problem, &last.estimates());
        self.remainder = budget.remainder((&rest, &parts), &gains, &solved);
        self.remainder.extend(budget.of_inputs());
        // Beside rows, a row may absorb in the fit what a stated value in the remainder does.
        if self.contradicted.is_empty() {
            self.contradicted = contradicted(&self.nominal);
            let is_part = |parameter: &str| {
                self.remainder.iter().any(|one| one.place.is_of_stated(parameter))
            };
            let has_rows = !self.rows.is_empty();
            self.contradicted.retain(|one| !has_rows || is_part(&one.parameter));
        }
        self.doubtful = budget.doubtful(&objections);
        // Another form of it may stand.
        self.doubtful.retain(|one| !self.rows.iter().any(|row| row.name == one.name));
        let doubtful = self.doubtful.iter().flat_map(|one| &one.values);
        self.beyond_range.extend(doubtful.filter_map(|one| {
            let setting = linear.candidates.iter().find_map(|own| own.setting(&one.parameter))?;
            let whose = (one.parameter.as_str(), one.of.as_deref());
            BeyondRange::of(setting, whose, one.value, &one.unit)
        }));
        (self.candidates, self.causes) = budget.candidates(prior);
        self.absorbed = unseen.absorbed;
        self.absorbed.retain(|one| !self.rows.iter().any(|row| row.name == one.name));
        self.not_testable = unseen.not_testable;
        let white = white_scale(&linear, &scale);
        let largest_scale = white.iter().copied().fold(0.0, f64::max);
        if largest_scale > FAR_BEYOND_STATED {
            self.remainder.extend(scatter(&linear, &white));
        }
        self.verdict = decide(Findings {
            rows: self.rows.len(),
            remainder: self.remainder.len(),
            noise: self.noise.len()
                + self.autocorrelation.len()
                + self.levels.iter().filter(|one| one.run.is_some()).count()
                + usize::from(!self.left_out.is_empty()),
            largest_scale,
        });
        Ok(self)
    }
}

/// A model on its sums.
struct Budget<'a> {
    linear: &'a Linear,
    selection: &'a Selection<'a>,
    model: &'a [usize],
    pools: Pools,
    /// What the model takes off chi squared.
    total: f64,
}

/// A way to cut readings into folds.
type Cut = fn(&Linear, &Selection<'_>, &[usize]) -> Pieces;

impl<'a> Budget<'a> {
    fn new(linear: &'a Linear, selection: &'a Selection<'a>, model: &'a [usize]) -> Self {
        let total = selection.chi_squared(&[]) - selection.chi_squared(model);
        Self { linear, selection, model, pools: Pools::of(selection), total }
    }

    /// The sums of some terms by fold.
    fn folded(&self, terms: &[usize], cut: Cut) -> (Folded, Pieces) {
        let pieces = cut(self.linear, self.selection, terms);
        (Folded::new(self.selection, terms, &pieces), pieces)
    }

    /// A row without its values.
    fn row(&self, at: usize, gains: &[Gain], folded: &Folded) -> Row {
        let Self { linear, selection, pools, .. } = self;
        let term = self.model[at];
        let own = &linear.terms[term];
        let rest = without(self.model, term);
        let ln_bayes = selection.ln_bayes_factor(term, gains[at]);
        let tie = TIE.max(ROUNDING * ln_bayes);
        let rivals = selection.ranked(&rest, &pools.effects);
        // An effect in two forms is one rival.
        let mut names: BTreeSet<&str> = BTreeSet::from([own.name.as_str()]);
        let is_new = |one: &RankedTerm| names.insert(&linear.terms[one.term].name);
        let rivals: Vec<_> = rivals.into_iter().filter(is_new).take(RIVALS).collect();
        let aliases: Vec<String> = rivals
            .iter()
            .filter(|one| one.ln_bayes >= ENTER && one.ln_bayes > ln_bayes - tie)
            .map(|one| linear.terms[one.term].name.clone())
            .collect();
        let blocks = selection.ranked(&rest, &pools.blocks);
        // A block of nearly the form of a cause that a user suspects is no other cause.
        let other = |one: &&RankedTerm| !selection.is_nearly_own(self.model, term, one.term);
        let others = rivals.iter().chain(blocks.iter().find(other)).map(|one| one.ln_bayes);
        let selected = effect_of(&linear.fitted, &own.name);
        let alone = selection.gain(&[], term);
        Row {
            name: own.name.clone(),
            variant: own.variant,
            member: selected.map(|one| one.member.clone()).unwrap_or_default(),
            member_sigma: BTreeMap::new(),
            ratio_to_typical: None,
            values: Vec::new(),
            gain: gains[at],
            ln_bayes,
            closes: 0.0,
            alone: (alone.excess() / self.total.max(f64::MIN_POSITIVE)).min(1.0),
            posterior: posterior(ln_bayes, others),
            predictive_gain: folded.predictive_gain(at),
            aliases,
            unmodelled_alias: blocks
                .first()
                .filter(|one| one.ln_bayes > ln_bayes - tie)
                .and_then(|one| Some(linear.terms[one.term].place.as_ref()?.words.clone())),
            confounded: Vec::new(),
            stamp_jumps: stamp_jumps(&linear.fitted.problem, selected),
        }
    }

    /// Effects that did not stand as rows, the last reason of each.
    fn doubtful(&self, objections: &[(String, Objection)]) -> Vec<Doubtful> {
        let Self { linear, selection, .. } = self;
        let mut found: Vec<Doubtful> = Vec::new();
        for (name, objection) in objections.iter().rev() {
            let term = (0..linear.terms.len()).find(|n| linear.terms[*n].name == *name);
            let Some(term) = term.filter(|_| !found.iter().any(|one| one.name == *name)) else {
                continue;
            };
            let rows = without(&selection.rows_of(self.model), term);
            let gain = selection.gain(&rows, term);
            if gain.degrees > 0 {
                found.push(Doubtful {
                    name: name.clone(),
                    gain,
                    objection: objection.clone(),
                    values: linear.sizes(selection, &rows, term),
                });
            }
        }
        found
    }
}
