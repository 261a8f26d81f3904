//! What else changes at a moment that was found for one value: the other components of a vector, the other
//! axes of a displacement, the turn beside it. The moment is known, and costs nothing more.

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::terms::{Base, Change};
use crate::diagnose::library::place::Place;
use crate::diagnose::price::Gain;
use crate::effect::Target;

impl Linear {
    /// The same change of the other components of a vector or a rotation: what was mounted anew stands
    /// elsewhere in all of them. The moment is known, and costs nothing more.
    pub(super) fn siblings(&self, change: &Change) -> Vec<Change> {
        let parameter = |candidate: usize| self.candidates[candidate].place.as_ref()?.parameter();
        let own = change.base.candidate;
        let Some(name) = parameter(own) else { return Vec::new() };
        let others =
            (0..self.candidates.len()).filter(|one| *one != own && parameter(*one) == Some(name));
        let at = |candidate| Change {
            base: Base { candidate, ..change.base },
            gain: Gain::default(),
            members: 1,
            ..change.clone()
        };
        others.map(at).collect()
    }

    /// The same change of all values of a block that has several, and of a block that has these and others:
    /// what was knocked is displaced in some direction, and turned.
    pub(super) fn together(&self, change: &Change) -> Vec<Change> {
        let effect = |candidate: usize| &self.candidates[candidate].selected.effect;
        let own = change.base.candidate;
        let has_own = |candidate: usize| {
            let targets = effect(candidate).patches.iter().map(|patch| &patch.target);
            let targets: Vec<&Target> = targets.collect();
            effect(own).patches.iter().all(|patch| targets.contains(&&patch.target))
        };
        // What is knocked does not come back within a run.
        let samples = self.fitted.problem.samples_in(change.at.0);
        let comes_back = change.end.is_some_and(|end| change.at.1 > 0 || end < samples);
        let is_asked = |candidate: &usize| {
            let is_wider = self.is_of_several(*candidate) && has_own(*candidate);
            is_wider && !comes_back || (*candidate == own && effect(own).parameters.len() > 1)
        };
        let at = |candidate: usize| Change {
            base: Base { candidate, signature: 0 },
            width: effect(candidate).parameters.len(),
            gain: Gain::default(),
            ..change.clone()
        };
        (0..self.candidates.len()).filter(is_asked).map(at).collect()
    }

    /// Whether a block is another value of several parameters, which no moment is looked for.
    pub(super) fn is_of_several(&self, candidate: usize) -> bool {
        let one = &self.candidates[candidate];
        let is_of_a_parameter = one.place.as_ref().is_some_and(Place::is_of_a_parameter);
        is_of_a_parameter && one.selected.effect.parameters.len() > 1
    }
}
