//! What may be added to a model: effects of the library, and structure that nobody wrote down.
//!
//! From the ground up; each imports from those before it:
//!
//! | file | answers |
//! |---|---|
//! | [`place`] | where unknown structure sits, in words |
//! | [`candidate`] | something that may be added |
//! | [`variant`], [`relaxed`] | relaxed forms of effects, and candidates in them |
//! | [`mod@offer`] | which effects these campaigns allow, and why not the others |
//! | [`structure`] | what an effect that nobody wrote down could look like |
//! | [`catalogue`] | all that has been made of the models so far |
//! | [`prior`] | how probable each cause is before the readings are looked at |
//! | [`wanted`] | which of all that a user asks for |

pub mod candidate;
pub mod catalogue;
pub mod offer;
pub mod place;
pub mod prior;
pub mod relaxed;
pub mod structure;
pub mod variant;
pub mod wanted;
