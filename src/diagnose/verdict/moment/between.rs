//! When something may have changed: pieces of runs in which a block has one value, the likeliest of
//! them.
//!
//! They are cut evenly first, and then finer (`finer`). Whether it is what happened is judged one
//! floor up.

use std::cmp::Ordering;
use std::ops::Range;

use crate::campaign::Run;
use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::pieces::InPieces;
use crate::diagnose::evidence::score::{likelihood_of_gain, of_gain};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::noise::wander::sequence::{in_order, places, spans};
use crate::engine::{Part, Problem};

/// Pieces that a run is cut into first, of so many samples at least.
const PIECES: usize = 16;
const LEAST_SAMPLES: usize = 4;
/// Moments that are looked for: more are noise.
const MOST: usize = 3;
/// Logarithm of the probability by chance below which pieces of a run differ.
const DIFFER: f64 = -6.0;
/// Logarithms of likelihoods of moments that differ less say the same.
const ALIKE: f64 = 0.5;
/// What may have changed of which ends are looked for, the likeliest first.
const LIKELIEST: usize = 4;

/// For each run the samples at which its pieces begin.
pub(super) type Cuts = Vec<Vec<usize>>;

/// From where to where something is off: in some samples of a run, and as far as it goes on from
/// there.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moment {
    pub(super) run: usize,
    pub(super) samples: Range<usize>,
    pub(super) goes_on: Option<Reach>,
}

/// How far something goes on beyond the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reach {
    /// To the end of the setup.
    Setup,
    /// To that of the campaign.
    Campaign,
}

/// What may have changed, and when.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Which of the blocks says what.
    pub(super) block: usize,
    pub(super) moments: Vec<Moment>,
    /// Logarithm of the likelihood ratio, the choice paid for.
    pub(super) likelihood: f64,
    /// What it takes off the sum of squares.
    pub(super) gain: f64,
}

/// The runs of a model, and what may change in them.
pub(super) struct Runs<'a> {
    pub(super) model: &'a Fitted,
    pub(super) wanted: &'a Wanted,
    /// What may change from run to run.
    pub(super) blocks: Vec<Candidate>,
    pub(super) lengths: Vec<usize>,
    /// For each run the later ones of its setup, and those of its campaign where these are more.
    of_setup: Vec<Vec<usize>>,
    of_campaign: Vec<Vec<usize>>,
}

impl<'a> Runs<'a> {
    pub(super) fn of(model: &'a Fitted, wanted: &'a Wanted) -> Self {
        let runs = model.problem.parts.iter().flat_map(|part| &part.runs);
        let lengths: Vec<usize> = runs.map(|run| run.record.len()).collect();
        let (spans, times) = (spans(&model.problem), times(&model.problem));
        let order = places(&in_order(&spans));
        let of_setup: Vec<Vec<usize>> = (0..spans.len())
            .map(|run| {
                let is_later =
                    |other: &usize| spans[*other].0 == spans[run].0 && order[*other] > order[run];
                (0..spans.len()).filter(is_later).collect()
            })
            .collect();
        let of_campaign = (0..spans.len()).map(|run| {
            let (part, Some([_, end])) = times[run] else { return Vec::new() };
            let is_later = |other: &usize| {
                let (own, times) = times[*other];
                own == part && times.is_some_and(|[start, _]| start >= end)
            };
            let later: Vec<usize> = (0..spans.len()).filter(is_later).collect();
            let is_more = of_setup[run].iter().all(|other| later.contains(other));
            if is_more && later.len() > of_setup[run].len() { later } else { Vec::new() }
        });
        let of_campaign = of_campaign.collect();
        let blocks = wanted.catalogue.of(&model.recipes).changes.clone();
        Self { model, wanted, blocks, lengths, of_setup, of_campaign }
    }

    /// The runs after one in which something goes on.
    pub(super) fn later(&self, run: usize, reach: Reach) -> &[usize] {
        match reach {
            Reach::Setup => &self.of_setup[run],
            Reach::Campaign => &self.of_campaign[run],
        }
    }

