//! Which sums one instruction computes together: those over the same lanes, whose factors alone differ,
//! like the components of a rotated vector. Its lanes are read once, and what to do is found out once.
//!
//! Answers: the steps of a schedule with such sums put together where the first of them stood. Their
//! terms are added as they would be one by one: the results are the same, bit by bit.

use std::collections::HashMap;

use crate::engine::lanes::dispatch::Simd;

use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES, Lanes};
use crate::engine::lanes::instruction::Product;
use crate::engine::lanes::schedule::{Form, Schedule};
use crate::engine::lanes::sums::Sum;
use crate::graph::NodeId;

/// So many sums are computed together at most.
pub(super) const MOST_TOGETHER: usize = 3;
/// Factors that stay in registers beside all else.
const MOST_FACTORS: usize = 6;
/// Registers computed without a look at whether the chunk ends.
const UNROLLED: usize = 4;

/// The lanes of a sum of single ones, and whether a number that stands still is added last.
type Shape = (Vec<NodeId>, bool);

/// Puts sums over the same lanes together, group by group.
pub(super) fn together(schedule: &mut Schedule) {
    let steps = std::mem::take(&mut schedule.steps);
    let mut start = 0;
    for end in &mut schedule.ends {
        let mut open: HashMap<Shape, usize> = HashMap::new();
        for step in &steps[start..*end] {
            let shape = match step {
                Form::Sum(node) => schedule.sums.get(*node).and_then(shape),
                _ => None,
            };
            let (Form::Sum(node), Some(shape)) = (*step, shape) else {
                schedule.steps.push(*step);
                continue;
            };
            let most = (MOST_FACTORS / shape.0.len()).min(MOST_TOGETHER);
            let at = open.get(&shape).copied();
            let joined = at.is_some_and(|at| join(&mut schedule.steps[at], node, most));
            if !joined {
                open.insert(shape, schedule.steps.len());
                schedule.steps.push(*step);
            }
        }
        start = *end;
        *end = schedule.steps.len();
    }
}

/// Adds a sum to a step, if it has room.
fn join(step: &mut Form, node: NodeId, most: usize) -> bool {
    let mut nodes = match *step {
        Form::Sum(first) => [Some(first), None, None],
        Form::Sums(nodes) => nodes,
        _ => return false,
    };
    let Some(free) = nodes[..most].iter_mut().find(|node| node.is_none()) else { return false };
    *free = Some(node);
    *step = Form::Sums(nodes);
    true
}

/// The shape of a sum that can be put together with others: of two or three lanes.
fn shape(sum: &Sum) -> Option<Shape> {
    let (last, others) = sum.terms.split_last()?;
    let still = last.lanes == [None, None];
    let moving = if still { others } else { &sum.terms };
    let single = |lanes: [Option<NodeId>; 2]| if lanes[1].is_none() { lanes[0] } else { None };
    let lanes: Option<Vec<NodeId>> = moving.iter().map(|term| single(term.lanes)).collect();
    lanes.filter(|lanes| sum.scale.is_none() && (2..=3).contains(&lanes.len())).map(|l| (l, still))
}

/// Sums over the same lanes: `Σ factor · lane`, and a number that stands still.
#[derive(Clone, Copy, Debug)]
pub(super) struct Together<'a> {
    /// Their terms, sum after sum.
    pub(super) products: &'a [Product],
    /// Number of sums.
    pub(super) count: u8,
    /// Whether the last term of each stands still.
    pub(super) still: bool,
    /// Values of a chunk, by slot.
    pub(super) slots: &'a [Box<Aligned>],
    /// Numbers that stand still.
    pub(super) stills: &'a [f64],
}

impl Together<'_> {
    #[inline(always)]
    pub(super) fn compute<A: Arithmetic, S: Simd>(
        &self,
        simd: S,
        out: [&mut Lanes; MOST_TOGETHER],
    ) {
        let moving = self.products.len() / usize::from(self.count.max(1)) - usize::from(self.still);
        match (self.count, moving, self.still) {
            (2, 2, false) => self.shaped::<A, S, 2, 2, false>(simd, out),
            (2, 2, true) => self.shaped::<A, S, 2, 2, true>(simd, out),
            (3, 2, false) => self.shaped::<A, S, 3, 2, false>(simd, out),
            (3, 2, true) => self.shaped::<A, S, 3, 2, true>(simd, out),
            (2, 3, false) => self.shaped::<A, S, 2, 3, false>(simd, out),
            (2, 3, true) => self.shaped::<A, S, 2, 3, true>(simd, out),
            _ => out.into_iter().for_each(|out| out.fill(f64::NAN)),
        }
    }

    #[inline(always)]
    fn shaped<A: Arithmetic, S: Simd, const ROWS: usize, const N: usize, const STILL: bool>(
        &self,
        simd: S,
        out: [&mut Lanes; MOST_TOGETHER],
    ) {
        let terms = N + usize::from(STILL);
        let factor = |row: usize, term: usize| {
            self.stills[self.products[row * terms + term].factor as usize]
        };
        let factors: [[f64; N]; ROWS] =
            std::array::from_fn(|row| std::array::from_fn(|term| factor(row, term)));
        let added: [f64; ROWS] =
            std::array::from_fn(|row| if STILL { factor(row, N) } else { 0.0 });
        let lanes: [&Lanes; N] =
            std::array::from_fn(|term| &**self.slots[self.products[term].a as usize]);
        if S::F64_LANES > 2 {
            by_register::<A, S, ROWS, N, STILL>(simd, factors, added, lanes, out);
        } else {
            by_lane::<A, ROWS, N, STILL>(factors, added, lanes, out);
        }
    }
}

