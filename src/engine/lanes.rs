//! The graph over chunks of samples: what pointwise computes one sample at a time, 192 at a time.
//!
//! Answers: the values of a graph's nodes for all samples of a chunk, as fast as the machine. What
//! they mean is settled elsewhere; [`super::pointwise`] is the definition, and tests hold the two
//! together.
//!
//! A program has two parts: numbers that stand still for a run (what is made of parameters alone),
//! computed once, and instructions over lanes. Each instruction is one loop over the 192 numbers of
//! a chunk, which the compiler makes vectors of; finding out what to do costs once a chunk, so the
//! text of a model runs as fast as code made for it. Products that one sum needs are fused with it;
//! memory is used again as soon as its value was used for the last time, so all of it stays in the
//! nearest cache. Derivatives are nodes like others ([`crate::graph::derivative`]).
//!
//! | file | answers |
//! |---|---|
//! | [`arithmetic`] | the width of a chunk; how multiply-adds are computed |
//! | [`math`] | elementary functions over lanes |
//! | [`dispatch`] | which instruction set |
//! | `instruction` | what a program is made of |
//! | `identities` | what is rewritten first |
//! | `schedule` | which nodes are computed together, and when |
//! | `sums` | which sums of products are one instruction |
//! | `compile` | instructions, and the memory of each value |
//! | `execute` | the instructions over one chunk |
//! | `kernels` | the loop of each function, compiled for each instruction set |
//! | `added`, `mapped` | the sums over one chunk, one at a time and several of the same numbers |
//! | `registers` | registers by name, for those |
//! | `workspace` | a chunk's memory, filled from samples |
//! | [`products`] | sums of products over a chunk |

mod added;
pub mod arithmetic;
mod compile;
pub mod dispatch;
mod execute;
mod identities;
mod instruction;
mod kernels;
mod mapped;
pub mod math;
pub mod products;
mod registers;
mod schedule;
mod sums;
mod workspace;

pub use arithmetic::{LANES, Lanes};
pub use compile::Code;
pub use dispatch::InstructionSet;
pub use workspace::{Chunk, Workspace};
