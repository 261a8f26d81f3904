//! The columns that candidates have in the sums, and whose values they are: one for each value that
//! a parameter has over its scope.

use indexmap::IndexMap;

use crate::engine::Problem;
use crate::engine::signatures::{Signature, Signatures};
use crate::graph::Scope;

/// One column: where its signature stands in the sums of which runs.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Column {
    /// Run and index among its signatures, by ascending run.
    pub(in crate::diagnose) at: Vec<(usize, usize)>,
    /// The magnitude that its value usually has, where that is known.
    pub(in crate::diagnose) typical: Option<f64>,
}

/// Length, in units of the noise, that a column must have at the usual size of its value.
const NEGLIGIBLE: f64 = 1e-4;

/// Whether a column of this squared length changes readings at a size that can be: what does not
/// even show at thousands of times its usual size is rounding, such as stamps that are uniform but
/// for their last digit.
pub(in crate::diagnose) fn shows(square: f64, typical: Option<f64>) -> bool {
    typical.is_none_or(|usual| square.is_nan() || usual * square.sqrt() >= NEGLIGIBLE)
}

/// The runs that two lists have, by ascending run, with what each has there.
pub(in crate::diagnose) fn shared<'a>(
    one: &'a [(usize, usize)],
    other: &'a [(usize, usize)],
) -> impl Iterator<Item = (usize, usize, usize)> + 'a {
    let mut rest = other;
    one.iter().filter_map(move |(run, own)| {
        rest = &rest[rest.partition_point(|(known, _)| known < run)..];
        let (_, other) = rest.first().filter(|(known, _)| known == run)?;
        Some((*run, *own, *other))
    })
}

/// Whose value a column is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Owner {
    /// Full name.
    pub parameter: String,
    /// Component of its tangent space.
    pub component: usize,
    /// Whose it is: as [`Instance::whose`](crate::engine::layout::Instance::whose).
    pub of: Option<String>,
}

/// The columns of each of so many candidates, from their signatures in each campaign: one for each
/// value that a signature's scope has.
pub(in crate::diagnose) fn joined(
    problem: &Problem,
    signed: &[Signatures],
    candidates: usize,
) -> Vec<IndexMap<Owner, Column>> {
    let mut all = vec![IndexMap::new(); candidates];
    for (part, signatures) in signed.iter().enumerate() {
        for (index, signature) in signatures.columns.iter().enumerate() {
            let own = &mut all[signature.candidate];
            for run in 0..problem.parts[part].runs.len() {
                let new = || Column { at: Vec::new(), typical: signature.typical };
                let column: &mut Column =
                    own.entry(owner_in(problem, part, run, signature)).or_insert_with(new);
                column.at.push((problem.run_index(part, run), index));
            }
        }
    }
    all
}

/// Whose value a signature is in a run.
pub(in crate::diagnose) fn owner_in(
    problem: &Problem,
    part: usize,
    run: usize,
    signature: &Signature,
) -> Owner {
    let data = &problem.parts[part];
    let label = |name: &str| data.qualified(name);
    let of = match signature.scope {
        Scope::Rig => data.rig.clone().or_else(|| data.label.clone()),
        Scope::Instrument => data.instrument.clone().or_else(|| data.label.clone()),
        Scope::Setup => Some(label(&data.setups[data.runs[run].setup])),
        Scope::Run | Scope::Sample => Some(label(&data.runs[run].name)),
    };
    Owner { parameter: signature.parameter.clone(), component: signature.component, of }
}
