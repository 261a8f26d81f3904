//! The driver: a search on the sums, a nonlinear refit of the rows, a new linearisation, and again.

use crate::diagnose::evidence::scan::Scanned;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::wanted::Wanted;
use crate::estimate::batch::{FitError, Options};

use super::changes::Change;
use super::judge::Judged;
use super::linear::{Linear, Row};
use super::price::ln_bayes_factor;
use super::rows::Base;
use super::search::{Log, Pools};
use super::selection::Selection;
use super::thresholds::{ENTER, MOST_ROWS};

/// Rounds in which change points are looked for.
const CHANGE_ROUNDS: usize = 2;

/// Change points that enter the competition in a round at most.
const MOST_CHANGES: usize = 4;
/// Candidates that are refitted before one enters.
const SERIOUS: usize = 3;
/// Gain of a serious candidate, in parts of the best.
const SERIOUS_SHARE: f64 = 0.5;

/// What the driver found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The last linearisation.
    pub linear: Linear,
    /// The model on it.
    pub judged: Judged,
    /// Noise scale factor of each measurand.
    pub scale: Vec<f64>,
    /// What was done, step by step.
    pub log: Log,
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
    let mut log = Log::new();
    let time = std::time::Instant::now();
    let mut rows: Vec<Row> = Vec::new();
    let mut fitted = nominal;
    while rows.len() < MOST_ROWS {
        let mut scanned = Scanned::new();
        let Some(linear) = Linear::new(fitted.clone(), &rows, wanted, false, &mut scanned) else {
            return Ok(None);
        };
        log.push(format!("linear without blocks {:.2} s", time.elapsed().as_secs_f64()));
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
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
            let Some(with) = fitted.with(selected, &start, options)? else { continue };
            log.push(format!(
                "{} ({:.1}) leaves {:.1} {:?}",
                linear.terms[one.term].name,
                one.ln_bayes,
                with.cost(),
                with.fit.outcome
            ));
            // What a candidate costs more than the best one counts against it.
            let price = one.gain.gain - 2.0 * one.ln_bayes;
            let cost = with.cost() + price;
            if with.is_sound() && next.as_ref().is_none_or(|(least, ..)| cost < *least) {
                next = Some((cost, one.term, with));
            }
        }
        let Some((_, term, with)) = next else { break };
        log.push(format!("{} enters, {:.2} s", linear.terms[term].name, time.elapsed().as_secs_f64()));
        rows.push(linear.row(term));
        fitted = with;
    }
    let mut scanned = Scanned::new();
    let Some(mut linear) = Linear::new(fitted, &rows, wanted, true, &mut scanned) else {
        return Ok(None);
    };
    log.push(format!("linear with blocks {:.2} s, {} columns", time.elapsed().as_secs_f64(), linear.sums.len()));
    let start = linear.rows();
    let mut model = start.clone();
    let mut scale: Vec<f64> = Vec::new();
    // Changes are looked for beside what is found, and compete with all of it.
    for _ in 0..CHANGE_ROUNDS {
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
        let pools = Pools::of(&selection);
        model = selection.search(&model, &pools, &mut log);
        scale.clone_from(&selection.scale);
        log.push(format!("searched {:.2} s", time.elapsed().as_secs_f64()));
        let mut found = linear.changes(&selection, &model);
        for term in &model {
            if selection.terms[*term].is_effect() {
                let rest: Vec<usize> = model.iter().copied().filter(|own| own != term).collect();
                found.extend(linear.changes(&selection, &rest));
            }
        }
        let is_strong = |one: &Change| {
            ln_bayes_factor(one.gain, one.members, pools.blocks.len()) >= ENTER
        };
        found.retain(is_strong);
        let ln_bayes = |one: &Change| ln_bayes_factor(one.gain, one.members, pools.blocks.len());
        found.sort_by(|a, b| ln_bayes(b).total_cmp(&ln_bayes(a)));
        let mut bases: Vec<Base> = Vec::new();
        found.retain(|one| {
            let is_new = !bases.contains(&one.base);
            bases.push(one.base);
            is_new
        });
        found.truncate(MOST_CHANGES);
        log.push(format!("changes {:.2} s", time.elapsed().as_secs_f64()));
        let before = linear.terms.len();
        drop(selection);
        linear.with_changes(&found);
        if linear.terms.len() == before {
            break;
        }
    }
    let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
    selection.adopt_scale(&scale);
    let pools = Pools::of(&selection);
    let model = selection.search(&model, &pools, &mut log);
    log.push(format!("searched {:.2} s", time.elapsed().as_secs_f64()));
    let judged = selection.judge(
        model,
        pools,
        &mut |selection: &Selection<'_>, model: &[usize]| linear.pieces(selection, model),
        &mut log,
    );
    log.push(format!("judged {:.2} s", time.elapsed().as_secs_f64()));
    let scale = selection.scale.clone();
    drop(selection);
    Ok(Some(Found { linear, judged, scale, log }))
}
