//! Reads a model file; every fault is reported with its place, and as many as there are.
//!
//! Checked here: form, names, units, values. Whether the formulas fit together is found when the
//! graph is assembled.

use std::collections::HashMap;

use indexmap::IndexMap;

use crate::diagnostic::{Diagnostics, Source, Span, nearest};
use crate::document::{Item, Reader, Section};
use crate::formula::Formula;
use crate::graph::{MeasurandKind, Scope};
use crate::model::name::{checked, fault_of, fault_of_owner};
use crate::model::parameter::{declaration_of, override_of, said_of};
use crate::model::roles;
use crate::model::{
    Coordinates, DelayGroup, InputDeclaration, MeasurandDeclaration, Model, Override,
    ParameterDeclaration, Roles, Setting,
};
use crate::units::Unit;

impl Model {
    /// Reads a model file.
    ///
    /// # Errors
    /// Every fault of its form, with its place.
    pub fn parse(source: Source) -> Result<Self, Diagnostics> {
        let reader = Reader::new(&source);
        let table = reader.parse()?;
        let model =
            Body { reader: &reader, taken: HashMap::new() }.read(&reader.root(&table, "a model"));
        reader.into_result(model)
    }

    /// All formulas, to be changed.
    pub(super) fn formulas_mut(&mut self) -> impl Iterator<Item = &mut Formula> {
        let coordinates = self.coordinates.iter_mut().flat_map(|coordinates| {
            let named = [&mut coordinates.from, &mut coordinates.measured].into_iter();
            named.chain(&mut coordinates.gap).chain(coordinates.helpers.values_mut())
        });
        let measurands = self.measurands.iter_mut();
        let measurands = measurands
            .flat_map(|one| std::iter::once(&mut one.formula).chain(&mut one.sigma_formula));
        self.quantities.values_mut().chain(measurands).chain(coordinates)
    }

    /// All formulas: of quantities, measurands and coordinates.
    pub fn formulas(&self) -> impl Iterator<Item = &Formula> {
        let coordinates = self.coordinates.iter().flat_map(|coordinates| {
            let named = [&coordinates.from, &coordinates.measured].into_iter();
            named.chain(&coordinates.gap).chain(coordinates.helpers.values())
        });
        let measurands = self.measurands.iter();
        let measurands =
            measurands.flat_map(|one| std::iter::once(&one.formula).chain(&one.sigma_formula));
        self.quantities.values().chain(measurands).chain(coordinates)
    }
}

/// What kinds of measurands there are, without their periods.
#[derive(Clone, Copy, PartialEq, Eq)]
enum KindWord {
    Plain,
    Angle,
    Rotation,
}

const KINDS: &[(&str, KindWord)] =
    &[("plain", KindWord::Plain), ("angle", KindWord::Angle), ("rotation", KindWord::Rotation)];

struct Body<'r> {
    reader: &'r Reader<'r>,
    /// Names given so far, and the section that gave them.
    taken: HashMap<String, &'static str>,
}

impl<'r> Body<'r> {
    fn read(&mut self, root: &Section<'r>) -> Option<Model> {
        let name = root.require("name").and_then(|item| {
            let name = item.string()?;
            match fault_of(name) {
                None => Some(name.to_owned()),
                Some((message, help)) => {
                    item.error(message, &help);
                    None
                }
            }
        });
        let text = |key: &'static str| root.get(key).and_then(|item| item.string());
        let title = text("title").unwrap_or("").to_owned();
        let reference = text("source").map(str::to_owned);
        let sections = ["inputs", "parameters", "quantities", "measurands"];
        let [inputs, parameters, quantities, measurands] =
            sections.map(|key| (key, root.section(key)));
        let inputs = self.lines(&inputs, Self::input);
        let mut overrides = Vec::new();
        let parameters = self.parameters(parameters.1.as_ref(), &mut overrides);
        let quantities: IndexMap<String, Formula> = self
            .lines(&quantities, |_, item, name| Some((name, item.formula()?)))
            .into_iter()
            .collect();
        let measurands = self.lines(&measurands, Self::measurand);
        if measurands.is_empty() && !self.reader.has_faults() {
            self.reader.error(
                root.span(),
                "the model has no measurands",
                "say what the instrument reads: [measurands] distance = { value = 'norm(point)', unit = \"m\" }",
            );
        }
        let delays = self.delays(root.section("delays"), &measurands);
        let coordinates =
            root.section("coordinates").and_then(|section| self.coordinates(&section));
        let inputs_of = inputs.iter().map(|one| (&one.name, &one.unit));
        let read = measurands.iter().map(|one| (&one.name, &one.unit));
        let of_model = parameters.iter().map(|one| (&one.name, &one.unit));
        let angles = inputs_of.chain(read).chain(of_model).filter(|(_, unit)| unit.is_angle());
        let angles = angles.map(|(name, _)| name.clone()).collect();
        let roles = roles::declared(&self.taken, &angles, root);
        root.finish();
        let mut model = Model {
            name: name?,
            title,
            reference,
            source: self.reader.source().clone(),
            inputs,
            parameters,
            quantities,
            measurands,
            delays,
            overrides,
            roles: Roles::new(),
            heads: IndexMap::new(),
            coordinates,
        };
        roles::give(&mut model, roles);
        Some(model)
    }

