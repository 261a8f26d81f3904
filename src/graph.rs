//! The graph of named quantities: hash-consed scalar nodes, names and their scopes, patches by
//! effects, `rate` as a rewriting.
//!
//! | file | answers |
//! |---|---|
//! | [`node`] | what a node is and computes |
//! | [`arena`] | the nodes of a graph: interning, folding, what an output needs |
//! | [`algebra`] | vectors and rotations on nodes |
//! | [`names`] | what a model and its effects declare: inputs, parameters, quantities, patches |
//! | [`typed`] | a value with its dimension, and the words for both |
//! | [`lower`], [`calls`] | a formula to nodes: operators; functions |
//! | [`layers`] | sets of effects, and which of them can matter to a name |
//! | [`context`] | what a name means at a measurand's moment under a set of effects |
//! | [`resolve`] | the graph of every measurand: [`assemble`] |
//! | [`mod@quantities`] | the kind and the dimension of each named quantity |
//! | [`partials`] | the partial derivatives of every function, as nodes |
//! | [`rate`] | the total derivative with respect to the moment, as new nodes |
//! | [`mod@delayed`] | an expression at an earlier moment, as new nodes |
//! | [`derivative`] | tangents of all nodes along a direction; gradients of an output |
//! | [`recognise`] | what an effect does, by the nodes that it makes |
//! | [`table`] | hash tables of nodes |
//! | [`import`] | a copy of some nodes in another graph, with leaves replaced |

pub mod algebra;
pub mod arena;
pub mod calls;
pub mod context;
pub mod delayed;
pub mod derivative;
pub mod import;
pub mod layers;
pub mod lower;
pub mod names;
pub mod node;
pub mod partials;
pub mod quantities;
pub mod rate;
pub mod recognise;
pub mod resolve;
pub mod table;
pub mod typed;

pub use arena::Graph;
pub use names::{
    CoordinatesNames, Input, Kind, Local, Measurand, MeasurandKind, Names, Parameter, Patch,
    PatchLayer, PatchTarget, Random, Scope,
};
pub use node::{Binary, Clock, Leaf, Node, NodeId, Unary, Value};
pub use resolve::{Assembly, CoordinatesGraph, MeasurandGraph, assemble};
