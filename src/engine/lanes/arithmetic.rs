//! The chunk of samples the lane engine computes with, and how it multiplies and adds.
//!
//! Answers: how wide a chunk is, and whether `a b + c` is one instruction. A loop over [`Lanes`] is
//! vectorised by the compiler for whatever instruction set the code around it is compiled for; the
//! type parameter [`Arithmetic`] tells it only what the compiler must not choose by itself, because
//! a fused multiply-add rounds once where a product and a sum round twice.
//!
//! It does not detect the instruction set.

use std::ops::{Deref, DerefMut};

/// Samples in one chunk.
pub const LANES: usize = 192;

/// One quantity over a chunk of samples.
pub type Lanes = [f64; LANES];

/// Lanes that begin with a cache line: no register is loaded from two of them.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Aligned(Lanes);

impl Default for Aligned {
    fn default() -> Self {
        Self([0.0; LANES])
    }
}

impl Deref for Aligned {
    type Target = Lanes;

    #[inline(always)]
    fn deref(&self) -> &Lanes {
        &self.0
    }
}

impl DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Lanes {
        &mut self.0
    }
}

/// How multiply-adds are computed on an instruction set.
pub trait Arithmetic: Copy + Send + Sync + 'static {
    /// Whether a multiply-add is one instruction that rounds once.
    const FUSED: bool;

    /// `a b + c`.
    #[inline(always)]
    fn mul_add(a: f64, b: f64, c: f64) -> f64 {
        if Self::FUSED { a.mul_add(b, c) } else { a * b + c }
    }
}

/// For instruction sets with fused multiply-add (x86-64 from AVX2 on, 64-bit ARM).
#[derive(Clone, Copy, Debug)]
pub struct Fused;

/// For instruction sets without: `f64::mul_add` would be a slow library call there.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Arithmetic for Fused {
    const FUSED: bool = true;
}

impl Arithmetic for Plain {
    const FUSED: bool = false;
}
