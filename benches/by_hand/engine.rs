//! The engine in every way it computes: each instruction set of this processor, each sweep.

use homepoint::engine::Problem;
use homepoint::engine::lanes::InstructionSet;
use homepoint::engine::rows::Sweep;

/// A problem that is computed one way.
#[derive(Clone, Debug)]
pub(crate) struct Engine {
    /// `AVX2, adjoint sweep`.
    pub(crate) name: String,
    pub(crate) problem: Problem,
}

impl Engine {
    /// The widest instruction set first.
    pub(crate) fn all(problem: &Problem, sweeps: &[Sweep]) -> Vec<Self> {
        let mut all = Vec::new();
        for set in InstructionSet::available().into_iter().rev() {
            for sweep in sweeps {
                let word = match sweep {
                    Sweep::Backward => "adjoint",
                    Sweep::Forward => "forward",
                };
                let mut problem = problem.clone();
                problem.compute_with(set, *sweep);
                all.push(Self { name: format!("homepoint, {}, {word}", set.name()), problem });
            }
        }
        all
    }
}
