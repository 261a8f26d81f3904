//! How well a diagnosis does on the user's own campaign: simulated campaigns whose truth is known,
//! diagnosed without it.
//!
//! Each trial draws readings of the campaign's own design (times, inputs, noise, nominal values)
//! with nothing, one effect, two effects, an effect that is then withheld from the library, or
//! noise that is not what is stated; the diagnosis sees the readings alone. At least a third of the
//! effects have forms that the library lacks ([`shapes`]): a diagnosis that is tested on its own
//! forms only grades its own homework.
//!
//! Sizes are told as `λ`: the length of what the nominal fit leaves of the noiseless signature, in
//! units of the noise. Effects whose signatures are alike ([`design::ALIKE`] of the squared length,
//! either way) count as one name.
//!
//! | file | answers |
//! |---|---|
//! | [`plan`] | what each trial is to be, from the seed and its number alone |
//! | [`shapes`] | effects that no library holds |
//! | [`design`] | the campaign at its truth, all signatures, who is like whom |
//! | [`situation`] | disturbed readings and misstated values, as data |
//! | `simulated` | the campaign with effects of known values |
//! | [`draw`] | the readings of one trial; `doses`, `mixture` and `noise` draw parts of it |
//! | [`outcome`] | what the diagnosis made of them |
//! | [`heading`], [`ledger`] | the file of finished trials |
//! | [`replay`], [`difference`], [`paired`] | recorded trials made again, and compared |
//! | [`tally`], [`bound`] | the score, with its bounds |
//!
//! A trial depends on the seed and its number alone, so the score is the same at any number of
//! threads, and whether or not it was interrupted.

pub mod bound;
pub mod design;
pub mod difference;
mod doses;
pub mod draw;
pub mod heading;
pub mod ledger;
mod mixture;
mod noise;
pub mod outcome;
pub mod paired;
pub mod plan;
pub mod replay;
pub mod shapes;
mod simulated;
pub mod situation;
pub mod tally;

use std::collections::HashSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::progress::{Progress, Task};

use design::Design;
use ledger::Ledger;
use outcome::Outcome;
use plan::Plan;

/// Runs those trials of a plan that are not in the ledger yet, on so many threads; all outcomes
/// come back in the order of the trials.
///
/// # Errors
/// The first that writing the ledger gives.
pub fn run(
    design: &Design,
    plan: &Plan,
    mut ledger: Option<&mut Ledger>,
    threads: usize,
    progress: &Progress,
) -> std::io::Result<Vec<Outcome>> {
    let known = ledger.as_ref().map(|ledger| ledger.outcomes.clone()).unwrap_or_default();
    let mut outcomes: Vec<Outcome> =
        known.into_iter().filter(|one| one.trial < plan.trials).collect();
    let done: HashSet<usize> = outcomes.iter().map(|one| one.trial).collect();
    let open: Vec<usize> = (0..plan.trials).filter(|trial| !done.contains(trial)).collect();
    let made = make(design, plan, &open, threads, |outcome, count| {
        progress.tell(Task::Trials, (done.len() + count) as u64, plan.trials as u64);
        ledger.as_mut().map_or(Ok(()), |ledger| ledger.add(outcome))
    })?;
    outcomes.extend(made);
    outcomes.sort_by_key(|one| one.trial);
    outcomes.dedup_by_key(|one| one.trial);
    Ok(outcomes)
}

/// Makes some trials of a plan on so many threads. `finished` is shown each outcome, as it comes,
/// and how many there are; where it fails no more trials begin.
fn make(
    design: &Design,
    plan: &Plan,
    trials: &[usize],
    threads: usize,
    finished: impl FnMut(&Outcome, usize) -> std::io::Result<()> + Send,
) -> std::io::Result<Vec<Outcome>> {
    let next = AtomicUsize::new(0);
    let shared = Mutex::new((finished, Vec::new(), Ok(())));
    let work = || {
        // A trial is too small to be shared: each worker keeps to its own thread.
        let alone = || rayon::ThreadPoolBuilder::new().num_threads(1);
        let alone = alone().use_current_thread().build().or_else(|_| alone().build()).ok();
        while let Some(trial) = trials.get(next.fetch_add(1, Ordering::Relaxed)) {
            let one = || outcome::of(design, plan, *trial);
            let made = alone.as_ref().map_or_else(one, |pool| pool.install(one));
            let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
            let (finished, outcomes, failed) = &mut *shared;
            if failed.is_ok() {
                *failed = finished(&made, outcomes.len() + 1);
            }
            if failed.is_err() {
                return;
            }
            outcomes.push(made);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.min(trials.len()) {
            // Where no more threads can be started, those that there are do the work.
            if std::thread::Builder::new().spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        work();
    });
    let (_, made, failed) = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.map(|()| made)
}
