//! The driver: effects enter one after the other, each with a nonlinear refit and a new
//! linearisation; then basis blocks and change points compete with them, rows are judged, and the
//! noise is looked at in what all of that leaves. What is found in the noise, and rows that did not
//! stand, lead to another round.

use crate::diagnose::evidence::scan::Scanned;
use crate::diagnose::fitted::{Fitted, name_of};
use crate::diagnose::found::{LeftOut, NoiseEffect};
use crate::diagnose::library::wanted::Wanted;
use crate::engine::gauss_markov::GaussMarkov;
use crate::estimate::batch::{FitError, Options};

use super::judge::{Judged, Objection};
use super::linear::{Linear, Row};
use super::memory::instead_of_blocks;
use super::noise::{leave_out, noise};
use super::pieces::Pieces;
use super::price::ln_bayes_factor;
use super::search::{Log, Pools};
use super::selection::Selection;
use super::terms::{Base, Change};
use super::thresholds::{ENTER, MOST_ROWS};

/// Rounds in which change points are looked for.
const CHANGE_ROUNDS: usize = 2;
/// Change points that enter the competition in a round at most.
const MOST_CHANGES: usize = 4;
/// Candidates that are refitted before one enters.
const SERIOUS: usize = 3;
/// Gain of a serious candidate, in parts of the best.
const SERIOUS_SHARE: f64 = 0.5;
/// Rounds of structure and noise.
const ROUNDS: usize = 5;

/// What the driver found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The last linearisation.
    pub linear: Linear,
    /// The rows that are in the fit.
    pub rows: Vec<Row>,
    /// The model on it.
    pub judged: Judged,
    /// Noise scale factor of each measurand.
    pub scale: Vec<f64>,
    /// Readings that were left out.
    pub left_out: LeftOut,
    /// Effects on the noise.
    pub noise: Vec<NoiseEffect>,
    /// Effects that did not stand as rows, in all rounds, with the reason.
    pub objections: Vec<(String, Objection)>,
    /// What was done, step by step.
    pub log: Log,
}

/// A search that goes on.
struct Search<'a> {
    wanted: &'a Wanted,
    options: &'a Options,
    fitted: Fitted,
    rows: Vec<Row>,
    /// Effects that did not stand: they do not come back.
    refused: Vec<String>,
    /// Why, where that was judged.
    objections: Vec<(String, Objection)>,
    /// Sets of rows that were in the fit.
    seen: Vec<Vec<String>>,
    left_out: LeftOut,
    noise: Vec<NoiseEffect>,
    /// Best members of families of blocks, as they were found beside the first rows.
    scanned: Scanned,
    log: Log,
}

