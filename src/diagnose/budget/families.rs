//! Families: effects and blocks with a constant that nobody knows (a period, a width). Which member
//! stands for each, and which were found before.

use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::members::is_as_good;
use crate::diagnose::evidence::sampling::{ALL_BLIND, distinguishable};
use crate::diagnose::evidence::scan::{Scanned, scan, scan_all};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::{Candidate, NotTestable};
use crate::diagnose::library::catalogue::Made;
use crate::diagnose::price::ln_bayes_factor;
use crate::effect::{Family, Members};

/// Best members of families as they were found.
#[derive(Clone, Debug, Default)]
pub struct Families {
    /// Of effects.
    pub effects: Scanned,
    /// Of basis blocks.
    pub blocks: Scanned,
}

/// Of each family the member that explains most, with the number of members tried, and families of
/// which no member can be tested.
pub fn best_members(
    fitted: &Fitted,
    made: &Made,
    offered: Vec<Candidate>,
    scanned: &mut Scanned,
) -> Option<(Vec<Candidate>, Vec<usize>, Vec<NotTestable>)> {
    let (mut best, mut tried, mut blind) = (Vec::new(), Vec::new(), Vec::new());
    let is_range = |family: &Family| matches!(family.members, Members::Range { .. });
    let is_scanned = |family: &[Candidate]| {
        family.len() > 1 && family[0].selected.effect.shape.values().all(is_range)
    };
    let families = || offered.chunk_by(|a, b| a.name == b.name && a.variant == b.variant);
    let wanted = families().filter(|family| is_scanned(family)).map(|family| &family[0]);
    scan_all(fitted, wanted, scanned);
    for family in families() {
        let first = &family[0];
        if is_scanned(family)
            && let Some((found, members)) = scan(fitted, first, scanned)
        {
            best.push(found);
            tried.push(members);
            continue;
        }
        let members = distinguishable(&fitted.problem, family);
        let count = members.len();
        if count == 0 {
            blind.push(NotTestable::here(&first.name, ALL_BLIND));
            continue;
        }
        let mut winner = 0;
        if count > 1 {
            let fit = &fitted.fit;
            let signatures = made.signatures(&fitted.problem, &members);
            let evidence =
                Evidence::with(&fitted.problem, &fit.normal, &fit.point, count, &signatures)?;
            let ln_bayes = |k: &usize| ln_bayes_factor(evidence.entries[*k].gain(), 1, 1);
            // Of those that explain as much the first.
            let most = (0..count).map(|k| ln_bayes(&k)).fold(f64::NEG_INFINITY, f64::max);
            winner = (0..count).find(|k| is_as_good(ln_bayes(k), most)).unwrap_or(0);
        }
        best.push(members[winner].clone());
        tried.push(count);
    }
    Some((best, tried, blind))
}
