//! The rows of every sample by the pointwise engine: what the lanes must equal.
//!
//! Forward mode in chunks of directions over numbers that carry derivatives; slow, and the
//! definition.

use nalgebra::DMatrix;

use crate::campaign::Sample;
use crate::engine::part::SampleLeaves;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::visits::Visitor;
use crate::number::{Gradient, Number, partials};

/// Directions in one pass of the engine.
const CHUNK: usize = 8;

impl Problem {
    /// What [`Problem::visit_run`] says, computed sample by sample over dual numbers.
    pub fn visit_run_pointwise(
        &self,
        p: usize,
        run: usize,
        point: &Point,
        visit: &mut Visitor<'_>,
    ) {
        let part = &self.parts[p];
        let tangents = self.tangents(p, run);
        let touched = self.layout.columns.touched_by(self.run_index(p, run));
        // For each tangent, the local columns that move it.
        let movers: Vec<Vec<(usize, f64)>> = tangents
            .iter()
            .map(|(instance, component)| {
                self.layout
                    .columns_of(*instance, *component)
                    .into_iter()
                    .filter_map(|(column, coefficient)| {
                        Some((touched.iter().position(|t| *t == column)?, coefficient))
                    })
                    .collect()
            })
            .collect();
        let chunks: Vec<Vec<[Gradient<CHUNK>; 4]>> =
            chunked(&tangents).map(|chunk| self.seeded_parameters(p, run, point, chunk)).collect();
        let randoms = vec![Gradient::<CHUNK>::constant(0.0); part.random_sigma.len()];
        let mut workspace = Vec::new();
        let mut jacobian = DMatrix::zeros(part.residual_count(), touched.len());
        let mut values = vec![0.0; part.residual_count()];
        let mut each = |sample: Sample<'_>| {
            jacobian.fill(0.0);
            values.fill(0.0);
            for (number, parameters) in chunks.iter().enumerate() {
                let leaves =
                    SampleLeaves { parameters, randoms: &randoms, columns: part.columns(), sample };
                let outputs = part.evaluate(&leaves, &mut workspace);
                for slot in part.slots() {
                    if !part.is_present(sample, slot) {
                        continue;
                    }
                    let residual = part.residual(sample, slot, outputs);
                    for (component, residual) in residual.iter().take(slot.components).enumerate() {
                        let row = slot.residual + component;
                        values[row] = residual.value();
                        let first = number * CHUNK;
                        for (movers, slope) in movers.iter().skip(first).zip(partials(residual)) {
                            for (column, coefficient) in movers {
                                jacobian[(row, *column)] -= coefficient * slope;
                            }
                        }
                    }
                }
            }
            visit(sample.number, &jacobian, &values);
        };
        part.runs[run].record.walk(|stretch| stretch.each().for_each(&mut each));
    }
}

/// Directions by chunks of the engine; one empty chunk where there are none, for the values.
fn chunked(tangents: &[(usize, usize)]) -> impl Iterator<Item = &[(usize, usize)]> {
    let empty = tangents.is_empty().then_some(tangents);
    tangents.chunks(CHUNK).chain(empty)
}
