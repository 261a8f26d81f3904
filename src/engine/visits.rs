//! The rows of a run shown one after the other, not whitened: for who wants them and not their
//! sums.

use nalgebra::DMatrix;

use crate::campaign::record::BLOCK;
use crate::campaign::{Sample, Samples, Stretch};
use crate::engine::lanes::{Chunk, LANES, Lanes, Workspace};
use crate::engine::part::ParameterLeaves;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::programs::RowsProgram;

/// What sees the Jacobian and the residuals of each sample.
pub type Visitor<'a> = dyn FnMut(usize, &DMatrix<f64>, &[f64]) + 'a;

/// The same with the sample itself.
pub type SampleVisitor<'a> = dyn FnMut(Sample<'_>, &DMatrix<f64>, &[f64]) + 'a;

/// One row of the samples of a chunk, not whitened.
#[derive(Clone, Copy, Debug)]
pub struct ChunkRows<'a> {
    /// The samples; lanes beyond them mean nothing.
    pub stretch: Stretch<'a>,
    /// Which residual component.
    pub row: usize,
    /// 1 where there is a reading, else 0.
    pub present: &'a Lanes,
    /// The directions on which it hangs, by index.
    pub directions: &'a [usize],
    /// The residual, then its prediction's derivatives along those directions.
    pub lanes: &'a [&'a Lanes],
}

impl Problem {
    /// Shows the rows of a run a chunk at a time, not whitened.
    pub fn visit_rows(
        &self,
        part: usize,
        run: usize,
        point: &Point,
        visit: &mut dyn FnMut(&ChunkRows<'_>),
    ) {
        let program = self.programs[part].rows(&self.parts[part].system.assembly);
        self.visit_program(program, (part, run), point, 1.0, visit);
    }

    fn visit_program(
        &self,
        program: &RowsProgram,
        (part, run): (usize, usize),
        point: &Point,
        share: f64,
        visit: &mut dyn FnMut(&ChunkRows<'_>),
    ) {
        let data = &self.parts[part];
        let record = &data.runs[run].record;
        let code = &program.code;
        let mut workspace = Workspace::new(code, self.set);
        workspace.hold_still(code, &ParameterLeaves(&self.parameters(part, run, point)));
        let (mut weights, mut scratch) = (Vec::new(), Samples::default());
        // A share is taken chunk by chunk; all of a run in larger pieces.
        let step = if share < 1.0 { LANES } else { BLOCK };
        let mut visit_chunk = |chunk: &Chunk<'_>| {
            let there = self.present(part, chunk, &mut weights);
            workspace.load(code, chunk, &weights, there == LANES * data.slots().len());
            for group in 0..code.group_count() {
                workspace.compute(code, group, chunk.inputs());
                for (number, row) in program.rows_of(group) {
                    visit(&ChunkRows {
                        stretch: chunk.stretch(),
                        row: number,
                        present: &weights[data.measurand_of(number)],
                        directions: &row.directions,
                        lanes: &workspace.lanes(code, group, row.outputs()),
                    });
                }
            }
        };
        for range in record.share(share, step) {
            let stretch = record.stretch(range, &mut scratch);
            Chunk::all(stretch, data.columns()).for_each(|chunk| visit_chunk(&chunk));
        }
    }

    /// Calls `visit(sample, jacobian, residual)` for each sample of a run: the Jacobian of the
    /// predictions (rows: residual components; columns: those the run touches, in their order) and
    /// `reading - prediction`, neither whitened, missing readings as zero rows.
    pub fn visit_run(&self, part: usize, run: usize, point: &Point, visit: &mut Visitor<'_>) {
        self.each_sample((part, run), point, 0.0, &mut |sample, jacobian, values| {
            visit(sample.number, jacobian, values);
        });
    }

    /// Calls `visit(sample, jacobian, residual)` as [`Problem::visit_run`] does, with the sample
    /// itself, and NaN for what was not read.
    pub fn visit_samples(
        &self,
        part: usize,
        run: usize,
        point: &Point,
        visit: &mut SampleVisitor<'_>,
    ) {
        self.each_sample((part, run), point, f64::NAN, visit);
    }

    /// The same with `missing` for what was not read.
    fn each_sample(
        &self,
        (part, run): (usize, usize),
        point: &Point,
        missing: f64,
        visit: &mut SampleVisitor<'_>,
    ) {
        let rows = self.parts[part].residual_count();
        let movers = self.movers(part, run);
        let size = self.layout.columns.touched_by(self.run_index(part, run)).len();
        let mut jacobians = vec![DMatrix::zeros(rows, size); LANES];
        let mut values = vec![vec![0.0; rows]; LANES];
        self.visit_rows(part, run, point, &mut |chunk| {
            let lanes = jacobians.iter_mut().zip(&mut values).enumerate();
            for ((lane, (jacobian, values)), sample) in lanes.zip(chunk.stretch.each()) {
                let there = chunk.present[lane] != 0.0;
                values[chunk.row] = if there { chunk.lanes[0][lane] } else { missing };
                // Column after column.
                let cells = jacobian.as_mut_slice();
                if chunk.row == 0 {
                    cells.fill(0.0);
                }
                let slopes = chunk.directions.iter().zip(&chunk.lanes[1..]);
                for (direction, slope) in slopes.filter(|_| there) {
                    for (column, by) in &movers[*direction] {
                        cells[column * rows + chunk.row] += by * slope[lane];
                    }
                }
                if chunk.row + 1 == rows {
                    visit(sample, jacobian, values);
                }
            }
        });
    }

    /// Calls `visit(sample, residual)` for each sample of a run: `reading - prediction` at a point,
    /// not whitened, NaN where there is no reading.
    pub fn visit_residuals(
        &self,
        part: usize,
        run: usize,
        point: &Point,
        visit: &mut dyn FnMut(Sample<'_>, &[f64]),
    ) {
        self.visit_share_of_residuals((part, run), point, 1.0, visit);
    }

    /// The same for about this share of a run's samples, spread evenly.
    pub fn visit_share_of_residuals(
        &self,
        (part, run): (usize, usize),
        point: &Point,
        share: f64,
        visit: &mut dyn FnMut(Sample<'_>, &[f64]),
    ) {
        let data = &self.parts[part];
        let program = self.programs[part].residuals(&data.system.assembly);
        let rows = data.residual_count();
        let mut values = vec![vec![0.0; rows]; LANES];
        self.visit_program(program, (part, run), point, share, &mut |chunk| {
            for ((lane, values), sample) in values.iter_mut().enumerate().zip(chunk.stretch.each())
            {
                let there = chunk.present[lane] != 0.0;
                values[chunk.row] = if there { chunk.lanes[0][lane] } else { f64::NAN };
                if chunk.row + 1 == rows {
                    visit(sample, values);
                }
            }
        });
    }

    /// The residuals of [`Problem::visit_residuals`], one vector a sample.
    pub fn residuals(&self, part: usize, run: usize, point: &Point) -> Vec<Vec<f64>> {
        let mut all = Vec::with_capacity(self.parts[part].runs[run].record.len());
        self.visit_residuals(part, run, point, &mut |_, values| all.push(values.to_vec()));
        all
    }
}
