//! The functions of the language: one entry in one table each.
//!
//! Parser, checks of arguments, error messages, listings and LaTeX read the table. To add a
//! function of one number, begin with its entry here; the compiler then names every other place,
//! for each matches all functions without a rest:
//!
//! 1. a variant of [`Unary`] (`graph/node.rs`);
//! 2. its value over any number type, in `Unary::apply` below it;
//! 3. its derivative as nodes, in `slope` (`graph/partials.rs`);
//! 4. its value over a chunk, in `unary` (`engine/lanes/kernels.rs`): number by number with `map`,
//!    or a kernel of its own in `engine/lanes/math` where it has to be fast.
//!
//! A function of several numbers, of vectors or of rotations has the meaning `Own` here and its rule
//! in `graph/calls.rs`. Tests go through the table: `tests/language/functions.rs` (rules,
//! derivatives, the guide) and `tests/engine/functions.rs` (chunks).

use std::fmt;
use std::ops::RangeInclusive;

use crate::graph::Unary;

/// What a call becomes in the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// A plain number in, a plain number out.
    Plain(Unary),
    /// Any number in, one of the same dimension out.
    Keep(Unary),
    /// Any number in, a plain number out.
    Drop(Unary),
    /// Any number in, the root of its dimension out.
    Root(Unary),
    /// A rule of its own, in `graph/calls.rs`.
    Own,
}

