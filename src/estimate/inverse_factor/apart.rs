//! Columns of a symmetric matrix that are eliminated apart: values that each run, or each setup, has for
//! itself meet only through the columns that all have in common.

use nalgebra::DMatrix;

/// Up to this size there is nothing to save.
const SMALL: usize = 64;
/// Sets of columns are put together up to this size: products of large matrices are quicker.
const TOGETHER: usize = 24;

/// A partition of the columns.
#[derive(Debug)]
pub(super) struct Apart {
    /// Sets of columns, of which no two have a product.
    pub(super) sets: Vec<Vec<usize>>,
    /// The others.
    pub(super) joint: Vec<usize>,
}

impl Apart {
    /// Of a symmetric matrix; all columns are joint where that saves little.
    pub(super) fn of(matrix: &DMatrix<f64>) -> Self {
        let n = matrix.nrows();
        let whole = || Self { sets: Vec::new(), joint: (0..n).collect() };
        if n <= SMALL {
            return whole();
        }
        let degree =
            |column: &usize| matrix.column(*column).iter().filter(|one| **one != 0.0).count();
        let (joint, others): (Vec<usize>, Vec<usize>) = (0..n).partition(|one| 2 * degree(one) > n);
        let sets = connected(matrix, &others);
        let largest = sets.iter().map(Vec::len).max().unwrap_or(0);
        if 4 * (joint.len() + largest) > 3 * n {
            return whole();
        }
        Self { sets: together(sets), joint }
    }
}

/// Sets of columns that have products, directly or through others.
fn connected(matrix: &DMatrix<f64>, columns: &[usize]) -> Vec<Vec<usize>> {
    let mut is_known = vec![true; matrix.nrows()];
    columns.iter().for_each(|column| is_known[*column] = false);
    let mut sets = Vec::new();
    for first in columns {
        if std::mem::replace(&mut is_known[*first], true) {
            continue;
        }
        let mut set = vec![*first];
        let mut next = 0;
        while let Some(column) = set.get(next).copied() {
            next += 1;
            for other in columns {
                if !is_known[*other] && matrix[(*other, column)] != 0.0 {
                    is_known[*other] = true;
                    set.push(*other);
                }
            }
        }
        sets.push(set);
    }
    sets
}

/// Small sets side by side.
fn together(sets: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut joined: Vec<Vec<usize>> = Vec::new();
    for set in sets {
        match joined.last_mut() {
            Some(last) if last.len() + set.len() <= TOGETHER => last.extend(set),
            _ => joined.push(set),
        }
    }
    joined
}
