//! An instrument as its user declares it: one TOML file, `docs/formats.md` section 2.
//!
//! Answers: what the file says, with the place of everything it says. It does not evaluate.
//!
//! | file | answers |
//! |---|---|
//! | [`declaration`] | what a model declares |
//! | [`read`] | a model file as declarations |
//! | [`parameter`] | one line on a parameter, in a model, an effect or a campaign |
//! | [`name`] | which words may be names |
//! | [`component`] | what is said of one component of a vector |
//! | [`roles`] | which of a model's names stand for those of the library |
//! | [`apply`] | a declaration with what a campaign says of it |

pub mod apply;
pub mod component;
pub mod declaration;
pub mod name;
pub mod parameter;
pub mod read;
pub mod roles;

pub use declaration::{
    Component, Coordinates, DelayGroup, InputDeclaration, MeasurandDeclaration, Model, Override,
    ParameterDeclaration, Process, Role, Roles, Setting, Shape,
};
