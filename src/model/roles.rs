//! Roles: which names of a model stand for the names that the library's effects use.
//!
//! `[roles] horizontal = "azimuth"` lets effects on a horizontal angle act on `azimuth`. A formula
//! of one name, `vertical = "90 deg - elevation"`, makes the role a quantity of the model through
//! which that name goes: what an effect does to `vertical` reaches `elevation`. `[heads]` says the
//! same for several heads.

use std::collections::{HashMap, HashSet};

use crate::diagnostic::{Diagnostic, nearest};
use crate::document::{Item, Section};
use crate::formula::angles::bare_angle;
use crate::formula::isolate::{isolated, rename};
use crate::formula::{Expression, ExpressionKind, Formula};
use crate::model::declaration::{Model, Role};
use crate::model::name::{checked, fault_of, fault_of_owner};

impl Model {
    /// What a name of the library is called in this model: itself, or what stands for it.
    pub fn called<'m>(&'m self, name: &'m str) -> &'m str {
        self.roles.get(name).map_or(name, |role| role.value.as_str())
    }
}

/// Values of a name between which a role must change.
const PROBES: [f64; 2] = [0.3, 0.7];

/// A role as it is written.
pub(super) struct Written {
    head: Option<String>,
    role: String,
    /// The one name of the model that it is made of.
    owner: String,
    formula: Formula,
    /// The owner by the role; `None` where the role is a name alone.
    inverse: Option<Expression>,
    /// What the role is called as a quantity, and what the owner's own definition is called then.
    quantity: String,
    own: String,
}

/// The roles of a model file; `taken` are its names and the sections that gave them.
pub(super) fn declared(
    taken: &HashMap<String, &'static str>,
    angles: &HashSet<String>,
    root: &Section<'_>,
) -> Vec<Written> {
    let mut all: Vec<Written> = Vec::new();
    for item in root.section("roles").iter().flat_map(Section::entries) {
        all.extend(written((taken, angles), &item, None, &all));
    }
    for item in root.section("heads").iter().flat_map(Section::entries) {
        let Some((head, _)) = checked(&item, fault_of_owner(item.key())) else { continue };
        let Some(names) = item.section(&format!("the head `{head}`")) else { continue };
        for item in names.entries() {
            all.extend(written((taken, angles), &item, Some(&head), &all));
        }
    }
    all
}

