//! Evidence with runs cut into pieces: for what begins or ends in the course of a run.
//!
//! Each candidate with a value for each run has a column in every piece of it, and these are tied
//! where something goes on from piece to piece. What the nominal parameters can follow stays what
//! it is for whole runs.

use std::ops::Range;
use std::sync::Arc;

use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::library::catalogue::sign;
use crate::engine::gram::{LeastSquares, Normal};
use crate::engine::stretches::Left;
use crate::engine::{Point, Problem};

use super::{Entry, Evidence};

/// A piece of a run.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) struct Piece {
    /// Index of the run over all campaigns.
    pub(in crate::diagnose) run: usize,
    pub(in crate::diagnose) samples: Range<usize>,
}

/// One pass over readings of which each belongs to a piece of its run.
pub(in crate::diagnose) struct InPieces {
    evidence: Evidence,
    /// The number of each run's first piece, and how many it has.
    runs: Vec<(usize, usize)>,
    /// All pieces, run after run, those of each in their order.
    pub(in crate::diagnose) pieces: Vec<Piece>,
}

impl InPieces {
    /// Sums the signatures of candidates over the pieces between cuts; `cuts` holds for each run
    /// the samples at which pieces begin, ascending, the first of them 0. `None` where nominal
    /// parameters are not determined.
    pub(in crate::diagnose) fn of(
        problem: &Problem,
        normal: &Normal,
        point: &Point,
        candidates: &[&Candidate],
        cuts: &[Vec<usize>],
    ) -> Option<Self> {
        let signed = sign(problem, candidates);
        let (mut evidence, mut columns) =
            Evidence::summed(problem, normal, point, candidates.len(), Arc::clone(&signed))?;
        let lengths = problem.parts.iter().flat_map(|part| &part.runs).map(|run| run.record.len());
        let mut first = Vec::with_capacity(cuts.len());
        let mut pieces = Vec::new();
        for ((run, starts), length) in cuts.iter().enumerate().zip(lengths) {
            first.push(pieces.len());
            let ends = starts.iter().skip(1).copied().chain([length]);
            let own = starts.iter().zip(ends).map(|(start, end)| *start..end);
            pieces.extend(own.map(|samples| Piece { run, samples }));
        }
        let mut sums = vec![None; pieces.len()];
        for number in 0..cuts.iter().map(Vec::len).max().unwrap_or(0) {
            let at = |run: usize| (number < cuts[run].len()).then(|| first[run] + number);
            let some = |run: usize| at(run).map(|piece| pieces[piece].samples.clone());
            let mut problem = only(problem, some);
            problem.reweight(point);
            let all = signed.iter().flat_map(|one| problem.gram_with(one, point)).enumerate();
            for (piece, gram) in all.filter_map(|(run, gram)| Some((at(run)?, gram))) {
                sums[piece] = Some(gram);
            }
        }
        evidence.runs = Arc::new(sums.into_iter().collect::<Option<Vec<_>>>()?);
        evidence.touched = pieces.iter().map(|one| evidence.touched[one.run].clone()).collect();
        for column in columns.iter_mut().flat_map(|(_, columns)| columns) {
            let at = column.at.iter().flat_map(|(run, index)| {
                (first[*run]..first[*run] + cuts[*run].len()).map(move |piece| (piece, *index))
            });
            column.at = at.collect();
        }
        evidence.enter(columns);
        let runs = first.into_iter().zip(cuts.iter().map(Vec::len)).collect();
        Some(Self { evidence, runs, pieces })
    }

    /// The entry of a candidate, its values those of whole runs.
    pub(in crate::diagnose) fn entry(&self, candidate: usize) -> &Entry {
        &self.evidence.entries[candidate]
    }

    /// The pieces of a run.
    pub(in crate::diagnose) fn of_run(&self, run: usize) -> Range<usize> {
        let (first, pieces) = self.runs[run];
        first..first + pieces
    }

    /// What a candidate with a value for each run does where it has the same value in some pieces,
    /// by ascending ranges, and none in others.
    pub(in crate::diagnose) fn tied(&self, candidate: usize, wanted: &[Range<usize>]) -> Entry {
        self.evidence.tied_within(self.entry(candidate), wanted)
    }

    /// The same in one piece.
    pub(in crate::diagnose) fn alone(&self, candidate: usize, piece: usize) -> Entry {
        let own = piece..piece + 1;
        self.tied(candidate, std::slice::from_ref(&own))
    }

    /// Several entries as one.
    pub(in crate::diagnose) fn together(&self, entries: &[&Entry]) -> Entry {
        self.evidence.together(entries)
    }

    /// What `b` explains beyond the nominal parameters and `a`, with its degrees of freedom.
    pub(in crate::diagnose) fn beyond(&self, a: &Entry, b: &Entry) -> (f64, usize) {
        self.evidence.beyond(a, b)
    }
}

