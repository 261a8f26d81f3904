//! What a pass says of one candidate.

use nalgebra::{DMatrix, DVector};

use super::basis::basis;
use super::columns::{Column, Owner};

/// A candidate's columns, the nominal parameters' part taken off, as they are.
#[derive(Clone, Debug)]
pub struct Projected {
    pub(super) owners: Vec<Owner>,
    pub(super) columns: Vec<Column>,
    /// `S`.
    pub left: DMatrix<f64>,
    /// `g`.
    pub score: DVector<f64>,
    pub(super) raw: DVector<f64>,
    pub(super) across: DMatrix<f64>,
    pub(super) coupling: DMatrix<f64>,
}

/// What a pass says of one candidate.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Whose values its columns are.
    pub owners: Vec<Owner>,
    pub(super) columns: Vec<Column>,
    /// Length of each column before anything is taken off it.
    pub raw: DVector<f64>,
    /// `W` with `Wᵀ S W = 1`: a column for each degree of freedom.
    pub basis: DMatrix<f64>,
    /// `V` with `V W = 1` and `S = Vᵀ V`: from values to lengths in units of the noise.
    pub lengths: DMatrix<f64>,
    /// `Wᵀ g`.
    pub score: DVector<f64>,
    /// `H_ne`.
    pub(super) across: DMatrix<f64>,
    /// `H_nn⁻¹ H_ne`.
    pub coupling: DMatrix<f64>,
    /// Whether every number is finite.
    pub finite: bool,
}

impl Entry {
    /// What is projected, with its basis.
    pub fn of(projected: Projected) -> Self {
        let Projected { owners, columns, left, score, raw, across, coupling } = projected;
        let k = columns.len();
        let finite = left.iter().chain(score.iter()).all(|value| value.is_finite());
        let (basis, lengths) = if finite && k > 0 {
            basis(&left, &raw)
        } else {
            (DMatrix::zeros(k, 0), DMatrix::zeros(0, k))
        };
        let score = basis.tr_mul(&score);
        Self { owners, columns, raw, basis, lengths, score, across, coupling, finite }
    }

    /// Directions that nominal parameters cannot follow.
    pub fn degrees(&self) -> usize {
        self.score.len()
    }

    /// What its best values take off the sum of squares.
    pub fn gain(&self) -> f64 {
        self.score.norm_squared()
    }

    /// Whether it changes readings at all.
    pub fn acts(&self) -> bool {
        self.raw.iter().any(|length| *length > 0.0)
    }
}
