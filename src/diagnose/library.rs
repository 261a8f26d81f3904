//! What may be added to a model: effects of the library, and structure that nobody wrote down.
//!
//! | file | answers |
//! |---|---|
//! | [`candidates`] | which effects and blocks these campaigns allow, and why not the others |
//! | [`catalogue`] | all that has been made of the models so far |
//! | [`prior`] | how probable each cause is before the readings are looked at |
//! | [`structure`] | what an effect that nobody wrote down could look like |

pub mod candidates;
pub mod catalogue;
pub mod prior;
pub mod structure;
