//! Products of lists of columns, each a combination of columns of the sums: products of the columns
//! that several combinations are made of are taken once.

use nalgebra::DMatrix;

use crate::diagnose::budget::terms::Combination;

/// Some columns, with what they are made of.
#[derive(Debug)]
pub(super) struct Combined {
    /// The columns of the sums, in order.
    made_of: Vec<usize>,
    /// For each column the places of its parts there, with their factors.
    columns: Vec<Vec<(usize, f64)>>,
}

impl Combined {
    /// Of combinations.
    pub(super) fn of<'a>(columns: impl Iterator<Item = &'a Combination> + Clone) -> Self {
        let mut made_of: Vec<usize> =
            columns.clone().flatten().map(|(column, _)| *column).collect();
        made_of.sort_unstable();
        made_of.dedup();
        let place =
            |(column, by): &(usize, f64)| (made_of.partition_point(|known| known < column), *by);
        let columns = columns.map(|one| one.iter().map(place).collect()).collect();
        Self { made_of, columns }
    }

    /// The products with other columns, from those of columns of the sums.
    pub(super) fn products(
        &self,
        other: &Self,
        product: impl Fn(usize, usize) -> f64,
    ) -> DMatrix<f64> {
        let (rows, columns) = (&self.made_of, &other.made_of);
        let parts =
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| product(rows[i], columns[j]));
        self.joined(other, &parts)
    }

    /// The products with each other.
    pub(super) fn squares(&self, product: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
        let n = self.made_of.len();
        let mut parts = DMatrix::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                let value = product(self.made_of[i], self.made_of[j]);
                parts[(i, j)] = value;
                parts[(j, i)] = value;
            }
        }
        self.joined(self, &parts)
    }

    /// Products of combinations from those of their parts.
    fn joined(&self, other: &Self, parts: &DMatrix<f64>) -> DMatrix<f64> {
        let mut products = DMatrix::zeros(self.columns.len(), other.columns.len());
        let mut along = vec![0.0; parts.nrows()];
        for (mut to, column) in products.column_iter_mut().zip(&other.columns) {
            along.fill(0.0);
            for (place, by) in column {
                let from = parts.column(*place);
                along.iter_mut().zip(from.iter()).for_each(|(sum, value)| *sum += by * value);
            }
            for (to, own) in to.iter_mut().zip(&self.columns) {
                *to = own.iter().map(|(place, by)| by * along[*place]).sum();
            }
        }
        products
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_the_parts_one_by_one() {
        let product = |a: usize, b: usize| 1.0 / (1.0 + (a + b) as f64) + f64::from(a == b);
        let left: Vec<Combination> = vec![vec![(4, 1.0)], vec![(7, -2.0), (2, 0.5)], vec![]];
        let right: Vec<Combination> = vec![vec![(2, 3.0), (9, 1.0), (4, -1.0)], vec![(7, 1.0)]];
        let due = |a: &Combination, b: &Combination| -> f64 {
            let of = |(i, p): &(usize, f64)| -> f64 {
                b.iter().map(|(j, q)| p * q * product(*i, *j)).sum()
            };
            a.iter().map(of).sum()
        };
        let found = Combined::of(left.iter()).products(&Combined::of(right.iter()), product);
        let squares = Combined::of(left.iter()).squares(product);
        for (i, a) in left.iter().enumerate() {
            for (j, b) in right.iter().enumerate() {
                assert!((found[(i, j)] - due(a, b)).abs() < 1e-12);
            }
            for (j, b) in left.iter().enumerate() {
                assert!((squares[(i, j)] - due(a, b)).abs() < 1e-12);
            }
        }
    }
}
