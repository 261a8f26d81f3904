//! The noise, before anything is tested against it.
//!
//! | file | answers |
//! |---|---|
//! | [`given`] | what campaigns give before their noise is judged |
//! | [`whiten`] | a fitted model whose noise is what its weights say |
//! | [`jitter`], `variances` | random quantities that the readings of a sample share |
//! | `square` | times that are off by so much that their square shows |
//! | `levels` | stated uncertainties that follow the scatter |
//! | `neighbours` | how readings differ from their neighbours |
//! | `uneven` | single runs that scatter otherwise than most |
//! | `excess` | scatter beyond what is stated, and what stands for it |
//! | [`memory`] | noise that is like itself for a while |
//! | [`wander`] | random walks, tested in the variance; a displaced rig, which looks like one |
//! | [`apart`] | readings that are off in a few runs, which look like a long memory |

pub mod apart;
pub(super) mod excess;
pub mod given;
pub mod jitter;
mod levels;
pub mod memory;
pub(super) mod neighbours;
mod square;
mod uneven;
mod variances;
pub mod wander;
pub mod whiten;