    /// The entries of a section whose keys are new names.
    fn lines<T>(
        &mut self,
        (title, section): &(&'static str, Option<Section<'r>>),
        read: impl Fn(&mut Self, &Item<'r>, String) -> Option<T>,
    ) -> Vec<T> {
        let items: Vec<Item<'r>> = section.iter().flat_map(Section::entries).collect();
        items
            .into_iter()
            .filter_map(|item| {
                let name = self.new_name(&item, title)?;
                read(self, &item, name)
            })
            .collect()
    }

    fn new_name(&mut self, item: &Item<'_>, section: &'static str) -> Option<String> {
        let (name, _) = checked(item, fault_of(item.key()))?;
        if let Some(other) = self.taken.get(&name) {
            let message = format!("the name `{name}` is already taken in [{other}]");
            item.error_at_key(message, "names are unique over all sections");
            return None;
        }
        self.taken.insert(name.clone(), section);
        Some(name)
    }

    fn input(&mut self, item: &Item<'r>, name: String) -> Option<InputDeclaration> {
        let section = item.section(&format!("the input `{name}`"))?;
        let unit = section.get("unit").map_or(Some(Unit::one()), |item| item.unit());
        let signal = section.get("signal").and_then(|item| item.boolean()).unwrap_or(false);
        let positive = |key: &'static str, like: Option<&Unit>| {
            let item = section.get(key)?;
            Some(item.positive(like?)?.0)
        };
        let second = Unit::parse("s").ok();
        let input = InputDeclaration {
            name,
            span: item.key_span(),
            signal,
            period: positive("period", unit.as_ref()),
            sigma: positive("sigma", unit.as_ref()),
            smooth: positive("smooth", second.as_ref()),
            about: about_of(&section),
            unit: unit.unwrap_or_else(Unit::one),
        };
        section.finish();
        Some(input)
    }

    fn parameters(
        &mut self,
        section: Option<&Section<'r>>,
        overrides: &mut Vec<Override>,
    ) -> Vec<ParameterDeclaration> {
        let mut parameters = Vec::new();
        for item in section.iter().flat_map(|section| section.entries()) {
            if item.key().ends_with(".delay") {
                overrides.extend(override_of(self.reader.source(), &item));
                continue;
            }
            let Some(name) = self.new_name(&item, "parameters") else { continue };
            let Some(parameter) = declaration_of(&item, name, Scope::Instrument) else { continue };
            if parameter.per_measurand {
                item.error_at_key(
                    "`per = \"measurand\"` belongs to effects",
                    "declare one parameter for each measurand",
                );
            }
            if let Some(fault) = fault_of_random(&parameter) {
                item.error_at_key(fault.0, fault.1);
            }
            parameters.push(parameter);
        }
        parameters
    }

    fn measurand(&mut self, item: &Item<'r>, name: String) -> Option<MeasurandDeclaration> {
        let section = item.section(&format!("the measurand `{name}`"))?;
        let formula = section.require("value").and_then(|item| item.formula());
        let kind = section.get("kind").map_or(Some(KindWord::Plain), |item| item.choice(KINDS));
        let radian = Unit::parse("rad").ok();
        let unit = match section.get("unit") {
            Some(item) => item.unit().filter(|unit| {
                let fits = kind.is_none_or(|kind| kind == KindWord::Plain) || unit.is_angle();
                if !fits {
                    item.error(
                        format!("`{name}` is an angle, `{}` is not a unit of angles", unit.symbol),
                        "write unit = \"rad\"",
                    );
                }
                fits
            }),
            None if kind.is_some_and(|kind| kind != KindWord::Plain) => radian.clone(),
            None => Some(Unit::one()),
        };
        let period = section.get("period").and_then(|item| {
            if kind != Some(KindWord::Angle) {
                item.error_at_key("only angles have a period", "write kind = \"angle\"");
                return None;
            }
            item.positive(radian.as_ref()?)
        });
        let stated = section.get("sigma");
        let is_formula = stated.as_ref().is_some_and(Item::is_formula);
        let sigma_formula = stated.as_ref().filter(|_| is_formula).and_then(Item::formula);
        let sigma = stated.filter(|_| !is_formula).zip(unit.as_ref());
        let sigma = sigma.and_then(|(item, unit)| item.positive(unit));
        let about = about_of(&section);
        section.finish();
        Some(MeasurandDeclaration {
            name,
            span: item.key_span(),
            formula: formula?,
            kind: match kind? {
                KindWord::Plain => MeasurandKind::Plain,
                KindWord::Angle => {
                    MeasurandKind::Angle { period: period.map_or(0.0, |(value, _)| value) }
                }
                KindWord::Rotation => MeasurandKind::Rotation,
            },
            unit: unit?,
            sigma: sigma.map(|(value, _)| value),
            sigma_formula,
            about,
        })
    }

