//! Which effects a user asks for, and how probable each is before the readings are looked at.

use super::candidate::Candidate;
use super::catalogue::Catalogue;
use super::offer::Offer;
use super::prior::Prior;
use super::relaxed::Variants;

/// Which effects are wanted.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// None but these, if any are named: effects at all heads, or as `EFFECT.HEAD` at one.
    pub only: Vec<String>,
    /// Not these.
    pub without: Vec<String>,
    /// How probable each cause is before the readings are looked at.
    pub prior: Prior,
    /// Effects that are tried in a relaxed form alone.
    pub variants: Variants,
    /// What has been made of the models so far: one for several diagnoses of campaigns with the
    /// same models saves its making.
    pub catalogue: Catalogue,
}

impl Wanted {
    /// As asked for.
    pub fn new(only: &[String], without: &[String]) -> Self {
        let (only, without) = (only.to_vec(), without.to_vec());
        Self { only, without, ..Self::default() }
    }

    /// Whether an effect at a head is; without a head, whether it is at any.
    pub fn includes(&self, name: &str, head: Option<&str>) -> bool {
        let means = |one: &String| match one.split_once('.') {
            None => one == name,
            Some((own, at)) => own == name && head.is_none_or(|head| head == at),
        };
        let excludes = |one: &String| means(one) && (head.is_some() || !one.contains('.'));
        (self.only.is_empty() || self.only.iter().any(means)) && !self.without.iter().any(excludes)
    }

    /// What is, of all that there is.
    pub fn of(&self, mut all: Offer) -> Offer {
        let is_wanted = |one: &Candidate| {
            self.includes(&one.selected.effect.name, one.selected.head.as_deref())
        };
        all.effects.retain(is_wanted);
        all.noise.retain(is_wanted);
        all.not_testable.retain(|one| self.includes(&one.name, None));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::Wanted;

    #[test]
    fn an_effect_is_wanted_at_all_heads_or_at_one() {
        let names = |names: &[&str]| names.iter().map(|one| (*one).to_owned()).collect::<Vec<_>>();
        let all = Wanted::default();
        assert!(all.includes("collimation", Some("a")) && all.includes("clock_drift", None));
        let only = Wanted::new(&names(&["collimation.a"]), &[]);
        assert!(only.includes("collimation", Some("a")) && only.includes("collimation", None));
        assert!(!only.includes("collimation", Some("b")) && !only.includes("clock_drift", None));
        let without = Wanted::new(&[], &names(&["collimation.a", "clock_drift"]));
        assert!(
            without.includes("collimation", Some("b")) && without.includes("collimation", None)
        );
        assert!(
            !without.includes("collimation", Some("a")) && !without.includes("clock_drift", None)
        );
    }
}
