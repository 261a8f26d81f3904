//! Statements of one parameter that do not fit together, as messages.

use super::statement::{Keys, Statement};
use crate::diagnostic::{Diagnostic, Place};

/// How the parameter is called in messages.
#[derive(Clone, Copy)]
pub(super) struct Naming<'a> {
    pub(super) name: &'a str,
    pub(super) owner: &'a str,
}

impl Naming<'_> {
    /// Two statements that do not fit together.
    pub(super) fn conflict<'s>(
        self,
        verb: &str,
        [one, other]: [&Statement<'s>; 2],
        words: impl Fn(&Statement<'s>) -> String,
        keys: &Keys,
    ) -> Diagnostic {
        let Self { name, owner } = self;
        let message = format!(
            "`{name}` of {owner} {verb} {} in campaign `{}`, but {} in campaign `{}`",
            words(one),
            one.label,
            words(other),
            other.label,
        );
        let (place, more) = match (one.place(keys), other.place(keys)) {
            (Some(place), Some(more)) => (Some(place), Some((one.label, more, other.label))),
            (place, more) => (place.or(more), None),
        };
        let mut error = Diagnostic::error(message).at_maybe(place);
        if let Some((label, more, other)) = more {
            let Place { file, line, column, .. } = more;
            error = error.label(format!("of campaign `{label}`"));
            error = error.help(format!("campaign `{other}` states it at {file}:{line}:{column}"));
        }
        error.help("campaigns that name the same rig or instrument share its parameters: state the same in both, or give them different names")
    }

    /// The first statement of another quantity.
    pub(super) fn another_quantity(self, list: &[Statement<'_>]) -> Option<Diagnostic> {
        let first = &list[0];
        let is_other = |one: &&Statement<'_>| {
            let units = [first.unit(), one.unit()];
            one.kind() != first.kind()
                || !(units[0].accepts(units[1]) && units[1].accepts(units[0]))
        };
        if let Some(other) = list.iter().find(is_other) {
            return Some(self.conflict("is", [first, other], Statement::quantity, &["value"]));
        }
        let members = first.members();
        let other = list.iter().find(|one| one.members() != members)?;
        let differs = |(one, other): &((String, String), (String, String))| one != other;
        let (family, _) = members.iter().cloned().zip(other.members()).find(differs)?.0;
        let words = |one: &Statement<'_>| {
            let own = one.members().into_iter().find(|(name, _)| *name == family);
            own.map_or_else(String::new, |(_, value)| value)
        };
        let named = Naming { name: &family, owner: self.owner };
        Some(named.conflict("is", [first, other], words, &[]))
    }
}