    /// What may have changed between even cuts, the likeliest first, and the cuts; `None` where
    /// nominal parameters are not determined.
    pub(super) fn even(&self) -> Option<(Vec<Found>, Cuts)> {
        let even = |length: &usize| {
            let pieces = (length / LEAST_SAMPLES).clamp(1, PIECES);
            (0..pieces).map(|piece| piece * length / pieces).collect()
        };
        let cuts: Cuts = self.lengths.iter().map(even).collect();
        let all: Vec<&Candidate> = self.blocks.iter().collect();
        let seen = self.in_pieces(&all, &cuts)?;
        let runs = |block| self.uneven(&seen, block);
        let mut found: Vec<Found> = (0..self.blocks.len())
            .filter_map(|block| self.moments(&seen, (block, block), &runs(block)))
            .collect();
        found.sort_by(by_likelihood);
        found.truncate(LIKELIEST);
        Some((found, cuts))
    }

    pub(super) fn in_pieces(
        &self,
        candidates: &[&Candidate],
        cuts: &[Vec<usize>],
    ) -> Option<InPieces> {
        let Fitted { problem, fit, .. } = self.model;
        InPieces::of(problem, &fit.normal, &fit.point, candidates, cuts)
    }

    /// The runs of which the pieces differ in what a block says.
    fn uneven(&self, seen: &InPieces, block: usize) -> Vec<usize> {
        let is_uneven = |run: &usize| {
            let own = seen.of_run(*run);
            let whole = seen.tied(block, std::slice::from_ref(&own));
            let each = own.map(|piece| seen.alone(block, piece));
            let (gain, degrees) = each.fold((0.0, 0), |(gain, degrees), one| {
                (gain + one.gain(), degrees + one.degrees())
            });
            let degrees = degrees.saturating_sub(whole.degrees());
            of_gain(gain - whole.gain(), degrees, 1).ln_p <= DIFFER
        };
        (0..self.lengths.len()).filter(is_uneven).collect()
    }

    /// The moments of some runs at which what a block says changes, the likeliest first, up to a
    /// run that is off as a whole; `None` where there are none. `at` is its number among what was
    /// seen.
    pub(super) fn moments(
        &self,
        seen: &InPieces,
        (block, at): (usize, usize),
        runs: &[usize],
    ) -> Option<Found> {
        let possible: Vec<(Moment, Entry)> = runs
            .iter()
            .flat_map(|run| self.possible(seen, *run))
            .map(|moment| {
                let entry = seen.tied(at, &self.pieces(seen, &moment));
                (moment, entry)
            })
            .collect();
        let mut taken: Vec<&(Moment, Entry)> = Vec::new();
        let (mut likelihood, mut total) = (0.0, 0.0);
        while taken.len() < MOST {
            let known = seen.together(&taken.iter().map(|one| &one.1).collect::<Vec<_>>());
            let beyond = |one| {
                let (_, entry): &(Moment, Entry) = one;
                let (gain, degrees) = seen.beyond(&known, entry);
                (one, gain, likelihood_of_gain(gain, degrees))
            };
            let all: Vec<_> = possible.iter().map(beyond).collect();
            let most = all.iter().map(|one| one.2).fold(0.0, f64::max);
            // With a value of the run's own for something else, what comes before a moment is as
            // much off as what follows.
            let best = all.into_iter().filter(|one| one.2 >= most - ALIKE);
            let by_rank = |one: &(&(Moment, Entry), f64, f64)| self.rank(&one.0.0);
            let best = best.min_by(|a, b| by_rank(a).cmp(&by_rank(b)).then(b.2.total_cmp(&a.2)));
            let Some((best, gain, likelier)) = best else { break };
            let likelier = likelier - self.price(&best.0);
            if likelier <= 0.0 || self.is_whole(&best.0) {
                break;
            }
            taken.push(best);
            likelihood += likelier;
            total += gain;
        }
        let moments: Vec<Moment> = taken.into_iter().map(|one| one.0.clone()).collect();
        (!moments.is_empty()).then_some(Found { block, moments, likelihood, gain: total })
    }

