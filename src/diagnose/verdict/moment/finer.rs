//! When something changed, to the sample: the pieces about its ends are cut again and again.

use super::between::{Cuts, Found, Moment, Runs, by_likelihood};

/// Pieces into which those about an end are cut again, so many times at most.
const FINER: usize = 8;
const TIMES: usize = 6;

impl Runs<'_> {
    /// What may have changed between even cuts where it begins and ends with samples, and the cuts
    /// that show each.
    pub(super) fn finest(&self, found: Vec<Found>, even: &[Vec<usize>]) -> Vec<(Found, Cuts)> {
        let mut finest: Vec<(Found, Cuts)> =
            found.into_iter().filter_map(|one| self.refined(one, even)).collect();
        finest.sort_by(|a, b| by_likelihood(&a.0, &b.0));
        finest
    }

    /// One of them where it begins and ends with samples, and the cuts that show it.
    fn refined(&self, mut found: Found, even: &[Vec<usize>]) -> Option<(Found, Cuts)> {
        let mut cuts = even.to_vec();
        let runs: Vec<usize> =
            (0..cuts.len()).filter(|run| found.moments.iter().any(|one| one.run == *run)).collect();
        for _ in 0..TIMES {
            let finer = self.finer(&found.moments, &cuts, even);
            if finer == cuts {
                break;
            }
            cuts = finer;
            let seen = self.in_pieces(&[&self.blocks[found.block]], &cuts)?;
            found = self.moments(&seen, (found.block, 0), &runs)?;
        }
        Some((found, cuts))
    }

    /// Even cuts, and those between which the pieces beside the ends of some moments are cut again.
    fn finer(&self, moments: &[Moment], cuts: &[Vec<usize>], even: &[Vec<usize>]) -> Cuts {
        let mut finer = even.to_vec();
        for Moment { run, samples, .. } in moments {
            let ends = [samples.start, samples.end];
            let own = &cuts[*run];
            let pieces = own.iter().zip(own.iter().skip(1).chain([&self.lengths[*run]]));
            for (start, end) in
                pieces.filter(|(start, end)| ends.contains(start) || ends.contains(end))
            {
                let parts = FINER.min(end - start);
                finer[*run].extend((0..parts).map(|part| start + part * (end - start) / parts));
            }
        }
        for cuts in &mut finer {
            cuts.sort_unstable();
            cuts.dedup();
        }
        finer
    }
}
