//! Passes over a campaign for the same signatures, one after the other, each with other values of
//! the constants that they leave open.
//!
//! Only what candidates do by themselves is summed: products of each one's columns with each other,
//! with the nominal columns, where these are computed, and with the residual. What threads keep is
//! kept from pass to pass. What the sums mean is not its business.

use std::ops::Range;
use std::sync::Arc;

use crate::engine::blocks::{Block, Plan};
use crate::engine::kept::{Memories, Memory};
use crate::engine::lanes::products::Products;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::signatures::Signatures;

/// Passes for some signatures at a point.
#[derive(Debug)]
pub struct Passes<'a> {
    problem: &'a Problem,
    signatures: Arc<Signatures>,
    /// Whether sums are wanted across candidates.
    across: bool,
    plans: Vec<Plan>,
    memories: Memories,
    /// The columns of each candidate.
    candidates: Vec<Range<usize>>,
}

/// Sums over one run: for each column of the candidates its products.
///
/// | number of a column | product with |
/// |---|---|
/// | `0..touched` | the nominal columns that the run touches, where they are computed |
/// | `touched` | the residual |
/// | `touched + 1..` | the columns of its candidate, or of all, from the first on |
#[derive(Clone, Debug)]
pub struct Sums {
    numbers: Vec<f64>,
    touched: usize,
    /// Numbers of each column.
    stride: usize,
}

impl Sums {
    /// The products of a column with the nominal columns that the run touches.
    pub fn nominal(&self, column: usize) -> &[f64] {
        &self.numbers[column * self.stride..][..self.touched]
    }

    /// The product of a column with the residual.
    pub fn residual(&self, column: usize) -> f64 {
        self.numbers[column * self.stride + self.touched]
    }

    /// The products of a column with those of its candidate, or of all, from the first on.
    pub fn own(&self, column: usize) -> &[f64] {
        &self.numbers[column * self.stride..][self.touched + 1..self.stride]
    }

    fn add(&mut self, other: &Self) {
        self.numbers.iter_mut().zip(&other.numbers).for_each(|(sum, more)| *sum += more);
    }
}

impl<'a> Passes<'a> {
    /// Passes with the signatures of candidates; `across` them, too, if that is wanted.
    pub fn new(
        problem: &'a Problem,
        signatures: Arc<Signatures>,
        point: &Point,
        across: bool,
    ) -> Self {
        let plans = problem.plans_with(&signatures, point);
        let columns = |group: &[usize]| group.len();
        let sizes: Vec<usize> = if across {
            vec![signatures.columns.len()]
        } else {
            signatures.groups.chunk_by(|a, b| a == b).map(columns).collect()
        };
        let candidates = sizes
            .iter()
            .scan(0, |from, size| {
                *from += size;
                Some(*from - size..*from)
            })
            .collect();
        let memories = Memories::default();
        Self { problem, signatures, across, plans, memories, candidates }
    }

    /// The signatures.
    pub fn signatures(&self) -> &Signatures {
        &self.signatures
    }

    /// The sums of every run, with a value of the open constant for each candidate.
    pub fn sums(&self, constants: &[f64]) -> Vec<Sums> {
        let part = self.signatures.part();
        let plans: Vec<Plan> = self.plans.iter().map(|plan| plan.given(constants)).collect();
        let mut sums: Vec<Option<Sums>> = vec![None; plans.len()];
        self.problem.in_order(
            &self.memories,
            1,
            |block| block.part == part,
            |memory, block| self.block(block, &plans[block.run], memory),
            |block, made| match &mut sums[block.run] {
                Some(sums) => sums.add(&made),
                none => *none = Some(made),
            },
        );
        let all = sums.into_iter().zip(&plans);
        all.map(|(sums, plan)| sums.unwrap_or_else(|| self.empty(plan))).collect()
    }

    fn empty(&self, plan: &Plan) -> Sums {
        let columns = self.signatures.columns.len();
        let touched = if self.signatures.among { plan.size - 1 - columns } else { 0 };
        let most = self.candidates.iter().map(ExactSizeIterator::len).max().unwrap_or(0);
        let stride = touched + 1 + most;
        Sums { numbers: vec![0.0; columns * stride], touched, stride }
    }

    /// The sums over a block.
    fn block(&self, block: Block, plan: &Plan, memory: &mut Memory) -> Sums {
        let Self { problem, signatures, .. } = self;
        let nominal = plan.movers.len() - signatures.columns.len();
        let group = |direction: usize| match direction.checked_sub(nominal) {
            Some(_) if self.across => 1,
            Some(column) => signatures.groups[column],
            None => 0,
        };
        let made = |directions: &[usize]| {
            let groups: Vec<usize> =
                std::iter::once(0).chain(directions.iter().map(|one| group(*one))).collect();
            Products::grouped(&groups, problem.instruction_set())
        };
        problem.block_products(block, &signatures.program, plan, memory, made);
        let mut sums = self.empty(plan);
        let Some(own) = memory.own(block.part) else { return sums };
        let (mut row_of, numbers) = (Vec::new(), &mut sums.numbers);
        let (touched, stride) = (sums.touched, sums.stride);
        for (row, products) in own.products.iter().enumerate() {
            let directions = own.mixed.directions(row);
            let first = directions.partition_point(|direction| *direction < nominal);
            // Of each candidate's column the place of its numbers, and the first column that it is
            // summed with.
            let places: Vec<(usize, usize)> = directions[first..]
                .iter()
                .map(|direction| (direction - nominal, self.first_beside(direction - nominal)))
                .collect();
            products.row(0, &mut row_of);
            for ((here, _), sum) in places.iter().zip(&row_of) {
                numbers[here * stride + touched] += sum;
            }
            for (place, direction) in (1..).zip(&directions[..first]) {
                products.row(place, &mut row_of);
                for (at, factor) in &plan.movers[*direction] {
                    for ((here, _), sum) in places.iter().zip(&row_of) {
                        numbers[here * stride + at] += factor * sum;
                    }
                }
            }
            for (place, (here, from)) in places.iter().enumerate() {
                products.row(1 + first + place, &mut row_of);
                for ((there, _), sum) in places[place..].iter().zip(&row_of) {
                    numbers[here * stride + touched + 1 + there - from] += sum;
                    if there != here {
                        numbers[there * stride + touched + 1 + here - from] += sum;
                    }
                }
            }
        }
        sums
    }

    /// The first of the columns that a column is summed with.
    fn first_beside(&self, column: usize) -> usize {
        let at = self.candidates.partition_point(|columns| columns.end <= column);
        self.candidates.get(at).map_or(0, |columns| columns.start)
    }
}
