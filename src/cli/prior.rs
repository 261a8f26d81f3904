//! How probable causes are before the readings, as `--prior` says.

use crate::diagnose::library::offer::is_noise;
use crate::diagnose::library::prior::{Cause, Prior};
use crate::diagnose::library::wanted::Wanted;
use crate::diagnostic::Diagnostic;
use crate::engine::open::Recipe;

use super::Failure;

const CAUSES: [(&str, Cause); 3] =
    [("nothing", Cause::Nothing), ("library", Cause::Library), ("unknown", Cause::Unknown)];

/// Reads `nothing=0.3`, `library=50 %` or `collimation=3`.
pub(super) fn read(all: &[String], recipes: &[Recipe], wanted: &Wanted) -> Result<Prior, Failure> {
    let (mut said, mut causes, mut effects) = (Vec::new(), Vec::new(), Vec::new());
    for text in all {
        let (name, number) = split(text).ok_or_else(|| malformed(text))?;
        if said.contains(&name) {
            return Err(Diagnostic::error(format!("`--prior {name}` is said twice")).into());
        }
        said.push(name);
        match CAUSES.iter().find(|(word, _)| *word == name) {
            Some((_, cause)) => causes.push((*cause, number)),
            None if text.trim_end().ends_with('%') => {
                let message = format!("`--prior {text}`: an effect has no share of its own");
                let help = "say how many times as probable as another effect it is, as in clock_drift=3; shares are of nothing, library and unknown";
                return Err(Diagnostic::error(message).help(help).into());
            }
            None => effects.push((known(name, recipes, wanted)?, number)),
        }
    }
    let mut prior = Prior::stated(&causes).ok_or_else(|| {
        let said: Vec<String> =
            causes.iter().map(|(cause, number)| format!("{}={number}", word(*cause))).collect();
        let message = format!(
            "`--prior`: these are no probabilities of nothing, library and unknown: {}",
            said.join(", ")
        );
        Diagnostic::error(message).help(
            "each is above 0, and together they are 1; those that are not said share the rest",
        )
    })?;
    for (name, times) in effects {
        prior = prior.with(name, times).ok_or_else(|| {
            Diagnostic::error(format!("`--prior {name}`: expected a number above 0"))
                .help("1 is as probable as any other effect; `--without` leaves an effect out")
        })?;
    }
    Ok(prior)
}

/// How a cause is called.
fn word(cause: Cause) -> &'static str {
    CAUSES.iter().find(|(_, known)| *known == cause).map_or("", |(word, _)| word)
}

/// The name and the number of `NAME=NUMBER`.
fn split(text: &str) -> Option<(&str, f64)> {
    let (name, number) = text.split_once('=')?;
    let (number, by) = match number.trim().strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (number, 1.0),
    };
    Some((name.trim(), by * number.trim().parse::<f64>().ok()?))
}

fn malformed(text: &str) -> Failure {
    Diagnostic::error(format!("`--prior {text}`: expected CAUSE=NUMBER"))
        .help("as in unknown=0.4, or clock_drift=3 for an effect that is three times as probable as others")
        .into()
}

/// The name of an effect that can have a prior.
fn known<'a>(name: &'a str, recipes: &[Recipe], wanted: &Wanted) -> Result<&'a str, Failure> {
    for recipe in recipes {
        let effect = recipe.library.effect(name)?;
        if effect.builtin || is_noise(&effect) {
            let message = format!("`--prior {name}`: an effect on the noise has no prior");
            let help = "its probability is the largest that its test allows against even odds";
            return Err(Diagnostic::error(message).help(help).into());
        }
    }
    let in_use = |recipe: &Recipe| recipe.effects.iter().any(|one| one.effect.name == name);
    if !wanted.includes(name, None) || recipes.iter().all(in_use) {
        let message = format!("`--prior {name}`: that effect is not looked for here");
        let help = "it is in the model already, or left out: see `effects` in campaign.toml, `--with`, `--without` and `--only`";
        return Err(Diagnostic::error(message).help(help).into());
    }
    Ok(name)
}
