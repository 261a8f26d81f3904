//! The width of a chunk, and how multiply-adds are computed.

/// Samples in one chunk.
pub const LANES: usize = 128;

/// One quantity over a chunk of samples.
pub type Lanes = [f64; LANES];

/// How multiply-adds are computed on an instruction set.
pub trait Arithmetic: Copy + Send + Sync + 'static {
    /// Whether `a b + c` is one instruction, rounded once.
    const FUSED: bool;

    /// `a b + c`.
    #[inline(always)]
    fn mul_add(a: f64, b: f64, c: f64) -> f64 {
        if Self::FUSED { a.mul_add(b, c) } else { a * b + c }
    }
}

/// Fused multiply-add.
#[derive(Clone, Copy, Debug)]
pub struct Fused;

/// Multiplication, then addition: for instruction sets on which the fused form is a slow library call.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Arithmetic for Fused {
    const FUSED: bool = true;
}

impl Arithmetic for Plain {
    const FUSED: bool = false;
}
