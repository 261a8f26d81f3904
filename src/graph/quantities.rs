//! The kind and the dimension of each named quantity, without effects.

use crate::graph::context::{Moment, Resolver};
use crate::graph::layers::Named;
use crate::graph::{Kind, Names};
use crate::units::Dimension;

/// The named quantities, each with its kind and its dimension; those with a fault are left out.
pub fn quantities(names: &Names) -> impl Iterator<Item = (&str, Kind, Dimension)> {
    let mut resolver = Resolver::new(names);
    let moment = match names.measurands.is_empty() {
        true => Moment::Reference { readings: false },
        false => Moment::Of(0),
    };
    let context = resolver.context(moment, false);
    let all = names.quantities.iter().enumerate();
    all.filter_map(move |(number, (name, formula))| {
        let at = (formula, formula.root.span);
        let found = resolver.resolve(Named::Quantity(number), &context, at).ok()?;
        Some((name.as_str(), found.kind(), found.dimension))
    })
}