    /// All that may have been off in a run, and from then on, between the cuts.
    fn possible(&self, seen: &InPieces, run: usize) -> Vec<Moment> {
        let own: Vec<&Range<usize>> =
            seen.pieces.iter().filter(|one| one.run == run).map(|one| &one.samples).collect();
        let between = |from: usize| {
            let start = own[from].start;
            let samples = own[from..].iter().map(move |last| start..last.end);
            samples.map(move |samples| Moment { run, samples, goes_on: None })
        };
        let end = self.lengths[run];
        let reaches = [Reach::Setup, Reach::Campaign].into_iter();
        let on = reaches.filter(|reach| !self.later(run, *reach).is_empty()).flat_map(|reach| {
            let starts = own.iter().map(|piece| piece.start);
            starts.map(move |start| Moment { run, samples: start..end, goes_on: Some(reach) })
        });
        (0..own.len()).flat_map(between).chain(on).collect()
    }

    /// The pieces in which it is off.
    pub(super) fn pieces(&self, seen: &InPieces, moment: &Moment) -> Vec<Range<usize>> {
        let Range { start, end } = moment.samples;
        let own = seen.of_run(moment.run);
        let is_in = |piece: &usize| {
            let samples = &seen.pieces[*piece].samples;
            start <= samples.start && samples.end <= end
        };
        let first = own.clone().find(|piece| is_in(piece)).unwrap_or(own.end);
        let own = first..first + (first..own.end).take_while(|piece| is_in(piece)).count();
        let later = moment.goes_on.map_or(&[][..], |reach| self.later(moment.run, reach));
        let mut all = vec![own];
        for more in later.iter().map(|run| seen.of_run(*run)) {
            match all.last_mut().filter(|last| last.end == more.start) {
                Some(last) => last.end = more.end,
                None => all.push(more),
            }
        }
        all
    }

    /// Whether it ends with a setup that others follow.
    pub(super) fn ends_with_setup(&self, moment: &Moment) -> bool {
        moment.goes_on == Some(Reach::Setup) && !self.of_campaign[moment.run].is_empty()
    }

    /// Of moments that say the same, which is told: from one on to the end of its run rather than
    /// beyond, or before.
    fn rank(&self, moment: &Moment) -> usize {
        let ends = moment.samples.end == self.lengths[moment.run];
        match moment.goes_on {
            None if ends => 0,
            Some(Reach::Setup) => 1,
            Some(Reach::Campaign) => 2,
            None => 3,
        }
    }

    fn is_whole(&self, moment: &Moment) -> bool {
        moment.samples == (0..self.lengths[moment.run])
    }

    /// Logarithm of the number of choices of which a moment is one.
    fn price(&self, moment: &Moment) -> f64 {
        let samples: usize = self.lengths.iter().sum();
        let Range { start, end } = moment.samples;
        let length = self.lengths[moment.run];
        let ends = if start > 0 && end < length { length } else { 4 };
        (self.blocks.len() as f64 * samples as f64 * ends as f64).ln()
    }
}

pub(super) fn by_likelihood(a: &Found, b: &Found) -> Ordering {
    b.likelihood.total_cmp(&a.likelihood)
}

/// The campaign of each run, and when the run begins and ends since the first of all began (s).
fn times(problem: &Problem) -> Vec<(usize, Option<[f64; 2]>)> {
    let of_part = |(p, part): (usize, &Part)| {
        let ends = |run: &Run| (p, run.record.ends(|samples| &samples.elapsed_time));
        part.runs.iter().map(ends).collect::<Vec<_>>()
    };
    problem.parts.iter().enumerate().flat_map(of_part).collect()
}
