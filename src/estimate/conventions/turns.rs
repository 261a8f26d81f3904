//! Products of two or three turns about single axes as they are if their order, their axes or their
//! sense was mistaken: Euler angles.
//!
//! Programs agree neither on the order (`Z Y X` of one robot is `X Y Z` of another; about fixed axes
//! the order is the reverse of that about moving ones), nor on which angle belongs to which axis, nor
//! on whether the product or its inverse is meant; some write the components of a rotation vector. The model's formulas are rewritten, not its
//! columns. Products of more turns are kinematic chains, whose order is a matter of construction.

use crate::engine::rows::Sweep;
use crate::engine::{Part, Problem};
use crate::formula::ast::BinaryOperator;
use crate::formula::isolate::replaced_parts;
use crate::formula::show::text;
use crate::formula::{Expression, ExpressionKind, Formula, Function};
use crate::graph::{Names, assemble};

/// Turns of a product that is rewritten.
const COUNTS: [usize; 2] = [2, 3];
/// The orders of two and of three, as they are first.
const ORDERS_OF_TWO: &[&[usize]] = &[&[0, 1], &[1, 0]];
const ORDERS_OF_THREE: &[&[usize]] =
    &[&[0, 1, 2], &[2, 1, 0], &[0, 2, 1], &[1, 0, 2], &[1, 2, 0], &[2, 0, 1]];

/// A product of turns, and what may have been meant instead.
#[derive(Clone, Debug)]
pub(super) struct Reordered {
    /// `order_of_turns`, `axes_of_turns`, `angles_of_turns`, `inverse_turns` or `rotation_vector`.
    pub(super) name: &'static str,
    /// What is mistaken, in words.
    about: &'static str,
    /// The factors as they stand, as text.
    factors: Vec<String>,
    /// What may have been meant.
    meant: Vec<Expression>,
    /// The formulas in which the product stands.
    pub(super) places: Vec<String>,
}

/// A formula of the model that is to be changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChangedFormula {
    /// The table of the model in which it stands: `quantities`, `measurands`, `coordinates`.
    pub table: &'static str,
    /// Its name there.
    pub name: String,
    /// What it should be.
    pub formula: String,
}

impl Reordered {
    /// All that may have been meant by the products of a model.
    pub(super) fn all(names: &Names) -> Vec<Self> {
        let mut products: Vec<Vec<Turn>> = Vec::new();
        for (_, _, formula) in formulas(names) {
            formula.root.visit(&mut |part| products.extend(runs(part, names)));
        }
        // Of a longer product the tree has shorter ones within.
        let texts: Vec<Vec<String>> = products.iter().map(|one| written(one)).collect();
        let is_within = |one: &[String]| {
            let longer = |other: &&Vec<String>| other.len() > one.len();
            texts
                .iter()
                .filter(longer)
                .any(|other| other.windows(one.len()).any(|part| part == one))
        };
        let mut all: Vec<Self> = Vec::new();
        for (at, product) in products.iter().enumerate() {
            let moving = product.iter().filter(|turn| follows_input(&turn.angle, names)).count();
            if texts[..at].contains(&texts[at])
                || is_within(&texts[at])
                || !COUNTS.contains(&product.len())
                || moving < 2
            {
                continue;
            }
            all.extend(Self::of(product, &texts[at], names));
        }
        all
    }