impl InPieces {
    /// What is left of the readings of each run with an entry's best values and the nominal
    /// parameters that go with them.
    pub(in crate::diagnose) fn left(
        &self,
        problem: &Problem,
        point: &Point,
        entry: &Entry,
    ) -> Vec<Left> {
        let steps = self.evidence.steps(entry);
        let most = self.runs.iter().map(|(_, pieces)| *pieces).max().unwrap_or(0);
        let mut all: Vec<Left> = Vec::new();
        for number in 0..most {
            let of_run = |(first, pieces): &(usize, usize)| {
                steps[first + number.min(pieces.saturating_sub(1))].clone()
            };
            let steps: Vec<Vec<f64>> = self.runs.iter().map(of_run).collect();
            let left = self.evidence.left_by(problem, point, &steps, usize::MAX);
            if all.is_empty() {
                all = left;
                continue;
            }
            for ((first, pieces), (own, new)) in self.runs.iter().zip(all.iter_mut().zip(left)) {
                let Some(piece) = (number < *pieces).then(|| &self.pieces[first + number]) else {
                    continue;
                };
                let range = piece.samples.clone();
                for (own, new) in own.residuals.iter_mut().zip(&new.residuals) {
                    Arc::make_mut(own)[range.clone()].copy_from_slice(&new[range.clone()]);
                }
            }
        }
        all
    }
}

/// A problem with the readings of some samples of each run alone.
fn only(problem: &Problem, wanted: impl Fn(usize) -> Option<Range<usize>>) -> Problem {
    let mut problem = problem.clone();
    let first = problem.layout.first_run.clone();
    for (part, first) in problem.parts.iter_mut().zip(first) {
        let columns = part.reading_columns();
        for (number, run) in part.runs.iter_mut().enumerate() {
            let length = run.record.len();
            let Range { start, end } = wanted(first + number).unwrap_or(0..0);
            let rest = [0..start, end..length].map(|range| (range, columns.clone()));
            run.record.leave_out(rest);
        }
    }
    problem
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use std::path::Path;

    use super::*;
    use crate::diagnose::library::catalogue::Catalogue;
    use crate::engine::open::{Request, open};
    use crate::estimate::batch::Options;
    use crate::estimate::calibrate::calibrate;

    /// Pieces are what runs are made of: together they say the same, and they leave the same.
    #[test]
    fn pieces_add_up_to_their_runs() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
        let opened = open(&Request::new([folder])).unwrap();
        let made = Catalogue::default().of(&opened.recipes);
        let nominal = calibrate(opened.problem, &Options::default()).unwrap();
        let (problem, fit) = (&nominal.problem, &nominal.fit);
        let blocks: Vec<&Candidate> = made.changes.iter().collect();
        let lengths = problem.parts[0].runs.iter().map(|run| run.record.len());
        let cuts: Vec<Vec<usize>> = lengths
            .enumerate()
            .map(|(run, length)| (0..length).step_by(7 + run).collect())
            .collect();
        let seen = InPieces::of(problem, &fit.normal, &fit.point, &blocks, &cuts).unwrap();
        let whole = Evidence::new(problem, &fit.normal, &fit.point, &blocks).unwrap();
        for (number, block) in blocks.iter().enumerate() {
            let own = whole.tied_over(&whole.entries[number], |run| run == 3);
            let tied = seen.tied(number, std::slice::from_ref(&seen.of_run(3)));
            assert_eq!(own.degrees(), tied.degrees(), "{}", block.name);
            assert!((own.gain() - tied.gain()).abs() < 1e-6 * (1.0 + own.gain()), "{}", block.name);
            let later: Vec<Range<usize>> = (2..cuts.len()).map(|run| seen.of_run(run)).collect();
            let own = whole.tied_over(&whole.entries[number], |run| run >= 2);
            let tied = seen.tied(number, &later);
            assert!((own.gain() - tied.gain()).abs() < 1e-6 * (1.0 + own.gain()), "{}", block.name);
            let all = whole.left(problem, &fit.point, &own, usize::MAX);
            for (own, left) in all.iter().zip(seen.left(problem, &fit.point, &tied)) {
                let rows = own.residuals.iter().zip(&left.residuals);
                let pairs = rows.flat_map(|(a, b)| a.iter().zip(b.iter()));
                assert!(pairs.clone().count() > 100);
                pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-6, "{a} {b}"));
            }
        }
    }

    /// What is off in the pieces of one run alone moves nothing in the others but what nominal
    /// parameters do.
    #[test]
    fn a_piece_is_its_samples() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
        let opened = open(&Request::new([folder])).unwrap();
        let made = Catalogue::default().of(&opened.recipes);
        let mut problem = opened.problem;
        problem.parts[0].runs[2].record.edit(|all| {
            all.readings[2][30..60].iter_mut().for_each(|distance| *distance += 50e-6);
        });
        let nominal = calibrate(problem, &Options::default()).unwrap();
        let (problem, fit) = (&nominal.problem, &nominal.fit);
        let is_distance = |one: &&Candidate| {
            one.place
                .as_ref()
                .is_some_and(|place| place.words.starts_with("an error of `distance`"))
        };
        let block: Vec<&Candidate> = made.changes.iter().filter(is_distance).collect();
        let cuts: Vec<Vec<usize>> = problem.parts[0].runs.iter().map(|_| vec![0, 30, 60]).collect();
        let seen = InPieces::of(problem, &fit.normal, &fit.point, &block, &cuts).unwrap();
        let off = seen.of_run(2).start + 1;
        let entry = seen.alone(0, off);
        let value = entry.values()[0];
        assert!((value - 50e-6).abs() < 10e-6, "{value}");
        let shifted = seen.alone(0, off - 1);
        assert!(shifted.gain() < 0.1 * entry.gain());
    }
}
