//! What makes the readings of a run uncorrelated and of unit variance, frozen at a point.
//!
//! With `V = L Lᵀ` ([`super::noise`]), the rows of a sample are multiplied by `L⁻¹`. Where no
//! random quantity is shared by readings that is one weight a reading, and where the weights are
//! the same for all samples nothing is stored. Readings that are missing stand aside as unit rows
//! of `L⁻¹`.

use std::borrow::Cow;

use crate::campaign::record::Stretch;
use crate::engine::lanes::arithmetic::{LANES, Lanes};
use crate::engine::lanes::{Chunk, InstructionSet, Workspace};
use crate::engine::noise::active_randoms;
use crate::engine::part::{ParameterLeaves, Part, Slot};
use crate::engine::programs::{NoiseProgram, Programs};

/// Whitening of one run.
#[derive(Clone, Debug)]
pub struct Whitening {
    form: Form,
}

#[derive(Clone, Debug)]
enum Form {
    /// The weight of each measurand, the same for all samples.
    Constant(Vec<f64>),
    /// The weight of each measurand, for each chunk: `[chunk][measurand][lane]`.
    Weights(Vec<Lanes>),
    /// `L⁻¹` of each sample: `[chunk][i (i + 1) / 2 + j][lane]`.
    Triangles(Vec<Lanes>),
    /// Made anew from the parameters of the run, frozen, wherever it is wanted: a run that is not
    /// in memory has no memory for weights either.
    Anew { parameters: Vec<[f64; 4]>, correlated: bool },
}

/// A run of a campaign, with what its samples are evaluated.
#[derive(Clone, Copy, Debug)]
pub struct RunPrograms<'a> {
    /// The campaign.
    pub part: &'a Part,
    /// The lane programs of its model.
    pub programs: &'a Programs,
    /// With what the lanes are computed.
    pub set: InstructionSet,
    /// The run's index in the campaign.
    pub run: usize,
}

/// The whitening of some chunks of a run.
#[derive(Debug)]
pub struct Whitened<'a> {
    form: Cow<'a, Form>,
    /// Number of the first chunk among those of the form.
    first: usize,
}

impl Whitening {
    /// The whitening of a run whose parameters, four numbers each, are frozen.
    pub fn new(of: RunPrograms<'_>, parameters: impl FnOnce() -> Vec<[f64; 4]>) -> Self {
        let RunPrograms { part, programs, run, .. } = of;
        let active = active_randoms(part);
        let program = programs.noise(&part.system);
        let correlated = program.sensitivities.iter().any(|(_, random, _)| active.contains(random));
        let scaled = program.factors.iter().any(Option::is_some);
        if !correlated && !scaled {
            let weight = |measurand| 1.0 / part.sigma_in(run, measurand);
            let weights = (0..part.sigma.len()).map(weight).collect();
            return Self { form: Form::Constant(weights) };
        }
        let parameters = parameters();
        let record = &part.runs[run].record;
        if record.is_spilled() {
            return Self { form: Form::Anew { parameters, correlated } };
        }
        let mut maker = Maker::new(of, &parameters, correlated);
        let mut all = Vec::new();
        record.walk(|stretch| {
            Chunk::all(stretch, part.columns()).for_each(|chunk| maker.chunk(&chunk, &mut all));
        });
        all.shrink_to_fit();
        Self { form: form(all, correlated) }
    }

    /// Whether it is the same at every point.
    pub fn is_constant(&self) -> bool {
        matches!(self.form, Form::Constant(_))
    }

    /// Whether readings of a sample are correlated.
    pub fn is_correlated(&self) -> bool {
        matches!(self.form, Form::Triangles(_) | Form::Anew { correlated: true, .. })
    }