    /// All that may have been meant by one product, each once.
    fn of(product: &[Turn], factors: &[String], names: &Names) -> Vec<Self> {
        let orders = if product.len() == 2 { ORDERS_OF_TWO } else { ORDERS_OF_THREE };
        let places: Vec<String> = formulas(names)
            .filter(|(_, _, formula)| exchanged(&formula.root, factors, &[]).is_some())
            .map(|(_, name, _)| name.to_owned())
            .collect();
        let mut all: Vec<Self> = Vec::new();
        let mut seen = vec![factors.to_vec()];
        let mut add = |name, about, meant: Vec<Expression>| {
            let shown: Vec<String> = meant.iter().map(text).collect();
            if seen.contains(&shown) {
                return;
            }
            seen.push(shown);
            all.push(Self {
                name,
                about,
                factors: factors.to_vec(),
                meant,
                places: places.clone(),
            });
        };
        let turn = |axis: usize, angle: usize| product[axis].about(&product[angle].angle);
        for order in orders {
            let each = |of: &dyn Fn(usize, usize) -> Expression| -> Vec<Expression> {
                order.iter().enumerate().map(|(at, own)| of(at, *own)).collect()
            };
            let last = order.len() - 1;
            add(
                "order_of_turns",
                "order of the turns",
                each(&|_, own| product[own].factor.clone()),
            );
            add("axes_of_turns", "axes of the turns", each(&|at, own| turn(own, at)));
            add("angles_of_turns", "angles of the turns", each(&|at, own| turn(at, own)));
            let back = each(&|at, _| product[order[last - at]].reversed());
            add("inverse_turns", "sense of the turns (the inverse rotation)", back);
        }
        if let Some(vector) = rotation_vector(product) {
            add("rotation_vector", "angles that are components of a rotation vector", vec![vector]);
        }
        all
    }

    /// What is mistaken for what.
    pub(super) fn title(&self) -> String {
        let meant: Vec<String> = self.meant.iter().map(text).collect();
        format!("{}: {} in place of {}", self.about, meant.join(" * "), self.factors.join(" * "))
    }

    /// How much it says, beyond what stands there.
    pub(super) fn length(&self) -> usize {
        self.meant.iter().map(|one| text(one).len()).sum()
    }

    /// The problem with the product changed in every model that has it; `None` where none has.
    pub(super) fn applied(&self, problem: &Problem) -> Option<Problem> {
        let mut changed = problem.clone();
        let mut is_changed = false;
        for part in &mut changed.parts {
            if let Some(other) = self.in_part(part) {
                *part = other;
                is_changed = true;
            }
        }
        if !is_changed {
            return None;
        }
        changed.compute_with(changed.instruction_set(), Sweep::Backward);
        Some(changed)
    }

    fn in_part(&self, part: &Part) -> Option<Part> {
        let mut names = part.system.assembly.names.clone();
        let mut is_changed = false;
        for formula in formulas_mut(&mut names) {
            let Some(root) = exchanged(&formula.root, &self.factors, &self.meant) else { continue };
            formula.text = text(&root);
            formula.root = root;
            is_changed = true;
        }
        if !is_changed {
            return None;
        }
        let mut system = part.system.clone();
        system.assembly = assemble(names).ok()?;
        Some(part.with_system(system))
    }
}

/// The formulas that differ between two problems of the same models, each once.
pub(super) fn changed_formulas(before: &Problem, after: &Problem) -> Vec<ChangedFormula> {
    let mut all: Vec<ChangedFormula> = Vec::new();
    for (old, new) in before.parts.iter().zip(&after.parts) {
        let old = formulas(&old.system.assembly.names);
        for (one, (table, name, formula)) in old.zip(formulas(&new.system.assembly.names)) {
            let formula = text(&formula.root);
            let changed = ChangedFormula { table, name: name.to_owned(), formula };
            if changed.formula != text(&one.2.root) && !all.contains(&changed) {
                all.push(changed);
            }
        }
    }
    all
}

/// A turn about one axis.
struct Turn {
    function: Function,
    angle: Expression,
    /// As it stands: the turn itself, or the name of a quantity that is one.
    factor: Expression,
}

impl Turn {
    fn of(factor: &Expression, names: &Names) -> Option<Self> {
        let own = match &factor.kind {
            ExpressionKind::Name(name) => &names.quantities.get(name)?.root,
            _ => factor,
        };
        let ExpressionKind::Call(function, arguments) = &own.kind else { return None };
        let is_turn =
            matches!(function, Function::RotationX | Function::RotationY | Function::RotationZ);
        let angle = arguments.first().filter(|_| is_turn)?.clone();
        Some(Self { function: *function, angle, factor: factor.clone() })
    }

    /// A turn about the same axis by another angle.
    fn about(&self, angle: &Expression) -> Expression {
        let kind = ExpressionKind::Call(self.function, vec![angle.clone()]);
        Expression { kind, span: self.factor.span }
    }

