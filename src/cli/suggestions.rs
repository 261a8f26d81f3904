//! Names that are suggested for a misspelt argument: those that are near in spelling, or none.

use clap::error::{ContextKind, ContextValue, Error};

use crate::diagnostic::nearest;

/// What was misspelt, and where the library of arguments puts what it suggests.
const SUGGESTED: [(ContextKind, ContextKind); 3] = [
    (ContextKind::InvalidArg, ContextKind::SuggestedArg),
    (ContextKind::InvalidSubcommand, ContextKind::SuggestedSubcommand),
    (ContextKind::InvalidValue, ContextKind::SuggestedValue),
];

/// Takes out of an error what is suggested by letters in common alone.
pub(super) fn keep_near(error: &mut Error) {
    for (asked, suggested) in SUGGESTED {
        let Some(ContextValue::String(asked)) = error.get(asked) else { continue };
        let asked = asked.trim_start_matches('-').to_owned();
        let is_near = |name: &String| nearest(&asked, [name.trim_start_matches('-')]).is_some();
        match error.get(suggested) {
            Some(ContextValue::String(name)) if !is_near(name) => {
                error.remove(suggested);
                // It is made for the argument that was suggested.
                error.remove(ContextKind::Usage);
            }
            Some(ContextValue::Strings(names)) => {
                let near: Vec<String> =
                    names.iter().filter(|name| is_near(name)).cloned().collect();
                error.remove(suggested);
                if !near.is_empty() {
                    error.insert(suggested, ContextValue::Strings(near));
                }
            }
            _ => {}
        }
    }
    // An empty list is drawn as an empty line.
    if matches!(error.get(ContextKind::Suggested), Some(ContextValue::StyledStrs(all)) if all.is_empty())
    {
        error.remove(ContextKind::Suggested);
    }
}
