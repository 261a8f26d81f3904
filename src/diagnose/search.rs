//! The search: which effects are adopted, and whether what is left over looks like noise.
//!
//! Forward, one effect at a time, with backward drop: the best few by score are fitted nonlinearly
//! and tested again; the one that explains most beyond chance is adopted. Then every block of
//! unknown structure is tried against what is left: that gate, not the effect's own test, decides.
//! A forced choice would name a wrong effect nearly always when the true one is not in the library.
//! Where the gate stays shut, pairs of the best are tried ([`mod@pairs`]).
//!
//! | file | answers |
//! |---|---|
//! | `adopted` | which effect is adopted next, and which are like it |
//! | [`absorbed`] | which absorbed effects do by their squares what an effect does |
//! | [`mod@pairs`] | which two effects explain what none does alone |
//! | `imitation` | whether effects only imitate what nobody wrote down |
//! | [`probability`] | how probable each cause is |

pub mod absorbed;
mod adopted;
pub(super) mod imitation;
pub mod pairs;
pub mod probability;

use crate::estimate::batch::{FitError, Options};

pub use self::adopted::Adopted;
use self::adopted::{SHORT_LIST, adopted, aliases, alike, best, of_all};
use self::pairs::pairs;
use self::probability::{among_effects, logarithms};
use super::evidence::score::{Support, of_gain};
use super::evidence::thresholds::level;
use super::fitted::Fitted;
use super::found::{LeftOut, Lost, Noise};
use super::library::wanted::Wanted;
use super::noise::given::Given;
use super::noise::whiten::prepare;
use super::stage::Stage;

/// Effects that are adopted at most.
const MOST: usize = 4;

/// How a search went.
#[derive(Clone, Debug)]
pub struct Search {
    /// The stages: nominal first, then with one more effect each.
    pub stages: Vec<Stage>,
    /// The adopted effects, in order.
    pub adopted: Vec<Adopted>,
}

impl Stage {
    /// Candidates of the library that pass their test, best first.
    pub fn declared(&self) -> Vec<usize> {
        self.passing(0..self.effects)
    }

    /// Blocks that pass their test, best first.
    pub fn blocks_found(&self) -> Vec<usize> {
        let mut found = self.passing(self.effects..self.candidates.len());
        found.retain(|block| !self.is_scatter(*block));
        found
    }

    /// Candidates of the library that are beyond chance but too small or too poorly supported to be
    /// declared, best first.
    pub fn suspected(&self) -> Vec<usize> {
        let level = level(self.effects);
        let declared = self.declared();
        let mut found: Vec<usize> = (0..self.effects)
            .filter(|n| self.scores[*n].ln_p <= level && !declared.contains(n))
            .collect();
        found.sort_by(|a, b| self.scores[*a].ln_p.total_cmp(&self.scores[*b].ln_p));
        found
    }

    fn passing(&self, among: std::ops::Range<usize>) -> Vec<usize> {
        let level = level(among.len());
        let mut found: Vec<usize> = among.filter(|n| self.passes(*n, level)).collect();
        found.sort_by(|a, b| self.scores[*a].ln_p.total_cmp(&self.scores[*b].ln_p));
        found
    }

    /// Whether a candidate passes its test, is large enough, and is supported by how scores scatter
    /// from stretch to stretch.
    fn passes(&self, candidate: usize, level: f64) -> bool {
        let score = &self.scores[candidate];
        let inflation = self.inflation[candidate];
        score.is_seen(level) && self.support().ln_p(score.gain, score.degrees, inflation) <= level
    }

    /// Logarithm of the evidence of each candidate, found out once.
    fn logarithms(&self) -> &[f64] {
        self.logarithms.get_or_init(|| logarithms(self))
    }

    /// What is known of how scores scatter.
    pub(super) fn support(&self) -> Support {
        Support { stretches: self.stretches, memory: self.noise_found.memory }
    }
}

/// What all stages of a search have in common.
struct Common<'a> {
    given: Given,
    wanted: &'a Wanted,
    options: &'a Options,
}