    /// The turn back.
    fn reversed(&self) -> Expression {
        let angle = match &self.angle.kind {
            ExpressionKind::Negate(inner) => (**inner).clone(),
            _ => Expression {
                kind: ExpressionKind::Negate(Box::new(self.angle.clone())),
                span: self.angle.span,
            },
        };
        self.about(&angle)
    }
}

/// The turn by a vector whose components are the angles about x, y and z; `None` where each axis is
/// not there once.
fn rotation_vector(product: &[Turn]) -> Option<Expression> {
    let axes = [Function::RotationX, Function::RotationY, Function::RotationZ];
    let angle = |axis: Function| {
        let mut of_axis = product.iter().filter(|turn| turn.function == axis);
        of_axis.next().map(|turn| turn.angle.clone()).filter(|_| of_axis.next().is_none())
    };
    let angles: Option<Vec<Expression>> = axes.into_iter().map(angle).collect();
    let span = product.first()?.factor.span;
    let vector = Expression { kind: ExpressionKind::Vector(angles?.try_into().ok()?), span };
    Some(Expression { kind: ExpressionKind::Call(Function::Turn, vec![vector]), span })
}

fn written(product: &[Turn]) -> Vec<String> {
    product.iter().map(|turn| text(&turn.factor)).collect()
}

/// The factors of a product, from left to right.
fn factors(expression: &Expression) -> Vec<&Expression> {
    match &expression.kind {
        ExpressionKind::Binary(BinaryOperator::Multiply, left, right) => {
            [factors(left), factors(right)].concat()
        }
        _ => vec![expression],
    }
}

/// Neighbouring turns about single axes in a product.
fn runs(expression: &Expression, names: &Names) -> Vec<Vec<Turn>> {
    let mut all = vec![Vec::new()];
    for factor in factors(expression) {
        match (Turn::of(factor, names), all.last_mut()) {
            (Some(turn), Some(run)) => run.push(turn),
            _ => all.push(Vec::new()),
        }
    }
    all.retain(|run| run.len() > 1);
    all
}

/// The formula with other factors in the place of these; `None` where they do not stand there.
fn exchanged(root: &Expression, seek: &[String], by: &[Expression]) -> Option<Expression> {
    let is_changed = std::cell::Cell::new(false);
    let of = |part: &Expression| {
        let all = factors(part);
        let texts: Vec<String> = all.iter().map(|one| text(one)).collect();
        let at = texts.windows(seek.len()).position(|some| some == seek)?;
        is_changed.set(true);
        let after = &all[at + seek.len()..];
        let product = all[..at].iter().copied().chain(by).chain(after.iter().copied()).cloned();
        product.reduce(|left, right| {
            let span = left.span;
            let (left, right) = (Box::new(left), Box::new(right));
            let kind = ExpressionKind::Binary(BinaryOperator::Multiply, left, right);
            Expression { kind, span }
        })
    };
    let changed = replaced_parts(root, &of);
    is_changed.get().then_some(changed)
}

/// Whether a formula follows an input, over whatever quantities.
fn follows_input(formula: &Expression, names: &Names) -> bool {
    formula.names().iter().any(|(name, _)| {
        let quantity = names.quantities.get(*name);
        names.inputs.iter().any(|input| input.name == *name)
            || quantity.is_some_and(|one| follows_input(&one.root, names))
    })
}

/// The formulas of a model with their tables and names.
fn formulas(names: &Names) -> impl Iterator<Item = (&'static str, &str, &Formula)> {
    let quantities = names.quantities.iter().map(|(name, one)| ("quantities", name.as_str(), one));
    let measurands = names.measurands.iter();
    let measurands = measurands.map(|one| ("measurands", one.name.as_str(), &one.formula));
    let from = names.coordinates.iter().map(|one| ("coordinates", "from", &one.from));
    quantities.chain(measurands).chain(from)
}

/// The same, in the same order, to be changed.
fn formulas_mut(names: &mut Names) -> impl Iterator<Item = &mut Formula> {
    let measurands = names.measurands.iter_mut().map(|one| &mut one.formula);
    let from = names.coordinates.iter_mut().map(|one| &mut one.from);
    names.quantities.values_mut().chain(measurands).chain(from)
}
