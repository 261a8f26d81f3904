//! Whitened residuals and Jacobians, summed by run: the only maker of Jacobians.
//!
//! The lanes compute rows, a chunk of samples at a time; the products of a row's columns are added
//! up where they stand. [`super::referee`] makes the same rows sample by sample.

use nalgebra::DMatrix;

use crate::engine::blocks::{Block, Plan};
use crate::engine::gram::{Columns, Growing, LeastSquares, Normal, PartGram, RunGram, UNBOUNDED};
use crate::engine::kept::{Memories, Memory};
use crate::engine::lanes::products::Products;
use crate::engine::negligible::without_rounding;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::programs::RowsProgram;

/// Rows and columns of a tile of a matrix.
const TILE: usize = 16;

/// What sees the products of a row, with the columns of a Gram matrix that each stands for.
type ProductsVisitor<'a> = dyn FnMut(usize, &Products, &[&[(usize, f64)]]) + 'a;

impl Problem {
    /// The sums over a block of what a program computes.
    pub(super) fn block_gram(
        &self,
        block: Block,
        program: &RowsProgram,
        plan: &Plan,
        memory: &mut Memory,
    ) -> RunGram {
        let mut gram = DMatrix::zeros(plan.size, plan.size);
        let readings =
            self.scatter_block(block, program, plan, memory, &mut |_, products, columns| {
                scatter(&mut gram, products, columns);
            });
        both_triangles(&mut gram);
        RunGram { gram, readings }
    }

    /// The same measurand by measurand, each with the columns that its readings hang on.
    pub(super) fn block_grams(
        &self,
        block: Block,
        program: &RowsProgram,
        plan: &Plan,
        memory: &mut Memory,
    ) -> Vec<PartGram> {
        let made = |directions: &[usize]| Products::new(1 + directions.len(), self.set);
        self.block_products(block, program, plan, memory, made);
        let part = &self.parts[block.part];
        let Some(own) = memory.own(block.part) else { return Vec::new() };
        let gram = |measurand: usize| {
            let is_own = |row: &usize| part.measurand_of(*row) == measurand;
            let rows: Vec<usize> = (0..own.products.len()).filter(is_own).collect();
            let movers = |row: usize| own.mixed.directions(row).iter().map(|d| &plan.movers[*d]);
            let moved = rows.iter().flat_map(|row| movers(*row)).flatten();
            let mut places: Vec<usize> =
                moved.map(|(place, _)| *place).chain([plan.size - 1]).collect();
            places.sort_unstable();
            places.dedup();
            let last = places.len() - 1;
            let here = |(place, by): &(usize, f64)| (places.partition_point(|p| p < place), *by);
            let mut gram = DMatrix::zeros(places.len(), places.len());
            for row in rows {
                let moved = movers(row).map(|mover| mover.iter().map(here).collect());
                let columns: Vec<Vec<(usize, f64)>> =
                    std::iter::once(vec![(last, 1.0)]).chain(moved).collect();
                let columns: Vec<&[(usize, f64)]> = columns.iter().map(Vec::as_slice).collect();
                scatter(&mut gram, &own.products[row], &columns);
            }
            both_triangles(&mut gram);
            PartGram { places, gram }
        };
        (0..part.slots().len()).map(gram).collect()
    }

    /// Shows the products of each row over a block with the columns that they stand for; the number
    /// of readings.
    fn scatter_block(
        &self,
        block: Block,
        program: &RowsProgram,
        plan: &Plan,
        memory: &mut Memory,
        take: &mut ProductsVisitor<'_>,
    ) -> usize {
        let made = |directions: &[usize]| Products::new(1 + directions.len(), self.set);
        let readings = self.block_products(block, program, plan, memory, made);
        let residual = [(plan.size - 1, 1.0)];
        if let Some(own) = memory.own(block.part) {
            for (row, products) in own.products.iter().enumerate() {
                let columns: Vec<&[(usize, f64)]> = std::iter::once(&residual[..])
                    .chain(own.mixed.directions(row).iter().map(|d| plan.movers[*d].as_slice()))
                    .collect();
                take(row, products, &columns);
            }
        }
        readings
    }

    /// The products of the columns of each row over a block, which are then in the memory; the
    /// number of readings. `made` makes the sums for a row that hangs on these directions.
    pub(super) fn block_products(
        &self,
        block: Block,
        program: &RowsProgram,
        plan: &Plan,
        memory: &mut Memory,
        made: impl Fn(&[usize]) -> Products,
    ) -> usize {
        let kept = memory.own(block.part).map(|own| std::mem::take(&mut own.products));
        let mut products = kept.unwrap_or_default();
        products.iter_mut().for_each(Products::clear);
        let readings = self.walk_rows(block, program, plan, memory, &mut |row| {
            // Every chunk has its rows in order.
            if products.len() == row.index {
                products.push(made(row.directions));
            }
            products[row.index].add(row.lanes);
        });
        if let Some(own) = memory.own(block.part) {
            own.products = products;
        }
        readings
    }

