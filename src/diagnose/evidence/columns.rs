//! The columns that candidates have in the sums, and whose values they are: one for each value that
//! a parameter has over its scope.

use crate::engine::Problem;
use crate::engine::layout::qualified;
use crate::engine::signatures::Signature;
use crate::graph::Scope;

/// One column: where its signature stands in the sums of which runs.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Column {
    /// Run and index among its signatures, by ascending run.
    pub(in crate::diagnose) at: Vec<(usize, usize)>,
    /// The magnitude that its value usually has, where that is known.
    pub(in crate::diagnose) typical: Option<f64>,
}

impl Column {
    /// The runs in which two columns act, with where each stands there.
    pub(super) fn beside<'a>(
        &'a self,
        other: &'a Self,
    ) -> impl Iterator<Item = (usize, usize, usize)> + 'a {
        let mut rest = &other.at[..];
        self.at.iter().filter_map(move |(run, own)| {
            rest = &rest[rest.partition_point(|(known, _)| known < run)..];
            let (_, other) = rest.first().filter(|(known, _)| known == run)?;
            Some((*run, *own, *other))
        })
    }
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
pub(in crate::diagnose) fn join(
    problem: &Problem,
    part: usize,
    index: usize,
    signature: &Signature,
    columns: &mut Vec<(Owner, Column)>,
) {
    for run in 0..problem.parts[part].runs.len() {
        let owner = owner_in(problem, part, run, signature);
        let at = (problem.run_index(part, run), index);
        match columns.iter_mut().find(|(known, _)| *known == owner) {
            Some((_, column)) => column.at.push(at),
            None => columns.push((owner, Column { at: vec![at], typical: signature.typical })),
        }
    }
}

/// Whose value a signature is in a run.
pub(in crate::diagnose) fn owner_in(
    problem: &Problem,
    part: usize,
    run: usize,
    signature: &Signature,
) -> Owner {
    let data = &problem.parts[part];
    let label = |name: &str| qualified(data.label.as_deref(), name);
    let of = match signature.scope {
        Scope::Rig => data.rig.clone().or_else(|| data.label.clone()),
        Scope::Instrument => data.instrument.clone().or_else(|| data.label.clone()),
        Scope::Setup => Some(label(&data.setups[data.runs[run].setup])),
        Scope::Run | Scope::Sample => Some(label(&data.runs[run].name)),
    };
    Owner { parameter: signature.parameter.clone(), component: signature.component, of }
}
