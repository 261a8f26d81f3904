//! Rows of the budget, and change points, that are in the fit.

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::place::Place;
use crate::diagnose::library::variant::Variant;
use crate::engine::Point;
use crate::engine::point::from_components;
use crate::system::Selected;

use super::terms::Change;

/// A row of the budget that is in the fit, or a change point.
#[derive(Clone, Debug)]
pub struct Row {
    /// The effect, with its head.
    pub name: String,
    /// The relaxed form that it has, if it is not the library's.
    pub variant: Option<Variant>,
    /// Members of its family that were tried.
    pub members: usize,
    /// Log prior odds.
    pub ln_prior: f64,
    /// The change point that it is, and where that sits, if it is no effect of the library.
    pub change: Option<(Change, Place)>,
}

/// An effect in the fit, by its name with its head.
pub fn effect_of<'f>(fitted: &'f Fitted, name: &str) -> Option<&'f Selected> {
    fitted.recipes.iter().flat_map(|recipe| &recipe.effects).find(|one| one.name() == name)
}

/// How many values the parameters of an effect in the fit have; where they sum to zero there are
/// fewer columns.
pub fn count_of_values(fitted: &Fitted, name: &str) -> usize {
    let prefix = format!("{name}.");
    let layout = &fitted.problem.layout;
    let own =
        (0..layout.instances.len()).filter(|one| layout.instances[*one].name.starts_with(&prefix));
    let values = own.flat_map(|one| (0..layout.instances[one].dimension()).map(move |k| (one, k)));
    values.filter(|(one, k)| !layout.columns_of(*one, *k).is_empty()).count()
}

/// A point at which an effect in the fit is absent: its values are zero.
pub fn absent(fitted: &Fitted, name: &str, mut point: Point) -> Point {
    let prefix = format!("{name}.");
    let of = point.values.iter_mut().zip(&fitted.problem.layout.instances);
    for (value, instance) in of.filter(|(_, one)| one.name.starts_with(&prefix)) {
        *value = from_components(instance.kind, &[0.0; 3]);
    }
    point
}

/// The columns of an effect in the fit, with their values.
pub fn columns_of(fitted: &Fitted, name: &str) -> Vec<(usize, f64)> {
    let (layout, point) = (&fitted.problem.layout, &fitted.fit.point);
    let prefix = format!("{name}.");
    let mut own: Vec<usize> = Vec::new();
    for (index, instance) in layout.instances.iter().enumerate() {
        if instance.name.starts_with(&prefix) {
            let columns = (0..instance.dimension()).flat_map(|k| layout.columns_of(index, k));
            own.extend(columns.map(|(column, _)| column));
        }
    }
    own.sort_unstable();
    own.dedup();
    let step = absent(fitted, name, point.clone()).step_to(layout, point);
    own.into_iter().map(|column| (column, step[column])).collect()
}