/// Searches from a fitted nominal model. `None` where its parameters are not determined.
///
/// # Errors
/// [`FitError`] where a model cannot be fitted at all.
pub fn search(
    nominal: Fitted,
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<Found>, FitError> {
    let mut search = Search {
        wanted,
        options,
        fitted: nominal,
        rows: Vec::new(),
        refused: Vec::new(),
        objections: Vec::new(),
        seen: Vec::new(),
        left_out: LeftOut::default(),
        noise: Vec::new(),
        scanned: Scanned::new(),
        log: Log::new(),
    };
    let grown = search.grow()?;
    if grown.is_none() {
        return Ok(None);
    }
    for round in 1.. {
        let Some((linear, judged, scale)) = search.compete()? else { return Ok(None) };
        let is_last = round >= ROUNDS;
        if is_last
            || !(search.take_noise(&linear, &judged, &scale)?
                || search.take_rows(&linear, &judged, &scale)?)
        {
            search.objections.extend(named_objections(&linear, &judged));
            let Search { rows, left_out, noise, objections, log, .. } = search;
            let found = Found { linear, rows, judged, scale, left_out, noise, objections, log };
            return Ok(Some(found));
        }
    }
    Ok(None)
}

impl Search<'_> {
    /// Effects enter one after the other, each with a refit.
    fn grow(&mut self) -> Result<Option<()>, FitError> {
        while self.rows.len() < MOST_ROWS {
            let linear = Linear::new(
                self.fitted.clone(),
                &self.rows,
                self.wanted,
                false,
                &mut Scanned::new(),
            );
            let Some(linear) = linear else { return Ok(None) };
            let mut selection = self.selection(&linear);
            let model = linear.rows();
            selection.set_scale(&model);
            let pools = Pools::of(&selection);
            let ranked = selection.ranked(&model, &pools.effects, 0.0);
            let Some(best) = ranked.first().filter(|best| best.ln_bayes >= ENTER) else { break };
            let serious = ranked.iter().filter(|one| {
                one.ln_bayes >= ENTER && one.gain.gain >= SERIOUS_SHARE * best.gain.gain
            });
            let mut next: Option<(f64, usize, Fitted)> = None;
            for one in serious.take(SERIOUS) {
                let start = linear.start(&selection, &model, one.term);
                let selected = &linear.candidates[one.term].selected;
                let with = self.fitted.with(selected, &start, self.options)?;
                let Some(with) = with.filter(Fitted::is_sound) else { continue };
                // What a candidate costs more than another counts against it, and its size.
                let price = one.gain.gain - 2.0 * one.ln_bayes;
                let size = linear.ln_size_prior(&with, &linear.terms[one.term].name);
                let cost = with.cost() + price - 2.0 * size;
                if next.as_ref().is_none_or(|(least, ..)| cost < *least) {
                    next = Some((cost, one.term, with));
                }
            }
            let Some((_, term, with)) = next else { break };
            let name = &linear.terms[term].name;
            self.log.push(format!("{name} enters the fit ({:.1})", best.ln_bayes));
            let row = linear.row(term);
            self.rows.push(row);
            self.fitted = with;
        }
        Ok(Some(()))
    }

    /// A selection in which what did not stand has no part.
    fn selection<'l>(&self, linear: &'l Linear) -> Selection<'l> {
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
        for (term, own) in linear.terms.iter().enumerate() {
            let is_refused = own.is_effect() && self.refused.contains(&own.name);
            selection.live[term] &= !is_refused && own.may_enter;
        }
        selection
    }

    /// Rows, blocks and change points compete, and rows are judged.
    fn compete(&mut self) -> Result<Option<(Linear, Judged, Vec<f64>)>, FitError> {
        let linear =
            Linear::new(self.fitted.clone(), &self.rows, self.wanted, true, &mut self.scanned);
        let Some(mut linear) = linear else { return Ok(None) };
        linear.without_own_covariates();
        let mut model = linear.rows();
        let mut scale: Vec<f64> = Vec::new();
        for round in 0..=CHANGE_ROUNDS {
            let mut selection = self.selection(&linear);
            let pools = Pools::of(&selection);
            model = selection.search(&model, &pools, &mut self.log);
            scale.clone_from(&selection.scale);
            let found = if round < CHANGE_ROUNDS {
                changes(&linear, &selection, &model, pools.blocks.len())
            } else {
                Vec::new()
            };
            let (terms, live) = (selection.terms, selection.live);
            linear.take_terms(terms, live);
            let before = linear.terms.len();
            linear.with_changes(&found);
            if linear.terms.len() == before {
                break;
            }
        }
        let mut selection = self.selection(&linear);
        selection.adopt_scale(&scale);
        let is_row = |term: &usize| selection.terms[*term].is_effect();
        let rows: Vec<usize> = model.iter().copied().filter(is_row).collect();
        if let Some(noise) = instead_of_blocks(&linear, &selection, &model, &rows) {
            drop(selection);
            self.log.push("autocorrelated noise explains more than blocks".to_owned());
            let fitted = linear.fitted.clone();
            self.take_autocorrelation(fitted, &noise)?;
            return self.compete();
        }
        let pools = Pools::of(&selection);
        let judged = selection.judge(
            model,
            pools,
            &mut |selection: &Selection<'_>, model: &[usize]| {
                Pieces::new(&linear, selection, model)
            },
            &mut self.log,
        );
        selection.set_scale(&judged.model);
        let scale = selection.scale.clone();
        let (terms, live) = (selection.terms, selection.live);
        linear.take_terms(terms, live);
        Ok(Some((linear, judged, scale)))
    }

    /// Takes what is found in the noise into the problem; whether there was something.
    fn take_noise(
        &mut self,
        linear: &Linear,
        judged: &Judged,
        scale: &[f64],
    ) -> Result<bool, FitError> {
        let mut selection = self.selection(linear);
        selection.adopt_scale(scale);
        let found = noise(linear, &selection, &judged.model);
        drop(selection);
        if found.is_plain() {
            return Ok(false);
        }
        let mut fitted = linear.fitted.clone();
        let known = self.noise.iter().any(|one| one.memory.is_none());
        if let Some((variance, score)) = found.jitter.filter(|_| !known)
            && let Some(with) = self.with_jitter(&fitted, linear, variance, score)?
        {
            self.log.push(format!("timestamp jitter {:.3e} s", variance.sqrt()));
            self.fitted = with;
            return Ok(true);
        }
        if !found.outliers.is_empty() {
            self.log.push(format!("{} outliers are left out", found.outliers.len()));
            let first = &linear.sums.first_measurand;
            self.left_out.extend(leave_out(&mut fitted.problem, first, &found.outliers));
            self.fitted = fitted.again(self.options)?;
            return Ok(true);
        }
        if found.autocorrelation.is_empty() {
            return Ok(false);
        }
        self.take_autocorrelation(fitted, &found.autocorrelation)?;
        Ok(true)
    }

    /// Goes on with autocorrelated noise.
    fn take_autocorrelation(
        &mut self,
        mut fitted: Fitted,
        found: &[(usize, usize, GaussMarkov)],
    ) -> Result<(), FitError> {
        for (part, row, noise) in found {
            self.log.push(format!(
                "autocorrelated noise in component {row}: share {:.2}, {:.3e} s",
                noise.share, noise.time
            ));
            fitted.problem.parts[*part].gauss_markov[*row] = Some(*noise);
        }
        self.fitted = fitted.again(self.options)?;
        Ok(())
    }

    /// The model with timestamp jitter of a variance (s²), where the library offers it.
    fn with_jitter(
        &mut self,
        fitted: &Fitted,
        linear: &Linear,
        variance: f64,
        score: f64,
    ) -> Result<Option<Fitted>, FitError> {
        let candidate = linear.noise.iter().find(|one| one.name.starts_with(JITTER));
        let Some(candidate) = candidate else { return Ok(None) };
        let Some(with) = fitted.with(&candidate.selected, &[], self.options)? else {
            return Ok(None);
        };
        let mut with = with;
        let prefix = format!("{}.", candidate.name);
        let system = candidate.systems.iter().flatten().next();
        let random = system.and_then(|system| {
            system.randoms.iter().find(|random| random.name.starts_with(&prefix))
        });
        let Some(random) = random else { return Ok(None) };
        let value = variance.sqrt();
        with.set_random(&random.name, value);
        let with = with.again(self.options)?;
        self.noise.push(NoiseEffect {
            name: candidate.name.clone(),
            selected: Some(candidate.selected.clone()),
            parameter: random.name.clone(),
            also: Vec::new(),
            of: None,
            unit: random.unit.clone(),
            value,
            sigma: 0.5 * value / score,
            aliases: Vec::new(),
            memory: None,
            ln_p: -0.5 * score * score,
        });
        Ok(Some(with))
    }

    /// Puts the rows that stand into the fit, and no others; whether the fit changed.
    fn take_rows(
        &mut self,
        linear: &Linear,
        judged: &Judged,
        scale: &[f64],
    ) -> Result<bool, FitError> {
        for (term, _) in &judged.objections {
            self.refused.push(linear.terms[*term].name.clone());
        }
        self.objections.extend(named_objections(linear, judged));
        let stands =
            |term: &&usize| linear.terms[**term].is_effect() && !judged.nameless.contains(*term);
        let wanted: Vec<usize> = judged.model.iter().filter(stands).copied().collect();
        let in_fit = linear.rows();
        let leave: Vec<usize> =
            in_fit.iter().copied().filter(|row| !wanted.contains(row)).collect();
        let enter: Vec<usize> =
            wanted.iter().copied().filter(|row| !in_fit.contains(row)).collect();
        let mut names: Vec<String> =
            wanted.iter().map(|term| linear.terms[*term].name.clone()).collect();
        names.sort_unstable();
        if (leave.is_empty() && enter.is_empty()) || self.seen.contains(&names) {
            return Ok(false);
        }
        self.seen.push(names);
        let mut selection = self.selection(linear);
        selection.adopt_scale(scale);
        let mut fitted = linear.fitted.clone();
        for row in &leave {
            let name = &linear.terms[*row].name;
            let selected = fitted.recipes.iter().flat_map(|recipe| &recipe.effects);
            let selected = selected.into_iter().find(|one| name_of(one) == *name);
            if let Some(selected) = selected.cloned() {
                fitted = fitted.without(&[&selected], self.options)?;
            }
            self.rows.retain(|own| own.name != *name);
            self.log.push(format!("{name} leaves the fit"));
        }
        for term in &enter {
            let rest: Vec<usize> = judged.model.iter().copied().filter(|own| own != term).collect();
            let start = linear.start(&selection, &rest, *term);
            let selected = &linear.candidates[linear.terms[*term].candidate].selected;
            let with = fitted.with(selected, &start, self.options)?;
            if let Some(with) = with.filter(Fitted::is_sound) {
                self.rows.push(linear.row(*term));
                self.log.push(format!("{} enters the fit", linear.terms[*term].name));
                fitted = with;
            } else {
                self.refused.push(linear.terms[*term].name.clone());
            }
        }
        self.fitted = fitted;
        Ok(true)
    }
}

fn named_objections(linear: &Linear, judged: &Judged) -> Vec<(String, Objection)> {
    let name = |term: usize| linear.terms[term].name.clone();
    judged.objections.iter().map(|(term, why)| (name(*term), why.clone())).collect()
}

/// The effect that is timestamp jitter.
const JITTER: &str = "timestamp_jitter";

/// Change points beside a model, and beside the model without each of its rows, that are worth
/// their price: the best of each kind.
fn changes(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
    blocks: usize,
) -> Vec<Change> {
    let mut found = linear.changes(selection, model);
    let ln_bayes = |one: &Change| ln_bayes_factor(one.gain, one.members, blocks);
    found.retain(|one| ln_bayes(one) >= ENTER);
    found.sort_by(|a, b| ln_bayes(b).total_cmp(&ln_bayes(a)));
    let mut known: Vec<(Base, bool)> = Vec::new();
    found.retain(|one| {
        let kind = (one.base, one.end.is_some());
        let is_new = !known.contains(&kind);
        known.push(kind);
        is_new
    });
    found.truncate(MOST_CHANGES);
    found
}
