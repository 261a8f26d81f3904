//! What a candidate leaves of the readings, and how its score scatters over them.

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::RunGram;
use crate::engine::signatures::Signatures;
use crate::engine::stretches::Left;
use crate::engine::{Point, Problem};

use super::{Entry, Evidence};

impl Evidence {
    /// What is left of the readings of each run, campaign after campaign, with an entry's best
    /// values and the nominal parameters that go with them; scores are summed over stretches of so
    /// many samples.
    pub fn left(
        &self,
        problem: &Problem,
        point: &Point,
        entry: &Entry,
        length: usize,
    ) -> Vec<Left> {
        self.left_by(problem, point, &self.steps(entry), length)
    }

    /// The same with a step for each run.
    pub(super) fn left_by(
        &self,
        problem: &Problem,
        point: &Point,
        steps: &[Vec<f64>],
        length: usize,
    ) -> Vec<Left> {
        let parts = self.signatures.iter().enumerate();
        let of_part = |(part, signatures): (usize, &Signatures)| {
            let first = problem.run_index(part, 0);
            let steps = &steps[first..first + problem.parts[part].runs.len()];
            problem.left(signatures, point, steps, length)
        };
        parts.flat_map(of_part).collect()
    }

    /// For each run, or piece of one, an entry's best values and the nominal parameters that go
    /// with them, one for each column of its sums.
    pub(super) fn steps(&self, entry: &Entry) -> Vec<Vec<f64>> {
        let (values, nominal) = (entry.values(), self.nominal_step(entry));
        let sums = self.runs.iter().zip(&self.touched);
        let nominal = |(sums, touched): (&RunGram, &Vec<usize>)| {
            let mut step: Vec<f64> = touched.iter().map(|column| nominal[*column]).collect();
            step.resize(sums.gram.nrows() - 1, 0.0);
            step
        };
        let mut steps: Vec<Vec<f64>> = sums.map(nominal).collect();
        for (column, value) in entry.columns.iter().zip(values.iter()) {
            for (run, index) in &column.at {
                steps[*run][self.touched[*run].len() + index] += value;
            }
        }
        steps
    }

    /// How much more an entry's score scatters from stretch to stretch than the noise model says: 1
    /// if it is right. `left` is what a good model leaves of each run.
    pub fn inflation(&self, entry: &Entry, left: &[Left]) -> f64 {
        let mut sum = 0.0;
        for (run, left) in left.iter().enumerate() {
            let touched = &self.touched[run];
            // Places of this run's columns, once for all its stretches.
            let own: Vec<(usize, usize)> = entry
                .columns
                .iter()
                .enumerate()
                .filter_map(|(j, column)| {
                    let at = column.at.iter().find(|(other, _)| *other == run)?;
                    Some((j, touched.len() + at.1))
                })
                .collect();
            for score in &left.scores {
                let mut raw = DVector::zeros(entry.columns.len());
                for (j, at) in &own {
                    raw[*j] = score[*at];
                }
                for (place, column) in touched.iter().enumerate() {
                    for j in 0..raw.len() {
                        raw[j] -= entry.coupling[(*column, j)] * score[place];
                    }
                }
                sum += entry.basis.tr_mul(&raw).norm_squared();
            }
        }
        sum / entry.degrees().max(1) as f64
    }

    /// The step of the nominal parameters that goes with an entry's best values.
    pub(super) fn nominal_step(&self, entry: &Entry) -> DVector<f64> {
        let score = &self.nominal.score;
        let score = DMatrix::from_column_slice(score.len(), 1, score.as_slice());
        self.nominal.solve(&score).column(0) - &entry.coupling * entry.values()
    }
}
