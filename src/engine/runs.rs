//! The runs of all campaigns of a problem: their numbers, names, samples and order.

use super::problem::Problem;
use crate::campaign::Run;

impl Problem {
    /// Index of a run among all runs.
    pub fn run_index(&self, part: usize, run: usize) -> usize {
        self.layout.first_run[part] + run
    }

    /// The campaign of a run among all runs, and its index there: the inverse of
    /// [`Problem::run_index`].
    pub fn run_at(&self, run: usize) -> (usize, usize) {
        let first = &self.layout.first_run;
        let part = first.partition_point(|first| *first <= run) - 1;
        (part, run - first[part])
    }

    /// Number of samples of a run among all runs.
    pub fn samples_in(&self, run: usize) -> usize {
        let (part, run) = self.run_at(run);
        self.parts[part].runs[run].record.len()
    }

    /// For each run its place in the order of campaigns and, in each, of time. Where times overlap a clock began
    /// anew: the setups follow each other as they are stated, or the runs where those of one setup overlap.
    pub fn order_in_time(&self) -> Vec<usize> {
        let mut sorted: Vec<usize> = Vec::new();
        for (part, data) in self.parts.iter().enumerate() {
            let time = |run: &usize| data.runs[*run].record.first_time().unwrap_or(0.0);
            let mut runs: Vec<usize> = (0..data.runs.len()).collect();
            runs.sort_by(|a, b| time(a).total_cmp(&time(b)));
            if self.overlap(part, &runs) {
                runs.sort_by_key(|run| data.runs[*run].setup);
                let mut setups = runs.chunk_by(|a, b| data.runs[*a].setup == data.runs[*b].setup);
                if setups.any(|own| self.overlap(part, own)) {
                    runs.sort_unstable();
                }
            }
            sorted.extend(runs.into_iter().map(|run| self.run_index(part, run)));
        }
        let mut order = vec![0; sorted.len()];
        sorted.into_iter().enumerate().for_each(|(place, run)| order[run] = place);
        order
    }

    /// Whether some of these runs of a campaign begin before the one before them has ended.
    fn overlap(&self, part: usize, runs: &[usize]) -> bool {
        let times = |run: &usize| self.parts[part].runs[*run].record.ends(|samples| &samples.time);
        let mut latest = f64::NEG_INFINITY;
        runs.iter().filter_map(times).any(|[start, end]| {
            let is_before = start < latest;
            latest = latest.max(end);
            is_before
        })
    }

    /// Whether some run begins after another one has ended, in the reference time.
    pub fn runs_in_sequence(&self) -> bool {
        let runs = self.parts.iter().flat_map(|part| &part.runs);
        let times = |run: &Run| run.record.ends(|samples| &samples.elapsed_time);
        let ends: Vec<[f64; 2]> = runs.filter_map(times).collect();
        let last_start = ends.iter().fold(f64::NEG_INFINITY, |last, [start, _]| last.max(*start));
        let first_end = ends.iter().fold(f64::INFINITY, |first, [_, end]| first.min(*end));
        last_start > first_end
    }

    /// The names of all runs, with the labels of their campaigns where there are several.
    pub fn run_names(&self) -> Vec<String> {
        let runs = self.parts.iter().flat_map(|part| (0..part.runs.len()).map(move |r| (part, r)));
        runs.map(|(part, run)| part.run_name(run)).collect()
    }

    /// Number of samples.
    pub fn sample_count(&self) -> usize {
        self.parts.iter().flat_map(|part| &part.runs).map(|run| run.record.len()).sum()
    }
}