    fn delays(
        &mut self,
        section: Option<Section<'r>>,
        measurands: &[MeasurandDeclaration],
    ) -> Vec<DelayGroup> {
        let second = Unit::parse("s").ok();
        let mut groups = Vec::new();
        let mut shared: HashMap<String, String> = HashMap::new();
        for item in section.iter().flat_map(Section::entries) {
            let Some((name, span)) = checked(&item, fault_of_owner(item.key())) else { continue };
            if measurands.iter().any(|measurand| measurand.name == name) {
                let message = format!("`{name}` is a measurand and has its own delay");
                item.error_at_key(message, "choose another name for the shared delay");
                continue;
            }
            let Some(section) = item.section(&format!("the shared delay `{name}`")) else {
                continue;
            };
            let of = section.require("of").and_then(|item| item.strings()).unwrap_or_default();
            for (member, span) in &of {
                let known = measurands.iter().map(|measurand| measurand.name.as_str());
                // One whose own entry is faulty is declared all the same.
                let is_declared = self.taken.get(member) == Some(&"measurands");
                if !is_declared && !known.clone().any(|known| known == member) {
                    self.unknown(*span, member, "measurand", known);
                } else if let Some(other) = shared.insert(member.clone(), name.clone()) {
                    let message = format!("`{member}` is already in the shared delay `{other}`");
                    self.reader.error(*span, message, "");
                }
            }
            let said = second
                .as_ref()
                .map(|unit| said_of(&section, Some((unit, crate::graph::Kind::Scalar))));
            let _ = about_of(&section);
            section.finish();
            let mut setting = Setting::of_delay();
            if let Some(said) = said {
                said.apply(&mut setting);
            }
            groups.push(DelayGroup {
                name,
                span,
                of: of.into_iter().map(|(name, _)| name).collect(),
                setting,
            });
        }
        groups
    }

    fn coordinates(&mut self, section: &Section<'r>) -> Option<Coordinates> {
        let point = section.require("point").and_then(|item| item.section("`point`"));
        let mut helpers = IndexMap::new();
        for item in section.entries().filter(|item| item.key() != "point") {
            let Some((name, _)) = checked(&item, fault_of(item.key())) else { continue };
            if let Some(other) = self.taken.get(&name) {
                let message = format!("the name `{name}` is already taken in [{other}]");
                item.error_at_key(message, "choose another name for the helper line");
                continue;
            }
            helpers.extend(item.formula().map(|formula| (name, formula)));
        }
        let point = point?;
        let parameter = |key: &'static str| {
            let item = point.require(key)?;
            let name = item.string()?;
            if self.taken.get(name) == Some(&"parameters") {
                return Some(name.to_owned());
            }
            let known = self.taken.iter().filter(|(_, section)| **section == "parameters");
            self.unknown(item.span(), name, "parameter", known.map(|(name, _)| name.as_str()));
            None
        };
        let (rotation, translation) = (parameter("rotation"), parameter("translation"));
        let formula = |key: &'static str| point.require(key).and_then(|item| item.formula());
        let (from, measured) = (formula("from"), formula("measured"));
        let gap = point.get("gap").and_then(|item| item.formula());
        point.finish();
        Some(Coordinates {
            from: from?,
            rotation: rotation?,
            translation: translation?,
            measured: measured?,
            gap,
            helpers,
        })
    }

    fn unknown<'n>(
        &self,
        span: Span,
        name: &str,
        what: &str,
        known: impl Iterator<Item = &'n str>,
    ) {
        // In a fixed order: the known names may come from a hash table.
        let mut known: Vec<&str> = known.collect();
        known.sort_unstable();
        let help = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("known: {}", known.join(", ")),
        };
        self.reader.error(span, format!("there is no {what} `{name}`"), &help);
    }
}

fn about_of(section: &Section<'_>) -> String {
    section.get("about").and_then(|item| item.string()).unwrap_or("").to_owned()
}

/// What is wrong with a random parameter: message and help.
pub(crate) fn fault_of_random(parameter: &ParameterDeclaration) -> Option<(String, &'static str)> {
    if parameter.setting.scope != Scope::Sample {
        return None;
    }
    if parameter.kind != crate::graph::Kind::Scalar {
        let message =
            format!("`{}` is random (scope = \"sample\") and not a scalar", parameter.name);
        return Some((message, "declare three scalars and put them together in the formula"));
    }
    parameter.setting.sum_zero.then(|| {
        (
            format!("`{}` is random (scope = \"sample\"): its mean is zero anyway", parameter.name),
            "leave out `sum`",
        )
    })
}
