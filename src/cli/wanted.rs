//! Which effects of the library are looked at.

use clap::Args;

use crate::diagnose::library::wanted::Wanted;
use crate::diagnostic::Diagnostic;
use crate::engine::open::Recipe;
use crate::system::needs::heads_for;

use super::Failure;

#[derive(Debug, Args)]
pub(super) struct WantedArguments {
    /// Leave an effect out of the library, at all heads or, as in collimation.a, at one (repeat for
    /// more)
    #[arg(long = "without", value_name = "EFFECT")]
    without: Vec<String>,
    /// Look at this effect alone, at all heads or at one (repeat for more)
    #[arg(long = "only", value_name = "EFFECT")]
    only: Vec<String>,
}

impl WantedArguments {
    /// Whether effects of the library are left out.
    pub(super) fn narrows(&self) -> bool {
        !(self.only.is_empty() && self.without.is_empty())
    }

    /// The options as they were given.
    pub(super) fn given(&self) -> [(&'static str, Vec<String>); 2] {
        [("--without", self.without.clone()), ("--only", self.only.clone())]
    }

    /// As asked for, if the library has all of them.
    pub(super) fn wanted(&self, recipes: &[Recipe]) -> Result<Wanted, Failure> {
        for name in self.without.iter().chain(&self.only) {
            let mut heads = Vec::new();
            for recipe in recipes {
                if recipe.library.effect(owner(name))?.builtin {
                    let message = format!("`{name}` is a built-in detector");
                    let help = "it looks for itself in every diagnosis; name an effect with a form";
                    return Err(Diagnostic::error(message).help(help).into());
                }
                let selected = recipe.library.select(name)?;
                let known = heads_for(&recipe.model, &selected.effect);
                if selected.head.is_none() || known.contains(&selected.head) {
                    heads.clear();
                    break;
                }
                heads.push(known.into_iter().flatten().collect::<Vec<_>>().join(", "));
            }
            if let Some(known) = heads.first() {
                let help = match known.as_str() {
                    "" => "it has no heads here".to_owned(),
                    known => format!("heads: {known}"),
                };
                let wrong = format!("`{name}`: the campaign's model has no such head");
                return Err(Diagnostic::error(wrong).help(help).into());
            }
        }
        let left = |name: &String| {
            let is_out = |out: &String| out == name || out == owner(name);
            let in_use =
                |recipe: &Recipe| recipe.effects.iter().any(|one| one.effect.name == owner(name));
            !self.without.iter().any(is_out) && !recipes.iter().all(in_use)
        };
        if !self.only.is_empty() && !self.only.iter().any(left) {
            let message =
                "no effect is left to look at: those of `--only` are left out, or in the model";
            return Err(Diagnostic::error(message)
                .help("drop `--only`, `--without` or `--with`")
                .into());
        }
        Ok(Wanted::new(&self.only, &self.without))
    }
}

/// The effect of `EFFECT.HEAD`.
fn owner(name: &str) -> &str {
    name.split_once('.').map_or(name, |(effect, _)| effect)
}
