//! When something changed, and in which order the runs of a setup came: by their times, however a
//! campaign lists them, or as listed where times begin anew in each recording and runs seem to
//! overlap.

use crate::engine::Problem;

/// The setup of a run, and when the run begins and ends since the setup began (s), if it has
/// samples.
pub(in crate::diagnose) type Span = (usize, Option<[f64; 2]>);

/// When something changed: from a run of its setup on for good, in one run alone, or for good while
/// a run went on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Change {
    From(usize),
    In(usize),
    During(usize),
}

impl Change {
    /// The only run that is changed, if it is one alone.
    pub(in crate::diagnose) fn only_run(self, names: &[String]) -> Option<&str> {
        match self {
            Self::From(_) | Self::During(_) => None,
            Self::In(run) => Some(&names[run]),
        }
    }

    pub(in crate::diagnose) fn words(self, names: &[String]) -> String {
        match self {
            Self::From(run) => format!("from run `{}` on", names[run]),
            Self::In(run) => format!("in run `{}`", names[run]),
            Self::During(run) => format!("in the course of run `{}` and from then on", names[run]),
        }
    }
}

/// The spans of all runs.
pub(in crate::diagnose) fn spans(problem: &Problem) -> Vec<Span> {
    let setups = problem.layout.columns.runs.iter().map(|(setup, _)| *setup);
    let runs = problem.parts.iter().flat_map(|part| &part.runs);
    let ends = runs.map(|run| run.record.ends(|samples| &samples.setup_time));
    setups.zip(ends).collect()
}

/// All runs, those of each setup one after the other.
pub(in crate::diagnose) fn in_order(spans: &[Span]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..spans.len()).collect();
    let setups = spans.iter().map(|one| one.0 + 1).max().unwrap_or(0);
    for setup in 0..setups {
        let timed = |run: &usize| spans[*run].0 == setup && spans[*run].1.is_some();
        let listed: Vec<usize> = (0..spans.len()).filter(timed).collect();
        let mut sorted: Vec<(usize, [f64; 2])> =
            listed.iter().filter_map(|run| Some((*run, spans[*run].1?))).collect();
        sorted.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]));
        if sorted.windows(2).any(|pair| pair[1].1[0] < pair[0].1[1]) {
            continue;
        }
        for (place, (run, _)) in listed.iter().zip(sorted) {
            order[*place] = run;
        }
    }
    order
}

/// The place of each run in such an order.
pub(in crate::diagnose) fn places(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (place, run) in order.iter().enumerate() {
        places[*run] = place;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_follow_their_times_unless_they_overlap() {
        let shuffled =
            [(0, Some([20.0, 30.0])), (1, Some([5.0, 9.0])), (0, None), (0, Some([0.0, 20.0]))];
        assert_eq!(in_order(&shuffled), [3, 1, 2, 0]);
        assert_eq!(places(&[2, 0, 1]), [1, 2, 0]);
        let anew = [(0, Some([0.0, 30.0])), (0, Some([0.0, 20.0])), (0, Some([0.0, 25.0]))];
        assert_eq!(in_order(&anew), [0, 1, 2]);
    }
}