fn written(
    (taken, angles): (&HashMap<String, &'static str>, &HashSet<String>),
    item: &Item<'_>,
    head: Option<&str>,
    before: &[Written],
) -> Option<Written> {
    let (role, _) = checked(item, fault_of(item.key()))?;
    if let (None, Some(section)) = (head, taken.get(&role)) {
        let message = format!("the name `{role}` is already taken in [{section}]");
        item.error_at_key(message, "effects find it by that name: leave this role out");
        return None;
    }
    let formula = item.formula()?;
    let root = &formula.root;
    let names = root.names().into_iter().map(|(name, _)| name.to_owned());
    let names: Vec<String> = names.filter(|name| name != "pi").collect();
    if let Some(unknown) = names.iter().find(|name| !taken.contains_key(*name)) {
        let message = format!("there is no input, parameter, quantity or measurand `{unknown}`");
        let near = nearest(unknown, taken.keys().map(String::as_str));
        let help = near.map(|near| format!("did you mean `{near}`?")).unwrap_or_default();
        item.error(message, &help);
        return None;
    }
    if names.is_empty() {
        item.error(
            "a role is a name of the model, or a formula of one",
            "as in \"90 deg - elevation\"",
        );
        return None;
    }
    if let Some((at, number)) = bare_angle(root, &|name| angles.contains(name)) {
        let fault = Diagnostic::error(format!("`{number}` has no unit beside an angle"));
        let place = formula.source.place(at.span.shifted(formula.offset));
        let help = format!("write `{number} deg`, or another unit of angles");
        item.report(fault.at(place).help(help));
        return None;
    }
    let quantity = head.map_or_else(|| role.clone(), |head| format!("{role}_{head}"));
    let owner = names.first().cloned().unwrap_or_default();
    let mut one = Written {
        head: head.map(str::to_owned),
        own: format!("{owner}_without_role"),
        inverse: None,
        role,
        owner,
        quantity,
        formula,
    };
    if matches!(one.formula.root.kind, ExpressionKind::Name(_)) {
        return Some(one);
    }
    let made = Expression {
        kind: ExpressionKind::Name(one.quantity.clone()),
        span: one.formula.root.span,
    };
    one.inverse = isolated(&one.formula.root, &one.owner, made);
    if one.inverse.is_none() {
        item.error(
            format!("the role `{}` cannot be turned round to a name of the model", one.role),
            "it is a name of the model, or one name in sums, differences, products and quotients with numbers, as in \"90 deg - elevation\"",
        );
        return None;
    }
    let is_made = |other: &Written| other.inverse.is_some() && other.owner == one.owner;
    if before.iter().any(is_made) {
        let message = format!("`{}` has a role by a formula already", one.owner);
        item.error(message, "state a quantity in [quantities] and use it in both");
        return None;
    }
    let is_taken = |name: &String| {
        let makes = |other: &Written| {
            let made = other.inverse.is_some() && (other.quantity == *name || other.own == *name);
            made || (other.head.is_none() && other.role == *name)
        };
        taken.contains_key(name) || before.iter().any(makes)
    };
    if let Some(name) = [&one.quantity, &one.own].into_iter().find(|name| is_taken(name)) {
        item.error(format!("the name `{name}` is taken, but this role needs it"), "rename that");
        return None;
    }
    let at = |owner: f64| {
        let value = |name: &str| (name == one.owner).then_some(owner);
        one.formula.root.value(&value).filter(|value| value.is_finite())
    };
    let is_invertible = at(PROBES[0]).zip(at(PROBES[1])).is_some_and(|(a, b)| a != b);
    if !is_invertible {
        let message = format!("the role `{}` does not change with `{}`", one.role, one.owner);
        item.error(
            message,
            "a role is another way to state one name, as in \"90 deg - elevation\"",
        );
        return None;
    }
    Some(one)
}

/// Gives a model its roles.
pub(super) fn give(model: &mut Model, roles: Vec<Written>) {
    for Written { head, role, owner, formula, inverse, quantity, own } in roles {
        let value = if inverse.is_some() { quantity.clone() } else { owner.clone() };
        if let Some(inverse) = inverse {
            go_through(model, &owner, &own, (quantity, formula), inverse);
        }
        let roles = match head {
            None => &mut model.roles,
            Some(head) => model.heads.entry(head).or_default(),
        };
        roles.insert(role, Role { value, owner });
    }
}

/// Lets a name of the model go through a quantity made of it: `owner = inverse(quantity)`,
/// `quantity = formula(own)`, `own` as `owner` was.
fn go_through(
    model: &mut Model,
    owner: &str,
    own: &str,
    (quantity, mut formula): (String, Formula),
    inverse: Expression,
) {
    let back = Formula { root: inverse, ..formula.clone() };
    if let Some(measurand) = model.measurands.iter_mut().find(|one| one.name == owner) {
        let definition = std::mem::replace(&mut measurand.formula, back);
        model.quantities.insert(own.to_owned(), definition);
    } else if let Some(definition) = model.quantities.get_mut(owner) {
        let definition = std::mem::replace(definition, back);
        model.quantities.insert(own.to_owned(), definition);
    } else {
        // Of an input or a parameter every use goes through the quantity.
        for other in model.formulas_mut() {
            rename(&mut other.root, owner, own);
        }
        model.quantities.insert(own.to_owned(), back);
        model.quantities.insert(quantity, formula);
        return;
    }
    rename(&mut formula.root, owner, own);
    model.quantities.insert(quantity, formula);
}
