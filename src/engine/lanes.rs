//! The lane engine: a graph evaluated over chunks of 128 samples at once.
//!
//! | file | answers |
//! |---|---|
//! | [`arithmetic`] | the chunk, and how multiply-adds are computed on an instruction set |
//! | [`math`] | elementary functions over a chunk |

pub mod arithmetic;
pub mod math;
