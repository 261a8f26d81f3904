//! Sums of a model's columns by pieces of the readings: whole runs, or stretches of the few runs
//! that there are. For tests that leave readings out, or give groups of runs values of their own.

use nalgebra::DMatrix;

use super::in_fit::count_of_values;
use super::labels::{Grouping, labels};
use super::linear::Linear;
use super::selection::Selection;
use super::sums::Index;

/// Fewer runs are cut into stretches.
const FEW_RUNS: usize = 4;
/// Folds that are held out one after the other; stretches of a run.
pub const FOLDS: usize = 5;

/// The sums of a model's columns, the residual last, over the pieces.
#[derive(Clone, Debug)]
pub struct Pieces {
    /// The pieces.
    pub pieces: Vec<Piece>,
    /// Groups of readings in which rows may have values of their own.
    pub labels: Vec<Grouping>,
    size: usize,
}

/// A run or a stretch of it.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Index of the run among all.
    pub run: usize,
    /// The fold that it belongs to.
    pub fold: usize,
    /// The columns that act in its run.
    columns: Index,
    /// The sums of each measurand that has readings there.
    sums: Vec<(usize, DMatrix<f64>)>,
}

impl Pieces {
    /// The sums of a model of a linearised fit. Where rows of the model have values of each run's
    /// own, folds are stretches of runs: a run that is held out whole would not know them.
    pub fn new(linear: &Linear, selection: &Selection<'_>, model: &[usize]) -> Self {
        let runs = linear.order.len();
        let is_of_runs = |term: &&usize| {
            let term = &selection.terms[**term];
            let values = match term.in_fit {
                true => count_of_values(&linear.fitted, &term.name),
                false => term.values(),
            };
            term.is_effect() && values >= runs
        };
        let within = runs < FEW_RUNS || model.iter().any(|term| is_of_runs(&term));
        Self::cut(linear, selection, model, if within { FOLDS } else { 1 })
    }

    /// The same with stretches of runs as folds.
    pub fn within_runs(linear: &Linear, selection: &Selection<'_>, model: &[usize]) -> Self {
        Self::cut(linear, selection, model, FOLDS)
    }

    fn cut(linear: &Linear, selection: &Selection<'_>, model: &[usize], stretches: usize) -> Self {
        let runs = linear.order.len();
        let size = selection.columns(model).len() + 1;
        let mut pieces: Vec<Piece> = (0..runs * stretches)
            .map(|number| Piece {
                run: number / stretches,
                fold: if stretches > 1 { number % stretches } else { number % FOLDS },
                columns: Index::default(),
                sums: Vec::new(),
            })
            .collect();
        let mut here: Vec<(usize, f64)> = Vec::new();
        let lengths: Vec<usize> =
            (0..runs).map(|run| linear.fitted.problem.samples_in(run).max(1)).collect();
        linear.visit(selection, model, &[], &mut |values| {
            let stretch = (values.sample * stretches / lengths[values.run]).min(stretches - 1);
            let piece = &mut pieces[values.run * stretches + stretch];
            here.clear();
            let all = values.model.iter().copied().chain([values.residual]).enumerate();
            for (column, value) in all.filter(|(_, value)| *value != 0.0) {
                here.push((piece.columns.place(column), value));
            }
            let known = piece.sums.iter().position(|(own, _)| *own == values.measurand);
            let known = known.unwrap_or_else(|| {
                piece.sums.push((values.measurand, DMatrix::zeros(0, 0)));
                piece.sums.len() - 1
            });
            let sums = &mut piece.sums[known].1;
            let size = piece.columns.numbers().len();
            if sums.nrows() < size {
                sums.resize_mut(size, size, 0.0);
            }
            for (j, y) in &here {
                let mut column = sums.column_mut(*j);
                let column = column.as_mut_slice();
                here.iter().for_each(|(i, x)| column[*i] += x * y);
            }
        });
        Self { pieces, labels: labels(&linear.fitted.problem), size }
    }

    /// The products of the columns over some measurands of some pieces, each with its weight.
    pub fn products(
        &self,
        weights: &[f64],
        wanted: impl Fn(&Piece, usize) -> bool,
    ) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.size, self.size);
        self.pieces.iter().for_each(|piece| piece.add_to(&mut sum, weights, &wanted));
        sum
    }

    /// The same over one piece.
    pub fn products_in(&self, piece: &Piece, weights: &[f64]) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.size, self.size);
        piece.add_to(&mut sum, weights, &|_, _| true);
        sum
    }
}

impl Piece {
    /// Adds the products over some measurands.
    fn add_to(
        &self,
        sum: &mut DMatrix<f64>,
        weights: &[f64],
        wanted: &dyn Fn(&Self, usize) -> bool,
    ) {
        let columns = self.columns.numbers();
        for (measurand, gram) in self.sums.iter().filter(|(own, _)| wanted(self, *own)) {
            let weight = weights[*measurand];
            for (j, right) in columns.iter().enumerate().take(gram.ncols()) {
                for (i, left) in columns.iter().enumerate().take(gram.nrows()) {
                    sum[(*left, *right)] += weight * gram[(i, j)];
                }
            }
        }
    }
}
