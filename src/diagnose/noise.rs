//! The noise, before anything is tested against it.
//!
//! | file | answers |
//! |---|---|
//! | [`whiten`] | a fitted model whose noise is what its weights say |
//! | [`jitter`], `variances` | random quantities that the readings of a sample share |
//! | `square` | times that are off by so much that their square shows |
//! | `levels` | by how much readings scatter otherwise than stated |
//! | [`memory`] | noise that is like itself for a while |
//! | [`wander`] | random walks, tested in the variance; a displaced rig, which looks like one |
//! | [`apart`] | readings that are off in a few runs, which look like a long memory |

pub mod apart;
pub mod jitter;
pub(super) mod levels;
pub mod memory;
mod square;
mod variances;
pub mod wander;
pub mod whiten;
