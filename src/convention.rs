//! A convention that programs differ in, as its author declares it: one TOML file,
//! `docs/formats.md` section 3.
//!
//! Answers: what each logged number means if the convention was mistaken, as a formula of the
//! numbers as they were read. Whether it was is [`crate::estimate::conventions`]' business.

use crate::diagnostic::{Diagnostics, Source};
use crate::document::Reader;
use crate::formula::Formula;
use crate::formula::isolate::replaced;
use crate::formula::show::text;
use crate::units::Unit;

/// What a convention is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// One number.
    Number,
    /// Two numbers of the same kind.
    Pair,
    /// The three coordinates of a vector.
    Vector,
    /// The four components of a quaternion.
    Quaternion,
    /// A position and an attitude.
    Pose,
}

/// The words for forms, and what their numbers are called.
const FORMS: &[(&str, Form)] = &[
    ("number", Form::Number),
    ("pair", Form::Pair),
    ("vector", Form::Vector),
    ("quaternion", Form::Quaternion),
    ("pose", Form::Pose),
];

impl Form {
    /// What the numbers are called in formulas, in their order.
    pub fn components(self) -> &'static [&'static str] {
        match self {
            Self::Number => &["value"],
            Self::Pair => &["first", "second"],
            Self::Vector => &["x", "y", "z"],
            Self::Quaternion => &["w", "x", "y", "z"],
            Self::Pose => &["x", "y", "z", "qw", "qx", "qy", "qz"],
        }
    }
}

/// A convention file, read and checked for form.
#[derive(Clone, Debug)]
pub struct Convention {
    /// Its name.
    pub name: String,
    /// What is mistaken for what, in words.
    pub title: String,
    /// The file.
    pub source: Source,
    /// What it is about.
    pub form: Form,
    /// The kind of unit that its numbers have, if that matters.
    pub unit: Option<Unit>,
    /// The unit in whose place another one stands: it is about columns of that unit alone. No file
    /// of a convention states it.
    pub head: Option<Unit>,
    /// What each of [`Form::components`] is, of the numbers as they were read.
    pub formulas: Vec<Formula>,
}

impl Convention {
    /// Reads a convention file.
    ///
    /// # Errors
    /// Every fault of its form, with its place.
    pub fn parse(source: Source) -> Result<Self, Diagnostics> {
        let reader = Reader::new(&source);
        let table = reader.parse()?;
        let root = reader.root(&table, "a convention");
        let text = |key: &'static str| {
            let text = root.require(key)?.string()?;
            Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
        };
        let (name, title) = (text("name"), text("title"));
        let form = root.require("of").and_then(|item| item.choice(FORMS));
        let unit = root.get("unit").and_then(|item| item.unit());
        let lines = root.section("as");
        let mut formulas = Vec::new();
        for component in form.map_or(&[][..], Form::components) {
            let Some(item) = lines.as_ref().and_then(|lines| lines.require(component)) else {
                continue;
            };
            let Some(formula) = item.formula() else { continue };
            let of_numbers = |name: &str| form?.components().contains(&name).then_some(0.25);
            if formula.root.value(&of_numbers).is_none() {
                let known = form.map_or(&[][..], Form::components).join(", ");
                item.error(
                    "this is no formula of the numbers as they were read",
                    &format!("they are called {known}"),
                );
            }
            formulas.push(formula);
        }
        if lines.is_none() && !reader.has_faults() {
            reader.error(
                root.span(),
                "the convention says nothing",
                "write [as], as in value = '-value'",
            );
        }
        if let Some(lines) = &lines {
            lines.finish();
        }
        root.finish();
        let convention = name.zip(title).zip(form).map(|((name, title), form)| Self {
            name,
            title,
            source: reader.source().clone(),
            form,
            unit,
            head: None,
            formulas,
        });
        reader.into_result(convention)
    }

    /// This convention mistaken for numbers for which another one was mistaken, too; `None` where they
    /// are about other numbers.
    pub fn after(&self, first: &Self) -> Option<Self> {
        let dimension = |one: &Self| one.unit.as_ref().map(|unit| unit.dimension);
        let is_same = |(own, other)| own == other;
        let dimensions = dimension(self).zip(dimension(first));
        if self.form != first.form || !dimensions.is_none_or(is_same) {
            return None;
        }
        let names = self.form.components();
        let of = |name: &str| {
            let at = names.iter().position(|one| *one == name)?;
            Some(first.formulas[at].root.clone())
        };
        let formulas = self.formulas.iter().map(|formula| {
            let root = replaced(&formula.root, &of);
            Formula { text: text(&root), root, ..formula.clone() }
        });
        Some(Self {
            name: format!("{} and {}", first.name, self.name),
            title: format!("{}; {}", first.title, self.title),
            unit: self.unit.clone().or_else(|| first.unit.clone()),
            head: self.head.clone().or_else(|| first.head.clone()),
            formulas: formulas.collect(),
            ..self.clone()
        })
    }
}
