//! Whether what changed is all that is there, and likelier than anything that could be added to the
//! model.

use crate::diagnose::evidence::pieces::InPieces;
use crate::diagnose::evidence::score::{likelihood_of_gain, of_gain};
use crate::diagnose::evidence::thresholds::{FURTHER, NAMED, TIE, level};
use crate::diagnose::evidence::{Entry, Evidence};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::Location;
use crate::diagnose::library::candidate::{Candidate, fitting};
use crate::diagnose::library::place::{Of, Place};
use crate::diagnose::sequences::Sequence;
use crate::diagnose::stage::Stage;
use crate::statistics::ln_f;

use super::between::{Cuts, Found, Runs};
use super::white::{WORTH, as_read};

/// By how much what changed may be likelier than it is between even cuts, at most, beside what is
/// even over them.
const EVENLY: f64 = 2.0;

/// What changed where that is all that is there.
pub(super) struct Alone {
    pub(super) found: Found,
    cuts: Cuts,
    /// What it is called.
    name: String,
    /// Where it is, or is as well.
    pub(super) places: Vec<Location>,
    /// What could be added to the model.
    pub(super) stage: Stage,
    /// The readings less what is off, as they are.
    pub(super) left: Vec<Sequence>,
}

impl Runs<'_> {
    /// What changed, if that is all that is there; `stage` is the same model with the noise that
    /// was found in it.
    pub(super) fn changed(&self, stage: &Stage) -> Option<Alone> {
        let (even, cuts) = self.even()?;
        let rival = self.rival(stage, even.first()?)?;
        let finest = self.finest(even, &cuts);
        let is_likelier = |best: &Found| best.likelihood > rival.max(0.0) + FURTHER.ln();
        let (best, cuts) = finest.first().filter(|(best, _)| is_likelier(best))?;
        let name = self.blocks[best.block].name.clone();
        let (stage, left) = self.beside(best, cuts)?;
        let alike = finest.iter().map(|(one, _)| one);
        let alike = alike.filter(|one| one.likelihood > best.likelihood - TIE);
        let places = alike.filter_map(|one| self.located(one, best.gain)).collect();
        Some(Alone { found: best.clone(), cuts: cuts.clone(), name, places, stage, left })
    }

    /// How likely the likeliest is that could be added to the model; `None` where what changed, cut
    /// evenly, cannot become likelier. Of anything that is even over a piece of a run the best
    /// piece shows half at least.
    fn rival(&self, stage: &Stage, best: &Found) -> Option<f64> {
        let scores = stage.scores.iter().enumerate();
        let each = scores.map(|(n, one)| (n, likelihood(stage, n, one.gain, one.degrees)));
        let (likeliest, _) = each.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let Fitted { problem, fit, .. } = self.model;
        let candidate = self.own(&stage.candidates[likeliest])?;
        let seen = Evidence::new(problem, &fit.normal, &fit.point, &[&candidate])?;
        let entry = &seen.entries[0];
        let rival = likelihood(stage, likeliest, entry.gain(), entry.degrees());
        (EVENLY * best.likelihood > rival).then_some(rival)
    }

    /// Whether a change does by itself for all that it and some effects take off the sum of
    /// squares, but for chance, or for nearly all; `None` where that cannot be seen.
    pub(super) fn does_for(&self, change: &Alone, effects: &[&Candidate]) -> Option<bool> {
        let block = self.blocks.iter().find(|one| one.name == change.name)?;
        let effects: Vec<Candidate> =
            effects.iter().map(|one| self.own(one)).collect::<Option<_>>()?;
        let all: Vec<&Candidate> = [block].into_iter().chain(&effects).collect();
        let seen = self.in_pieces(&all, &change.cuts)?;
        let own = self.together(&seen, &change.found);
        let entries: Vec<&Entry> = (1..all.len()).map(|effect| seen.entry(effect)).collect();
        let (more, degrees) = seen.beyond(&own, &seen.together(&entries));
        let is_chance = of_gain(more, degrees, 1).ln_p > level(effects.len());
        Some(own.gain() > 0.0 && (is_chance || own.gain() >= NAMED * (own.gain() + more)))
    }

    /// A candidate of another stage, whose models may hold walks and other effects, beside this
    /// model.
    fn own(&self, candidate: &Candidate) -> Option<Candidate> {
        fitting(&self.model.recipes, &candidate.selected, candidate.place.as_ref())
    }

    /// The moments of a change as one; it is the first candidate that was seen.
    fn together(&self, seen: &InPieces, found: &Found) -> Entry {
        let moments = found.moments.iter();
        let each: Vec<Entry> =
            moments.map(|moment| seen.tied(0, &self.pieces(seen, moment))).collect();
        seen.together(&each.iter().collect::<Vec<_>>())
    }

    /// What could be added to the model, if what was found is all that is there, and likelier than
    /// any of that; and the residuals that it leaves.
    fn beside(&self, found: &Found, cuts: &Cuts) -> Option<(Stage, Vec<Sequence>)> {
        let stage = Stage::new(self.model.clone(), self.wanted)?;
        let rivals = stage.scores.iter().enumerate();
        let rivals = rivals.map(|(n, score)| likelihood(&stage, n, score.gain, score.degrees));
        if found.likelihood <= rivals.fold(0.0, f64::max) + FURTHER.ln() {
            return None;
        }
        let structures = stage.structures();
        let others = structures.iter().map(|n| &stage.candidates[*n]);
        let readings = self.readings();
        let all: Vec<&Candidate> = [&self.blocks[found.block]]
            .into_iter()
            .chain(readings.iter().map(|block| &self.blocks[*block]))
            .chain(others)
            .collect();
        let seen = self.in_pieces(&all, cuts)?;
        let taken = self.together(&seen, found);
        let shows = |(at, n): (usize, &usize)| {
            let (gain, degrees) = seen.beyond(&taken, seen.entry(1 + readings.len() + at));
            of_gain(gain, degrees, stage.members[*n]).ln_p <= level(stage.candidates.len())
        };
        if structures.iter().enumerate().any(shows) {
            return None;
        }
        // What is left in any piece of any reading.
        let (mut gain, mut degrees) = (0.0, 0);
        for block in 1..=readings.len() {
            for piece in 0..seen.pieces.len() {
                let own = seen.beyond(&taken, &seen.alone(block, piece));
                (gain, degrees) = (gain + own.0, degrees + own.1);
            }
        }
        let count = self.model.problem.reading_count() as f64 / WORTH;
        let degrees = degrees.max(1) as f64;
        let is_all = ln_f(gain / degrees, degrees, count) > level(1);
        let Fitted { problem, fit, .. } = self.model;
        is_all.then(|| (stage, as_read(problem, &seen.left(problem, &fit.point, &taken))))
    }

    /// The blocks that are errors of readings, one for each.
    fn readings(&self) -> Vec<usize> {
        let mut known: Vec<&String> = Vec::new();
        let mut found = Vec::new();
        for (number, block) in self.blocks.iter().enumerate() {
            if let Some(Place { of: Of::Measurand(name), .. }) = &block.place
                && !known.contains(&name)
            {
                known.push(name);
                found.push(number);
            }
        }
        found
    }
}

/// Logarithm of the likelihood ratio of something that could be added to the model of a stage, the
/// choice paid for.
fn likelihood(stage: &Stage, candidate: usize, gain: f64, degrees: usize) -> f64 {
    let blocks = stage.candidates.len() - stage.effects;
    let choices = if candidate < stage.effects { 1 } else { blocks };
    likelihood_of_gain(gain, degrees) - ((choices * stage.members[candidate]) as f64).ln()
}
