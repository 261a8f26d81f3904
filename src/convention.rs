//! A convention that programs differ in, as its author declares it: one TOML file,
//! `docs/formats.md` section 3.
//!
//! Answers: what each logged number means if the convention was mistaken, as a formula of the
//! numbers as they were read. Whether it was is [`crate::estimate::conventions`]' business.

use crate::diagnostic::{Diagnostics, Source};
use crate::document::Reader;
use crate::formula::Formula;
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
            formulas,
        });
        reader.into_result(convention)
    }
}
