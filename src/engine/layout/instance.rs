//! One value of one parameter, and how it follows from the columns.

use crate::graph::Kind;
use crate::model::Setting;
use crate::units::Unit;

/// One value of one parameter.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The parameter's full name.
    pub name: String,
    /// Scalar, vector or rotation.
    pub kind: Kind,
    /// Unit it is declared in.
    pub unit: Unit,
    /// What is known of it.
    pub setting: Setting,
    /// The setup or run it holds for; for rig and instrument the campaign where labels distinguish
    /// several, their own name where there are several of them, else `None`.
    pub of: Option<String>,
    /// The rig or instrument that it belongs to, where that has a name.
    pub owner: Option<String>,
    /// How its tangent components follow from the columns.
    pub tangent: Tangent,
    /// Whether it acts on noise alone: then it is a level, not an unknown of least squares.
    pub noise_only: bool,
    /// Whether its start was found by a search, and not stated.
    pub start_found: bool,
    /// The start that was stated of its first component before a search found another.
    pub stated_start: Option<f64>,
}

impl Instance {
    /// Whether it is the delay of measurands.
    pub fn is_delay(&self) -> bool {
        self.name.ends_with(".delay")
    }

    /// Number of tangent components: 1 for a scalar, 3 for a vector or a rotation.
    pub fn dimension(&self) -> usize {
        self.kind.dimension()
    }

    /// The components that are estimated.
    pub(super) fn free_components(&self) -> impl Iterator<Item = usize> {
        (0..self.dimension()).filter(|component| !self.setting.is_fixed(*component))
    }

    /// Whose it is, by any name: of its rig or instrument, else of what it holds for.
    pub fn whose(&self) -> Option<&str> {
        self.owner.as_deref().or(self.of.as_deref())
    }
}

/// How an instance follows from the columns.
#[derive(Clone, Debug, PartialEq)]
pub enum Tangent {
    /// It does not: it is fixed.
    Fixed,
    /// Component `i` is column `start + i`.
    Columns(usize),
    /// Component `i` is that column; it is fixed where there is none.
    Components([Option<usize>; 3]),
    /// Component `i` is `Σ_j coefficients[j] · column[start + j * dimension + i]`.
    Contrast {
        /// First column of the contrasts.
        start: usize,
        /// This instance's row of the contrast matrix.
        coefficients: Vec<f64>,
    },
}
