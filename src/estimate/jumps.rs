//! Whether a campaign's model may jump: a formula of it, or of its effects, has a sign or an absolute
//! value. A fit may end near its solution there, and never at it.

use crate::engine::Problem;
use crate::formula::{ExpressionKind, Formula, Function};

/// Whether a formula of the model or of an effect in use has `sign` or `abs`.
pub fn may_jump(problem: &Problem) -> bool {
    let jumps = |formula: &Formula| {
        let mut found = false;
        formula.root.visit(&mut |one| {
            found |= matches!(one.kind, ExpressionKind::Call(Function::Sign | Function::Abs, _));
        });
        found
    };
    problem.parts.iter().any(|part| {
        let names = &part.system.assembly.names;
        let patches = names.layers.iter().flat_map(|layer| &layer.patches);
        let measured = names.measurands.iter().map(|one| &one.formula);
        let all = names.quantities.values().chain(measured);
        all.chain(patches.map(|patch| &patch.formula)).any(jumps)
    })
}
