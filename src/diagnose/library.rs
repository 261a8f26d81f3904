//! What may be added to a model: effects of the library, and basis blocks.
//!
//! From the ground up; each imports from those before it:

pub mod candidate;
pub mod catalogue;
pub mod offer;
pub mod place;
pub mod prior;
pub mod relaxed;
pub mod structure;
pub mod variant;
pub mod wanted;
pub(super) mod windowed;