/// Searches from a fitted nominal model, from which lost samples and some gross readings are left
/// out. `None` where its parameters are not determined.
///
/// # Errors
/// [`FitError`] where a model cannot be fitted at all.
pub fn search(
    nominal: Fitted,
    (lost, gross): (&[Lost], &LeftOut),
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<Search>, FitError> {
    let (lost, gross) = (lost.to_vec(), gross.clone());
    let given = Given { lost, gross, ..Given::of(&nominal.problem) };
    let Some(stage) = prepare(nominal, wanted, &given, &Noise::default(), options)? else {
        return Ok(None);
    };
    let common = Common { given, wanted, options };
    let mut search = Search { stages: vec![stage], adopted: Vec::new() };
    // What is dropped may be adopted again where both are tested with different noise: no set of
    // effects is looked at twice.
    let mut seen: Vec<Vec<String>> = Vec::new();
    while search.adopted.len() < MOST {
        let Some(last) = search.stages.last() else { break };
        if search.passes_gate() {
            break;
        }
        let Some((adopted, fitted)) = best(last, options)? else { break };
        if !search.adopt(adopted, fitted, &common)? {
            break;
        }
        search = search.without_needless(&common)?;
        let mut names = search.names();
        names.sort_unstable();
        if seen.contains(&names) {
            break;
        }
        seen.push(names);
    }
    // Effects that imitate something else: two others may be what is there.
    let stands = |search: &Search| search.passes_gate() && search.convinces();
    if search.adopted.is_empty() || stands(&search) {
        return search.beside_each_other(&common).map(Some);
    }
    // In the place of one that leaves nothing they must be likelier than it is with something
    // unknown.
    let instead = search.passes_gate() && search.is_probable() && search.is_doubtful();
    let stands = |found: &Search| stands(found) && !(instead && found.several_imitate(1.0));
    let tried = pairs(&search.stages[0]);
    for (first, second) in tried.into_iter().take(SHORT_LIST) {
        let name = |number: usize| search.stages[0].candidates[number].name.clone();
        let named = [name(first), name(second)];
        if let Some(found) = search.anew(&named, &common)?.filter(stands) {
            return found.beside_each_other(&common).map(Some);
        }
    }
    Ok(Some(search))
}

impl Search {
    /// The gate: adopted effects are enough where no unknown structure is left. One effect alone
    /// must also leave nothing that another of the library explains; of several the blocks decide,
    /// for each more would find something to explain.
    fn passes_gate(&self) -> bool {
        let Some(last) = self.stages.last() else { return false };
        let clear = last.blocks_found().is_empty();
        match self.adopted.len() {
            0 => false,
            1 => clear && last.declared().is_empty(),
            _ => clear,
        }
    }

    /// Adds an effect with its fit; whether that can be built on.
    fn adopt(
        &mut self,
        mut adopted: Adopted,
        fitted: Fitted,
        common: &Common<'_>,
    ) -> Result<bool, FitError> {
        let Some(last) = self.stages.last() else { return Ok(false) };
        let Common { given, wanted, options } = common;
        let Some(stage) = prepare(fitted, wanted, given, &last.noise_found, options)? else {
            return Ok(false);
        };
        let before = stage.fitted.without(&[&adopted.candidate.selected], options)?;
        adopted.gain = before.cost() - stage.fitted.cost();
        self.adopted.push(adopted);
        self.stages.push(stage);
        Ok(true)
    }

    /// The adopted effects' names, in order.
    pub(super) fn names(&self) -> Vec<String> {
        self.adopted.iter().map(|one| one.candidate.name.clone()).collect()
    }

    /// Backward drop: without the effects that add nothing to those that came after them.
    fn without_needless(self, common: &Common<'_>) -> Result<Self, FitError> {
        let Some(last) = self.stages.last() else { return Ok(self) };
        let count = self.adopted.len();
        for (number, one) in self.adopted.iter().enumerate().take(count.saturating_sub(1)) {
            let before = last.fitted.without(&[&one.candidate.selected], common.options)?;
            let score = of_gain(before.cost() - last.fitted.cost(), one.score.degrees, 1);
            if score.ln_p > level(last.effects) {
                let mut names = self.names();
                names.remove(number);
                return Ok(self.anew(&names, common)?.unwrap_or(self));
            }
        }
        Ok(self)
    }

    /// Judges each effect but the last beside all others: when it was adopted it was weighed
    /// against what those explain, too.
    fn beside_each_other(mut self, common: &Common<'_>) -> Result<Self, FitError> {
        let Some(last) = self.stages.last() else { return Ok(self) };
        let Common { given, wanted, options } = common;
        let count = self.adopted.len();
        for one in self.adopted.iter_mut().take(count.saturating_sub(1)) {
            let others = last.fitted.without(&[&one.candidate.selected], options)?;
            let Some(stage) = prepare(others, wanted, given, &last.noise_found, options)? else {
                continue;
            };
            let is_own = |n: &usize| stage.candidates[*n].name == one.candidate.name;
            if let Some(number) = (0..stage.effects).find(is_own) {
                let like = alike(&stage, number);
                // Beside a walk that is there in its stead nothing would be left of it.
                if stage.noise_found.instead().all(|rival| rival.effect != one.candidate.name) {
                    one.among_effects = of_all(&among_effects(&stage), number, &like);
                }
                one.aliases = aliases(&stage, number, &like);
            }
        }
        Ok(self)
    }

    /// The search that adopts effects of these names one after the other; `None` where it cannot.
    fn anew(&self, names: &[String], common: &Common<'_>) -> Result<Option<Self>, FitError> {
        let mut search = Self { stages: self.stages[..1].to_vec(), adopted: Vec::new() };
        for name in names {
            let Some(last) = search.stages.last() else { return Ok(None) };
            let number = (0..last.effects).find(|n| last.candidates[*n].name == *name);
            let found = number.map(|number| adopted(last, number, common.options)).transpose()?;
            let Some((adopted, fitted)) = found.flatten() else { return Ok(None) };
            if !search.adopt(adopted, fitted, common)? {
                return Ok(None);
            }
        }
        Ok(Some(search))
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use std::path::Path;

    use super::*;
    use crate::engine::open::{Request, open};
    use crate::engine::simulate::simulate;
    use crate::estimate::calibrate::calibrate;

    /// Adopted first, the nearest relative of the effect that is there explains much; beside that
    /// effect it adds nothing.
    #[test]
    fn an_effect_that_adds_nothing_to_a_later_one_is_dropped() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
        let true_one = "tracking_reversal";
        let mut request = Request::new([&folder]);
        let opened = open(&request).unwrap();
        let options = Options::default();
        let nominal = calibrate(opened.problem.clone(), &options).unwrap();
        request.with = vec![true_one.to_owned()];
        let mut truth = calibrate(open(&request).unwrap().problem, &options).unwrap();
        for (index, instance) in truth.problem.layout.instances.iter().enumerate() {
            if instance.name.starts_with(true_one) {
                truth.fit.point.values[index][0] = 4.0 * instance.setting.typical.unwrap();
            }
        }
        simulate(&mut truth.problem, &truth.fit.point, 5, true);
        let mut problem = nominal.problem.clone();
        for (part, drawn) in problem.parts.iter_mut().zip(truth.problem.parts) {
            part.runs = drawn.runs;
        }
        let nominal = calibrate(crate::engine::Problem::new(problem.parts), &options).unwrap();
        let fitted = Fitted { recipes: opened.recipes, problem: nominal.problem, fit: nominal.fit };
        let wanted = Wanted::default();
        let given = Given::of(&fitted.problem);
        let stage = prepare(fitted, &wanted, &given, &Noise::default(), &options).unwrap().unwrap();
        let declared = stage.declared();
        assert_eq!(stage.candidates[declared[0]].name, true_one);
        let relative = stage.candidates[declared[1]].name.clone();
        // What explains as much, but something else, is no alias.
        let other = stage.candidates.iter().position(|one| one.name == "distance_offset").unwrap();
        let mut equal = stage.clone();
        equal.scores[other].gain = equal.scores[declared[0]].gain;
        assert!(!alike(&equal, declared[0]).contains(&other));
        let common = Common { given, wanted: &wanted, options: &options };
        let search = Search { stages: vec![stage], adopted: Vec::new() };
        let both = [relative.clone(), true_one.to_owned()];
        let both = search.anew(&both, &common).unwrap().unwrap();
        assert_eq!(both.adopted[0].candidate.name, relative);
        let left = both.without_needless(&common).unwrap();
        let names: Vec<&str> = left.adopted.iter().map(|one| one.candidate.name.as_str()).collect();
        assert_eq!(names, [true_one]);
        assert_eq!(left.stages.len(), 2);
        // What adds something stays.
        let again = left.without_needless(&common).unwrap();
        assert_eq!(again.adopted.len(), 1);
    }
}
