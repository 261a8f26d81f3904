//! The columns that candidates have in the sums, and whose values they are: one for each value that a
//! parameter has over its scope.

use crate::engine::Problem;
use crate::engine::layout::qualified;
use crate::engine::signatures::Signature;
use crate::graph::Scope;

/// One column: where its signature stands in the sums of which runs.
#[derive(Clone, Debug)]
pub(super) struct Column {
    /// Run and index among its signatures.
    pub(super) at: Vec<(usize, usize)>,
    /// The magnitude that its value usually has, where that is known.
    pub(super) typical: Option<f64>,
}

/// Some columns and whose values they are.
pub(super) type Owned = (Vec<Owner>, Vec<Column>);

/// Whose value a column is.
#[derive(Clone, Debug, PartialEq)]
pub struct Owner {
    /// Full name.
    pub parameter: String,
    /// Component of its tangent space.
    pub component: usize,
    /// Whose it is: as [`Instance::whose`](crate::engine::layout::Instance::whose).
    pub of: Option<String>,
}

/// Gives a signature its columns: one for each value that its scope has in the campaign.
pub(super) fn join(
    problem: &Problem,
    part: usize,
    index: usize,
    signature: &Signature,
    columns: &mut Vec<(Owner, Column)>,
) {
    let data = &problem.parts[part];
    let label = |name: &str| qualified(data.label.as_deref(), name);
    for (run, one) in data.runs.iter().enumerate() {
        let of = match signature.scope {
            Scope::Rig => data.rig.clone().or_else(|| data.label.clone()),
            Scope::Instrument => data.instrument.clone().or_else(|| data.label.clone()),
            Scope::Setup => Some(label(&data.setups[one.setup])),
            Scope::Run | Scope::Sample => Some(label(&one.name)),
        };
        let (parameter, component) = (signature.parameter.clone(), signature.component);
        let owner = Owner { parameter, component, of };
        let at = (problem.run_index(part, run), index);
        match columns.iter_mut().find(|(known, _)| *known == owner) {
            Some((_, column)) => column.at.push(at),
            None => columns.push((owner, Column { at: vec![at], typical: signature.typical })),
        }
    }
}