    /// The whitening of a stretch of its run; the stretch begins with a chunk.
    pub fn of(&self, run: RunPrograms<'_>, stretch: Stretch<'_>) -> Whitened<'_> {
        let Form::Anew { parameters, correlated } = &self.form else {
            return Whitened { form: Cow::Borrowed(&self.form), first: stretch.first / LANES };
        };
        let mut maker = Maker::new(run, parameters, *correlated);
        let mut all = Vec::new();
        for chunk in Chunk::all(stretch, run.part.columns()) {
            maker.chunk(&chunk, &mut all);
        }
        Whitened { form: Cow::Owned(form(all, *correlated)), first: 0 }
    }
}

impl Whitened<'_> {
    /// Multiplies the weights of a chunk (its number in the stretch) by those of the measurands.
    pub fn weigh(&self, number: usize, weights: &mut [Lanes]) {
        match &*self.form {
            Form::Constant(factors) => {
                for (weight, factor) in weights.iter_mut().zip(factors) {
                    weight.iter_mut().for_each(|value| *value *= factor);
                }
            }
            Form::Weights(all) => {
                let from = (self.first + number) * weights.len();
                for (weight, factors) in weights.iter_mut().zip(&all[from..]) {
                    weight.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
                }
            }
            Form::Triangles(_) | Form::Anew { .. } => {}
        }
    }

    /// The triangles `L⁻¹` of a chunk, if readings of a sample are correlated: entry (i, j) is
    /// number `i (i + 1) / 2 + j`.
    pub fn triangles(&self, number: usize, rows: usize) -> Option<&[Lanes]> {
        match &*self.form {
            Form::Triangles(all) => {
                let size = rows * (rows + 1) / 2;
                let from = (self.first + number) * size;
                all.get(from..from + size)
            }
            Form::Constant(_) | Form::Weights(_) | Form::Anew { .. } => None,
        }
    }
}

fn form(all: Vec<Lanes>, correlated: bool) -> Form {
    if correlated { Form::Triangles(all) } else { Form::Weights(all) }
}

/// Makes the whitening of one run chunk by chunk.
struct Maker<'a> {
    part: &'a Part,
    run: usize,
    program: &'a NoiseProgram,
    workspace: Workspace,
    correlated: bool,
    /// Standard deviation of each random quantity in this run; 0 where it does not act.
    deviations: Vec<f64>,
}

impl<'a> Maker<'a> {
    fn new(of: RunPrograms<'a>, parameters: &[[f64; 4]], correlated: bool) -> Self {
        let RunPrograms { part, programs, set, run } = of;
        let program = programs.noise(&part.system);
        let active = active_randoms(part);
        let deviations = (0..part.random_sigma.len())
            .map(|k| if active.contains(&k) { part.random_sigma_in(run, k) } else { 0.0 })
            .collect();
        let mut workspace = Workspace::new(&program.code, set);
        workspace.hold_still(&program.code, &ParameterLeaves(parameters));
        Self { part, run, program, workspace, correlated, deviations }
    }

    /// Appends the whitening of a chunk.
    fn chunk(&mut self, chunk: &Chunk<'_>, all: &mut Vec<Lanes>) {
        let Self { part, program, .. } = *self;
        self.workspace.load(&program.code, chunk, &[], false);
        self.workspace.compute(&program.code, 0, chunk.inputs());
        let outputs = self.workspace.outputs(&program.code, 0);
        let deviation = |measurand: usize| {
            let sigma = part.sigma_in(self.run, measurand);
            match program.factors[measurand] {
                Some(output) => outputs[output].map(|factor| sigma * factor),
                None => [sigma; LANES],
            }
        };
        let present = |slot: &Slot| {
            let mut present = [false; LANES];
            let readings = chunk.readings(slot.column);
            present.iter_mut().zip(readings).for_each(|(there, value)| *there = !value.is_nan());
            present
        };
        if !self.correlated {
            let weights = |measurand| deviation(measurand).map(|sigma| 1.0 / sigma);
            all.extend((0..part.slots().len()).map(weights));
            return;
        }
        let rows = part.residual_count();
        let mut triangle = vec![[0.0; LANES]; rows * (rows + 1) / 2];
        let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
        let mut there = vec![[false; LANES]; rows];
        for (measurand, slot) in part.slots().iter().enumerate() {
            let (sigma, present) = (deviation(measurand), present(slot));
            for row in slot.residual..slot.residual + slot.components {
                there[row] = present;
                for lane in 0..LANES {
                    triangle[at(row, row)][lane] =
                        if present[lane] { sigma[lane] * sigma[lane] } else { 1.0 };
                }
            }
        }
        for (i, k, left) in &program.sensitivities {
            for (j, _, right) in program.sensitivities.iter().filter(|(j, l, _)| l == k && j <= i) {
                let variance = self.deviations[*k] * self.deviations[*k];
                if variance > 0.0 {
                    let entry = &mut triangle[at(*i, *j)];
                    for lane in 0..LANES {
                        if there[*i][lane] && there[*j][lane] {
                            entry[lane] += variance * outputs[*left][lane] * outputs[*right][lane];
                        }
                    }
                }
            }
        }
        factorise(rows, &mut triangle);
        invert(rows, &mut triangle);
        all.append(&mut triangle);
    }
}

