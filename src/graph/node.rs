//! What a scalar node is, and what each of its functions computes.
//!
//! The meanings and the conventions at singular points are those of [`crate::number`]. The graph
//! that holds the nodes is [`super::arena`].

use crate::number::Number;

/// Index of a node; operands always have smaller indices than their users.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// Times that every sample carries, in seconds (`Index` counts).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Clock {
    /// Reference time of the sample.
    Time,
    /// Since the start of the run.
    RunTime,
    /// Since the start of the setup.
    SetupTime,
    /// Number of the sample in its run, from 0.
    Index,
    /// Straight line through the run's `RunTime` over `Index`, with the jumps of the stamps.
    UniformTime,
    /// How far the run's stamps have jumped.
    JumpTime,
    /// `JumpTime` at the first sample of the run.
    FirstJumpTime,
    /// `JumpTime` at the last sample of the run.
    LastJumpTime,
}

impl Clock {
    /// Whether it goes on between samples.
    pub fn runs(self) -> bool {
        matches!(self, Self::Time | Self::RunTime | Self::SetupTime | Self::UniformTime)
    }
}

/// A value that comes from outside the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Leaf {
    /// Component of a parameter: 0 for a scalar, 0..3 of a vector, 0..4 (w, x, y, z) of a rotation.
    Parameter {
        /// Index in [`crate::graph::Names::parameters`].
        parameter: u32,
        /// Component.
        component: u8,
    },
    /// A random quantity with mean zero, one draw a sample; index in
    /// [`crate::graph::Names::randoms`].
    Random(u32),
    /// An input that does not move; index in [`crate::graph::Names::inputs`].
    Input(u32),
    /// A time of the sample.
    Clock(Clock),
    /// A value that an engine supplies with each sample: a weight, a delay that is looked for. No
    /// formula names it.
    Given(u32),
    /// A reading (in `[coordinates]` and in residuals): measurand and component.
    Reading {
        /// Index of the measurand.
        measurand: u32,
        /// Component (0, or 0..4 of a rotation).
        component: u8,
    },
}

/// Functions of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unary {
    /// `-x`
    Negate,
    /// sine
    Sin,
    /// cosine
    Cos,
    /// tangent
    Tan,
    /// inverse sine
    Asin,
    /// inverse cosine
    Acos,
    /// inverse tangent
    Atan,
    /// square root (derivative 0 at 0)
    Sqrt,
    /// exponential
    Exp,
    /// natural logarithm
    Ln,
    /// absolute value
    Abs,
    /// -1, 0, 1
    Sign,
    /// hyperbolic tangent
    Tanh,
    /// largest whole number not above
    Floor,
    /// distance to it
    Fract,
    /// integer power
    PowerInteger(i32),
    /// Stumpff function of this order, see [`crate::number::Number::stumpff`]
    Stumpff(u8),
    /// `x / |x|²`-safe reciprocal: `1/x`, and 0 at 0 (normalising a zero vector gives zero)
    ReciprocalOrZero,
}

/// Functions of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binary {
    /// `a + b`
    Add,
    /// `a - b`
    Subtract,
    /// `a * b`
    Multiply,
    /// `a / b`
    Divide,
    /// `a ^ b`, a > 0
    Power,
    /// angle of the point (b, a)
    Atan2,
    /// √(a² + b²), derivative 0 at the origin
    Hypot,
    /// the smaller
    Min,
    /// the larger
    Max,
}

/// One scalar node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A number, by its bits.
    Constant(u64),
    /// A value from outside.
    Leaf(Leaf),
    /// The `order`-th derivative with respect to time of a moving input at `time + offset`.
    Signal {
        /// Index in [`crate::graph::Names::inputs`].
        input: u32,
        /// 0 value, 1 rate, 2 acceleration, ...
        order: u8,
        /// Node of the offset from the reference time, in seconds.
        offset: NodeId,
    },
    /// A function of one node.
    Unary(Unary, NodeId),
    /// A function of two nodes.
    Binary(Binary, NodeId, NodeId),
}

/// A scalar, a 3-vector or a rotation (w, x, y, z), by its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Value {
    /// One number.
    Scalar(NodeId),
    /// Three.
    Vector([NodeId; 3]),
    /// A unit quaternion.
    Rotation([NodeId; 4]),
}

impl Value {
    /// Its nodes in order.
    pub fn nodes(&self) -> &[NodeId] {
        match self {
            Self::Scalar(node) => std::slice::from_ref(node),
            Self::Vector(nodes) => nodes,
            Self::Rotation(nodes) => nodes,
        }
    }
}

impl Unary {
    /// Its value for any number type.
    pub fn apply<N: Number>(self, x: N) -> N {
        match self {
            Self::Negate => -x,
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sqrt => x.sqrt(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Abs => x.abs(),
            Self::Sign => x.signum(),
            Self::Tanh => x.tanh(),
            Self::Floor => x.floor(),
            Self::Fract => x.fract(),
            Self::PowerInteger(exponent) => x.powi(exponent),
            Self::Stumpff(order) => x.stumpff(order),
            Self::ReciprocalOrZero => {
                if x.value() == 0.0 {
                    N::constant(0.0)
                } else {
                    N::constant(1.0) / x
                }
            }
        }
    }
}

impl Binary {
    /// Its value for any number type.
    pub fn apply<N: Number>(self, a: N, b: N) -> N {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => a.pow(b),
            Self::Atan2 => a.atan2(b),
            Self::Hypot => a.hypot(b),
            Self::Min => a.min(b),
            Self::Max => a.max(b),
        }
    }
}

impl Node {
    /// The nodes it is made of.
    pub fn operands(self) -> impl Iterator<Item = NodeId> {
        let pair = match self {
            Self::Constant(_) | Self::Leaf(_) => [None, None],
            Self::Signal { offset, .. } => [Some(offset), None],
            Self::Unary(_, a) => [Some(a), None],
            Self::Binary(_, a, b) => [Some(a), Some(b)],
        };
        pair.into_iter().flatten()
    }
}