    /// Computes the rows of a block and forgets them; the number of readings.
    pub(super) fn block_rows(
        &self,
        block: Block,
        program: &RowsProgram,
        plan: &Plan,
        memory: &mut Memory,
    ) -> usize {
        self.walk_block(block, &program.code, plan, memory, &mut |loaded, _| {
            for group in 0..program.code.group_count() {
                loaded.workspace.compute(&program.code, group, loaded.chunk.inputs());
            }
        })
    }

    fn block_cost(&self, block: Block, plan: &Plan, memory: &mut Memory) -> f64 {
        let program = self.programs[block.part].residuals(&self.parts[block.part].system.assembly);
        let mut squares = Products::new(1, self.set);
        self.walk_rows(block, program, plan, memory, &mut |row| squares.add(row.lanes));
        squares.sum(0, 0)
    }
}

/// Adds products of columns that stand for the given columns of a Gram matrix: each pair in one
/// order only, the diagonal halved, so that [`both_triangles`] makes the matrix of it.
fn scatter(half: &mut DMatrix<f64>, products: &Products, columns: &[&[(usize, f64)]]) {
    // Most columns stand for one of the matrix each.
    let single = |column: &&[(usize, f64)]| match **column {
        [(place, 1.0)] => Some(place),
        _ => None,
    };
    let mut singles: Vec<usize> = columns.iter().rev().map_while(single).collect();
    singles.reverse();
    let several = columns.len() - singles.len();
    let mut sums = Vec::with_capacity(columns.len());
    for (i, left) in columns.iter().enumerate() {
        products.row(i, &mut sums);
        sums[0] *= 0.5;
        let (first, rest) = sums.split_at(several.saturating_sub(i));
        for (a, p) in *left {
            // One column of the matrix at a time, for that is how it lies in memory.
            let mut target = half.column_mut(*a);
            let target = target.as_mut_slice();
            for (right, sum) in columns[i..].iter().zip(first) {
                for (b, q) in *right {
                    target[*b] += p * q * sum;
                }
            }
            for (b, sum) in singles[i.saturating_sub(several)..].iter().zip(rest) {
                target[*b] += p * sum;
            }
        }
    }
}

/// A matrix and its transpose, added up in place, tile by tile: both sides of a tile fit into the
/// nearest cache.
fn both_triangles(half: &mut DMatrix<f64>) {
    let size = half.nrows();
    let tiles = || (0..size).step_by(TILE);
    for (tall, wide) in tiles().flat_map(|tall| tiles().map(move |wide| (tall, wide))) {
        for b in wide..size.min(wide + TILE) {
            for a in tall.max(b)..size.min(tall + TILE) {
                let sum = half[(a, b)] + half[(b, a)];
                half[(a, b)] = sum;
                half[(b, a)] = sum;
            }
        }
    }
}

impl LeastSquares for Problem {
    type Point = Point;

    fn columns(&self) -> &Columns {
        &self.layout.columns
    }

    fn begins(&mut self, iteration: usize) {
        self.iteration = iteration;
    }

    fn reweight(&mut self, point: &Point) {
        self.refresh_weights(point);
    }

    fn weights_move(&self) -> bool {
        self.whitening.iter().flatten().any(|whitening| !whitening.is_constant())
    }

    fn cost(&self, point: &Point) -> f64 {
        let plans = self.plans(point);
        let mut sum = 0.0;
        self.in_order(
            &Memories::default(),
            1,
            |_| true,
            |memory, block| {
                self.block_cost(block, &plans[self.run_index(block.part, block.run)], memory)
            },
            |_, cost| sum += cost,
        );
        let priors: f64 = point.priors(&self.layout).iter().map(|row| row.residual.powi(2)).sum();
        sum + priors
    }

    fn normal(&self, point: &Point) -> Normal {
        let columns = self.layout.columns.clone();
        let plans = self.plans(point);
        let mut runs = Growing::new(plans.len());
        let most = plans.iter().map(|plan| plan.size).max().unwrap_or(0);
        self.in_order(
            &Memories::default(),
            most * most,
            |_| true,
            |memory, block| {
                let plan = &plans[self.run_index(block.part, block.run)];
                let program =
                    self.programs[block.part].rows(&self.parts[block.part].system.assembly);
                self.block_gram(block, program, plan, memory)
            },
            |block, made| runs.add(self.run_index(block.part, block.run), made),
        );
        let runs = runs.finish(plans.iter().map(|plan| plan.size));
        let mut normal = Normal { columns, runs, priors: point.priors(&self.layout) };
        without_rounding(&mut normal, &self.layout, point);
        normal
    }

    fn moved(&self, point: &Point, step: &[f64]) -> Point {
        point.moved(&self.layout, step)
    }

    fn step_bounds(&self, point: &Point) -> Vec<(f64, f64)> {
        let mut bounds = vec![UNBOUNDED; self.layout.columns.len()];
        for index in 0..self.layout.instances.len() {
            for (component, column) in self.layout.own_columns(index) {
                let value = point.values[index][component];
                let (lower, upper) = self.layout.bounds_of(index, component);
                bounds[column] = (lower - value, upper - value);
            }
        }
        bounds
    }
}