/// `V` becomes `L`, lane by lane.
fn factorise(rows: usize, triangle: &mut [Lanes]) {
    let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
    for j in 0..rows {
        for i in j..rows {
            let mut entry = triangle[at(i, j)];
            for k in 0..j {
                let (left, right) = (&triangle[at(i, k)], &triangle[at(j, k)]);
                for lane in 0..LANES {
                    entry[lane] -= left[lane] * right[lane];
                }
            }
            if i == j {
                entry = entry.map(f64::sqrt);
            } else {
                let diagonal = &triangle[at(j, j)];
                for lane in 0..LANES {
                    entry[lane] /= diagonal[lane];
                }
            }
            triangle[at(i, j)] = entry;
        }
    }
}

/// `L` becomes its inverse, lane by lane.
fn invert(rows: usize, triangle: &mut [Lanes]) {
    let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
    for i in 0..rows {
        let diagonal = triangle[at(i, i)].map(|value| 1.0 / value);
        // Rows above are inverted already.
        for j in 0..i {
            let mut sum = [0.0; LANES];
            for k in j..i {
                let (left, right) = (&triangle[at(i, k)], &triangle[at(k, j)]);
                for lane in 0..LANES {
                    sum[lane] += left[lane] * right[lane];
                }
            }
            for lane in 0..LANES {
                sum[lane] *= -diagonal[lane];
            }
            // Entries of this row to the right of j are still those of L, as they must be.
            triangle[at(i, j)] = sum;
        }
        triangle[at(i, i)] = diagonal;
    }
}

#[cfg(test)]
#[expect(clippy::needless_range_loop, reason = "the lane is a number too")]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_of_the_factor_whitens_the_covariance() {
        let rows = 4;
        let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
        // V = diag(1, 2, 3, 4) + g gᵀ, g depending on the lane.
        let g = |i: usize, lane: usize| ((i + 1) as f64) * 0.1 * (lane as f64 - 60.0);
        let v = |i: usize, j: usize, lane: usize| {
            f64::from(u8::from(i == j)) * (i + 1) as f64 + g(i, lane) * g(j, lane)
        };
        let mut triangle = vec![[0.0; LANES]; 10];
        for i in 0..rows {
            for j in 0..=i {
                triangle[at(i, j)] = std::array::from_fn(|lane| v(i, j, lane));
            }
        }
        factorise(rows, &mut triangle);
        invert(rows, &mut triangle);
        for lane in 0..LANES {
            let lower = nalgebra::DMatrix::from_fn(rows, rows, |i, j| {
                if j <= i { triangle[at(i, j)][lane] } else { 0.0 }
            });
            let full = nalgebra::DMatrix::from_fn(rows, rows, |i, j| v(i, j, lane));
            let unit = &lower * &full * lower.transpose();
            assert!((unit - nalgebra::DMatrix::identity(rows, rows)).amax() < 1e-12, "{lane}");
        }
    }
}