/// How a call is set in LaTeX.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The operator, then the arguments in parentheses.
    Operator(&'static str),
    /// The argument between these.
    Between(&'static str, &'static str),
    /// The two arguments with this between them.
    Infix(&'static str),
    /// The argument with this after it.
    Postfix(&'static str),
    /// A dot over a name; the derivative d/dt of anything else.
    Rate,
}

/// One entry of the table.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The function.
    pub function: Function,
    /// Its name in formulas.
    pub name: &'static str,
    /// What it is called with, in words of its signature: `rotation(axis, angle)`.
    pub signature: &'static str,
    /// How many arguments it takes.
    pub arity: RangeInclusive<usize>,
    /// How it is set in LaTeX.
    pub setting: Setting,
    /// What it becomes in the graph.
    pub meaning: Meaning,
    /// What it is, in one line.
    pub about: &'static str,
}

macro_rules! functions {
    ($($function:ident $name:literal ($($argument:literal),*) $arity:expr, $setting:expr, $meaning:expr, $about:literal;)*) => {
        /// A function of the language.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Function {
            $(#[doc = $about] $function,)*
        }

        /// All functions, in the order in which listings show them.
        pub const TABLE: &[Entry] = &[$(Entry {
            function: Function::$function,
            name: $name,
            signature: concat!($name, "(", $($argument),*, ")"),
            arity: $arity,
            setting: $setting,
            meaning: $meaning,
            about: $about,
        },)*];
    };
}

use Meaning::{Drop, Keep, Own, Plain, Root};
use Setting::{Between, Infix, Operator, Postfix, Rate};

functions! {
    Sin "sin" ("angle") 1..=1, Operator("\\sin"), Plain(Unary::Sin), "Sine of an angle.";
    Cos "cos" ("angle") 1..=1, Operator("\\cos"), Plain(Unary::Cos), "Cosine of an angle.";
    Tan "tan" ("angle") 1..=1, Operator("\\tan"), Plain(Unary::Tan), "Tangent of an angle.";
    Asin "asin" ("x") 1..=1, Operator("\\arcsin"), Plain(Unary::Asin), "Inverse sine, from -90 to 90 degrees.";
    Acos "acos" ("x") 1..=1, Operator("\\arccos"), Plain(Unary::Acos), "Inverse cosine, from 0 to 180 degrees.";
    Atan "atan" ("x") 1..=1, Operator("\\arctan"), Plain(Unary::Atan), "Inverse tangent, from -90 to 90 degrees.";
    Atan2 "atan2" ("y, x") 2..=2, Operator("\\operatorname{atan2}"), Own, "Angle of the point (x, y), from -180 to 180 degrees; 0 at the origin.";
    Sqrt "sqrt" ("x") 1..=1, Between("\\sqrt{", "}"), Root(Unary::Sqrt), "Square root; its derivative at 0 counts as 0.";
    Hypot "hypot" ("x, y") 2..=2, Operator("\\operatorname{hypot}"), Own, "Length of the hypotenuse over legs x and y.";
    Exp "exp" ("x") 1..=1, Operator("\\exp"), Plain(Unary::Exp), "e to the power of x.";
    Log "log" ("x") 1..=1, Operator("\\ln"), Plain(Unary::Ln), "Natural logarithm.";
    Abs "abs" ("x") 1..=1, Between("\\left|", "\\right|"), Keep(Unary::Abs), "Absolute value.";
    Sign "sign" ("x") 1..=1, Operator("\\operatorname{sign}"), Drop(Unary::Sign), "-1, 0 or 1.";
    Tanh "tanh" ("x") 1..=1, Operator("\\tanh"), Plain(Unary::Tanh), "Hyperbolic tangent: a smooth step.";
    Floor "floor" ("x") 1..=1, Between("\\left\\lfloor", "\\right\\rfloor"), Plain(Unary::Floor), "Largest whole number not above x.";
    Fract "fract" ("x") 1..=1, Operator("\\operatorname{fract}"), Plain(Unary::Fract), "x - floor(x): a sawtooth.";
    Min "min" ("a, b, ...") 2..=64, Operator("\\min"), Own, "The smallest of several numbers.";
    Max "max" ("a, b, ...") 2..=64, Operator("\\max"), Own, "The largest of several numbers.";
    Norm "norm" ("v") 1..=1, Between("\\left\\lVert", "\\right\\rVert"), Own, "Length of a vector.";
    Dot "dot" ("a, b") 2..=2, Infix("\\cdot"), Own, "Inner product of two vectors.";
    Cross "cross" ("a, b") 2..=2, Infix("\\times"), Own, "Outer product of two vectors.";
    Normalize "normalize" ("v") 1..=1, Operator("\\operatorname{normalize}"), Own, "The vector of length 1 along v; zero for zero.";
    RotationX "rotation_x" ("angle") 1..=1, Operator("R_x"), Own, "Rotation about the x axis, right-handed.";
    RotationY "rotation_y" ("angle") 1..=1, Operator("R_y"), Own, "Rotation about the y axis, right-handed.";
    RotationZ "rotation_z" ("angle") 1..=1, Operator("R_z"), Own, "Rotation about the z axis, right-handed.";
    Rotation "rotation" ("axis, angle") 2..=2, Operator("R"), Own, "Rotation about an axis (of any length), right-handed.";
    Turn "turn" ("v") 1..=1, Operator("\\operatorname{turn}"), Own, "Rotation by a rotation vector (axis times angle), smooth at zero.";
    Quaternion "quaternion" ("w, x, y, z") 4..=4, Operator("\\operatorname{quaternion}"), Own, "The rotation along a quaternion of any length.";
    Rotate "rotate" ("q, v") 2..=2, Operator("\\operatorname{rotate}"), Own, "The vector v turned by the rotation q.";
    Inverse "inverse" ("q") 1..=1, Postfix("^{-1}"), Own, "The inverse of a rotation.";
    Rate "rate" ("x") 1..=1, Rate, Own, "Total derivative with respect to the moment.";
    Delayed "delayed" ("x, duration") 2..=2, Operator("\\operatorname{delayed}"), Own, "x as it was a duration before the moment.";
}

impl Function {
    /// Its entry in the table.
    pub fn entry(self) -> &'static Entry {
        // The macro writes enum and table in one order.
        &TABLE[self as usize]
    }

    /// Its name in formulas.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// The function of this name.
    pub fn find(name: &str) -> Option<Self> {
        TABLE.iter().find(|entry| entry.name == name).map(|entry| entry.function)
    }
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