/// One sum after the other: for two numbers a register the compiler makes better ones of plain loops.
#[inline(always)]
fn by_lane<A: Arithmetic, const ROWS: usize, const N: usize, const STILL: bool>(
    factors: [[f64; N]; ROWS],
    added: [f64; ROWS],
    lanes: [&Lanes; N],
    out: [&mut Lanes; MOST_TOGETHER],
) {
    for ((factors, added), out) in factors.into_iter().zip(added).zip(out) {
        for lane in 0..LANES {
            let mut sum = factors[0] * lanes[0][lane];
            for term in 1..N {
                sum = A::mul_add(factors[term], lanes[term][lane], sum);
            }
            out[lane] = if STILL { sum + added } else { sum };
        }
    }
}

#[inline(always)]
fn by_register<A: Arithmetic, S: Simd, const ROWS: usize, const N: usize, const STILL: bool>(
    simd: S,
    factors: [[f64; N]; ROWS],
    added: [f64; ROWS],
    lanes: [&Lanes; N],
    out: [&mut Lanes; MOST_TOGETHER],
) {
    let steps = LANES / S::F64_LANES;
    let factors = factors.map(|row| row.map(|factor| simd.splat_f64s(factor)));
    let added = added.map(|number| simd.splat_f64s(number));
    let lanes = lanes.map(|lanes| &S::as_simd_f64s(lanes).0[..steps]);
    let out = out.map(|out| &mut S::as_mut_simd_f64s(out).0[..steps]);
    // Short loops in a loop: those are unrolled.
    for first in (0..steps).step_by(UNROLLED) {
        for step in first..first + UNROLLED {
            for row in 0..ROWS {
                let mut sum = simd.mul_f64s(factors[row][0], lanes[0][step]);
                for term in 1..N {
                    sum = if A::FUSED {
                        simd.mul_add_f64s(factors[row][term], lanes[term][step], sum)
                    } else {
                        simd.add_f64s(simd.mul_f64s(factors[row][term], lanes[term][step]), sum)
                    };
                }
                out[row][step] = if STILL { simd.add_f64s(sum, added[row]) } else { sum };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::Samples;
    use crate::engine::lanes::dispatch::InstructionSet;
    use crate::engine::lanes::instruction::Instruction;
    use crate::engine::lanes::{Chunk, Code, Workspace};
    use crate::engine::pointwise::Leaves;
    use crate::graph::{Graph, Leaf};

    /// Some number for each parameter.
    struct Numbers;

    impl Leaves<f64> for Numbers {
        fn leaf(&self, leaf: Leaf) -> f64 {
            match leaf {
                Leaf::Parameter { parameter, .. } => (1.0 + f64::from(parameter)).sin(),
                _ => f64::NAN,
            }
        }

        fn signal(&self, _: u32, _: u8, _: f64) -> f64 {
            f64::NAN
        }
    }

    /// `rows` sums of `columns` lanes with factors of their own, and with a number if `still`.
    fn affine(graph: &mut Graph, rows: u32, columns: u32, still: bool) -> Vec<NodeId> {
        let mut next = 0;
        let mut number = |graph: &mut Graph| {
            next += 1;
            graph.leaf(Leaf::Parameter { parameter: next, component: 0 })
        };
        let one = |graph: &mut Graph, number: &mut dyn FnMut(&mut Graph) -> NodeId| {
            let mut sum = None;
            for column in 0..columns {
                let lane = graph.leaf(Leaf::Given(column));
                let factor = number(graph);
                let product = graph.multiply(factor, lane);
                sum = Some(sum.map_or(product, |sum| graph.add(sum, product)));
            }
            let sum = sum.unwrap_or_else(|| graph.constant(0.0));
            let last = if still { number(graph) } else { graph.constant(0.0) };
            graph.add(sum, last)
        };
        (0..rows).map(|_| one(graph, &mut number)).collect()
    }

    fn computed(code: &Code, set: InstructionSet, groups: usize) -> Vec<u64> {
        let mut workspace = Workspace::new(code, set);
        workspace.hold_still(code, &Numbers);
        let given = [0.0, 1.0, 2.0].map(|c| std::array::from_fn(|i| (0.7 * i as f64 + c).cos()));
        let samples = Samples::default();
        let chunk = Chunk { samples: &samples, columns: &[], start: 0, first: 0, len: LANES };
        workspace.load(code, &chunk, &given);
        let mut bits = Vec::new();
        for group in 0..groups {
            workspace.compute(code, group, &[]);
            let outputs = workspace.outputs(code, group);
            bits.extend(outputs.into_iter().flatten().map(|value| value.to_bits()));
        }
        bits
    }

    #[test]
    fn sums_together_are_what_they_are_one_by_one() {
        for (rows, columns, still) in
            [(2, 2, false), (3, 2, true), (7, 2, false), (2, 3, true), (3, 3, false), (5, 3, true)]
        {
            let mut graph = Graph::default();
            let outputs = affine(&mut graph, rows, columns, still);
            let whole = Code::new(&graph, std::slice::from_ref(&outputs));
            let apart: Vec<Vec<NodeId>> = outputs.iter().map(|node| vec![*node]).collect();
            let apart = Code::new(&graph, &apart);
            let is_together = |one: &Instruction| matches!(one, Instruction::Sums { .. });
            assert!(!apart.instructions.iter().any(is_together));
            let most = if columns == 2 { 3 } else { 2 };
            let instructions = whole.instructions.len();
            assert_eq!(instructions, (rows as usize).div_ceil(most), "{rows} of {columns}");
            for set in InstructionSet::available() {
                let expected = computed(&apart, set, rows as usize);
                assert!(computed(&whole, set, 1) == expected, "{rows} of {columns}");
                assert!(expected.iter().all(|bits| f64::from_bits(*bits).is_finite()));
            }
        }
    }
}
