//! Which runs share a clock: those in which the same delays act.

use crate::engine::Problem;

/// Clocks that are searched, one after the other.
const MOST: usize = 24;

/// The delays of a clock, and the runs that are stamped by it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::estimate) struct Clock {
    /// Instances of delays that are free.
    pub(in crate::estimate) delays: Vec<usize>,
    /// Campaign and run.
    pub(in crate::estimate) runs: Vec<(usize, usize)>,
}

impl Clock {
    /// The clocks of a problem in the order of their first runs; without any free delay one with all
    /// runs.
    pub(in crate::estimate) fn all(problem: &Problem) -> Vec<Self> {
        let layout = &problem.layout;
        let is_delay =
            |index: &usize| layout.instances[*index].is_delay() && layout.is_free(*index);
        let mut clocks: Vec<Self> = Vec::new();
        for (p, used) in layout.used.iter().enumerate() {
            for (r, used) in used.iter().enumerate() {
                let mut own: Vec<usize> = used.iter().copied().filter(is_delay).collect();
                own.sort_unstable();
                own.dedup();
                let mut joined = Self { delays: own, runs: Vec::new() };
                let (same, others): (Vec<Self>, Vec<Self>) = clocks
                    .into_iter()
                    .partition(|one| one.delays.iter().any(|index| joined.delays.contains(index)));
                for one in same {
                    joined.runs.extend(one.runs);
                    joined.delays.extend(one.delays);
                }
                joined.runs.push((p, r));
                joined.delays.sort_unstable();
                joined.delays.dedup();
                clocks = others;
                clocks.push(joined);
            }
        }
        clocks.retain(|one| !one.delays.is_empty());
        if clocks.is_empty() {
            let all = layout.used.iter().enumerate();
            let runs = all.flat_map(|(p, used)| (0..used.len()).map(move |r| (p, r))).collect();
            return vec![Self { delays: Vec::new(), runs }];
        }
        clocks.sort_by_key(|one| one.runs.iter().min().copied());
        clocks.truncate(MOST);
        clocks
    }

    /// The problem with the samples of this clock alone.
    pub(in crate::estimate) fn alone(&self, problem: &Problem) -> Problem {
        let mut alone = problem.clone();
        for (p, part) in alone.parts.iter_mut().enumerate() {
            for (r, run) in part.runs.iter_mut().enumerate() {
                if !self.runs.contains(&(p, r)) {
                    run.record = run.record.cut(0..0).into();
                }
            }
        }
        alone
    }

    /// The parameters that act in its runs.
    pub(in crate::estimate) fn instances(&self, problem: &Problem) -> Vec<usize> {
        let used = self.runs.iter().flat_map(|(p, r)| problem.layout.used[*p][*r].iter().copied());
        used.collect()
    }
}
