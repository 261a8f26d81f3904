//! Which instruction set a chunk is computed with: found out when the program runs, so one binary
//! serves every machine.
//!
//! The code is the same for all: loops that the compiler makes vectors of, once for each set. Each
//! task is a machine function for each set; a task that holds many loops compiles for long. The
//! portable set is what the build targets at least (SSE2 on x86-64); others are used where the
//! processor has them.

use std::sync::OnceLock;

pub use pulp::Simd;
use pulp::{Scalar128b, WithSimd};

use crate::engine::lanes::arithmetic::{Arithmetic, Fused, Plain};

/// An instruction set that this processor has.
#[derive(Clone, Copy, Debug)]
pub enum InstructionSet {
    /// What every processor of the build's target has.
    Portable,
    /// AVX2 with fused multiply-add: four numbers at a time.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    /// AVX-512: eight numbers at a time.
    #[cfg(target_arch = "x86_64")]
    Avx512(pulp::x86::V4),
}

/// Something that is computed with one instruction set.
///
/// `run` and all that it calls must be `#[inline(always)]`: what is not inlined is compiled for the
/// portable set.
pub trait Task {
    /// What comes of it.
    type Output;

    /// Does it. Most tasks are plain loops; `simd` is for those that must name registers.
    fn run<A: Arithmetic, S: Simd>(self, simd: S) -> Self::Output;
}

/// Carries a task into a function that is compiled for an instruction set.
struct Carried<T>(T);

impl<T: Task> WithSimd for Carried<T> {
    type Output = T::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> T::Output {
        self.0.run::<Fused, S>(simd)
    }
}

/// A task compiled for what the build targets at least.
#[inline(never)]
fn portable<T: Task>(task: T) -> T::Output {
    if PORTABLE_FUSES { task.run::<Fused, _>(Scalar128b) } else { task.run::<Plain, _>(Scalar128b) }
}

/// Whether the portable set fuses.
const PORTABLE_FUSES: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));

impl InstructionSet {
    /// The widest one that this processor has.
    pub fn best() -> Self {
        static BEST: OnceLock<InstructionSet> = OnceLock::new();
        *BEST.get_or_init(|| Self::available().pop().unwrap_or(Self::Portable))
    }

    /// All that this processor has, the widest last.
    pub fn available() -> Vec<Self> {
        let mut found = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            found.extend(pulp::x86::V3::try_new().map(Self::Avx2));
            found.extend(pulp::x86::V4::try_new().map(Self::Avx512));
        }
        found
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable if cfg!(target_arch = "x86_64") => "SSE2",
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "AVX-512",
        }
    }

    /// Computes something with this set.
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Portable => portable(task),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(set) => Simd::vectorize(set, Carried(task)),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(set) => Simd::vectorize(set, Carried(task)),
        }
    }
}
