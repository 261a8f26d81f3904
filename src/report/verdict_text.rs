//! The verdict of `diagnose` in a sentence that can be read aloud.

use crate::diagnose::Diagnosis;
use crate::diagnose::found::Location;
use crate::diagnose::gap::Gap;
use crate::diagnose::verdict::answer::{Verdict, Why};
use crate::diagnose::verdict::apart::apart;
use crate::report::diagnosis::last_noise;
use crate::report::noise_text::is_shown;

/// Share of the best from which on another place is as good.
const SAME_PLACE: f64 = 0.95;

/// The sentence, and one more where held-out readings say otherwise.
pub(super) fn sentence(diagnosis: &Diagnosis) -> String {
    let is_borne_out = diagnosis.gap.as_ref().and_then(Gap::is_borne_out);
    let but =
        if is_borne_out == Some(false) { " Held-out readings do not bear it out." } else { "" };
    format!("{}{but}", of_campaign(diagnosis))
}

/// The sentence on the campaign that was fitted.
fn of_campaign(diagnosis: &Diagnosis) -> String {
    let noise = diagnosis.noise.iter().map(|one| &one.name);
    let effects = diagnosis.effects.iter().map(|one| &one.candidate.name);
    let names: Vec<String> = effects.chain(noise).map(|name| format!("`{name}`")).collect();
    let names = match names.as_slice() {
        [first @ .., last] if first.len() > 1 => format!("{} and {last}", first.join(", ")),
        few => few.join(" and "),
    };
    match diagnosis.verdict {
        Verdict::Adequate if !diagnosis.suspected.is_empty() => {
            "Nothing can be declared: what is left looks like noise but for what is suspected."
                .to_owned()
        }
        Verdict::Adequate
            if last_noise(diagnosis).is_some_and(|noise| {
                let is_larger = |factor: f64| factor > 1.0 && is_shown(factor);
                noise.levels.iter().any(|one| is_larger(one.factor))
                    || noise.run_levels.iter().any(|(.., factor)| is_larger(*factor))
            }) =>
        {
            "Nothing was found but noise: what is left looks like noise that is larger than stated."
                .to_owned()
        }
        Verdict::Adequate => {
            "Nothing was found: the readings follow the model as closely as their noise lets them."
                .to_owned()
        }
        Verdict::Explained => format!(
            "The gap between model and readings is explained by {names}{}; what is left looks like noise{}.",
            if diagnosis.rests_on_stated_values() {
                ", or by a stated value that is wrong"
            } else {
                ""
            },
            if last_noise(diagnosis).is_some_and(|noise| noise.memory > 0.0) {
                " with a memory"
            } else {
                ""
            }
        ),
        Verdict::ShapeDiffers if diagnosis.effects.len() > 1 || !diagnosis.noise.is_empty() => {
            format!(
                "Nearly all of the gap is explained by {names}; what is left has a form of its own."
            )
        }
        Verdict::ShapeDiffers => format!(
            "Nearly all of the gap is explained by {names}, but its form does not quite fit."
        ),
        Verdict::Unknown => {
            // Displacements are there together, and so are runs; of blocks one would do.
            let apart = diagnosis.search.as_ref().map_or_else(Vec::new, apart);
            let is_apart = |one: &Location| apart.iter().any(|own| own.words == one.place.words);
            let is_meant = |one: &&Location| match &diagnosis.why {
                Some((Why::Displaced, _)) => true,
                Some((Why::RunsApart, _)) => is_apart(one),
                _ => one.share >= SAME_PLACE,
            };
            let join = match &diagnosis.why {
                Some((Why::Displaced | Why::RunsApart, _)) => " and ",
                _ => " or ",
            };
            let alike = diagnosis.locations.iter().filter(is_meant);
            let places: Vec<&str> = alike.map(|one| one.place.words.as_str()).collect();
            let looks = match places.as_slice() {
                [] => "No place of it stands out".to_owned(),
                places => format!("It looks like {}", places.join(join)),
            };
            format!("{} {looks}.", unnamed(diagnosis))
        }
        Verdict::Unobservable if diagnosis.nominal.unobservable.is_empty() => {
            "No diagnosis: the fit of the model's own parameters did not settle.".to_owned()
        }
        Verdict::Unobservable => {
            "No diagnosis: these readings do not determine the model's own parameters.".to_owned()
        }
    }
}

/// That there is a gap without a name, and why it has none.
fn unnamed(diagnosis: &Diagnosis) -> String {
    let (why, effects) = match &diagnosis.why {
        Some((why, effects)) => (*why, effects.as_slice()),
        None => (Why::NoneFits, [].as_slice()),
    };
    let (names, several) = (format!("`{}`", effects.join("` and `")), effects.len() > 1);
    let verb = |one: &'static str, more: &'static str| if several { more } else { one };
    match why {
        Why::NoneFits => "There is a gap that no effect of the library explains.".to_owned(),
        Why::Likelier => {
            let unknown = diagnosis.causes.map_or(0.0, |[.., unknown]| unknown);
            format!(
                "Something is there that nobody wrote down, in all likelihood ({:.0} %), but no place of it is beyond chance by itself.",
                (100.0 * unknown).floor()
            )
        }
        Why::Displaced | Why::RunsApart | Why::Changed => {
            let beside = match effects {
                [] => String::new(),
                _ => format!(" Beside it {names} {}.", verb("shows", "show")),
            };
            format!("There is a gap that no effect of the library explains.{beside}")
        }
        Why::NotFitted => format!(
            "There is a gap like the one that {names} would make, but the model with it cannot be fitted to these readings."
        ),
        Why::Improbable => format!(
            "There is a gap of which {names} {} nothing that can be seen, but {} hardly its cause (probability below 0.1 %).",
            verb("leaves", "leave"),
            verb("is", "are")
        ),
        Why::Imitated => format!(
            "There is a gap of which {names} {} nothing that can be seen, but something {} that nobody wrote down leaves no more.",
            verb("leaves", "leave"),
            verb("likelier", "simpler")
        ),
        Why::NotBorneOut => format!(
            "There is a gap that {names} {} where fitted, but not on readings that {} not fitted to.",
            verb("explains", "explain"),
            verb("it is", "they are")
        ),
    }
}
