//! Observability: which combinations of unknowns the readings cannot tell apart.
//!
//! Columns are scaled to unit length (the diagonal of `H` becomes 1), then the eigenvalues of the
//! scaled `H` are the squares of the scaled Jacobian's singular values. A direction whose singular
//! value lies below [`UNOBSERVABLE`] of the largest changes no reading noticeably: *exact* below
//! [`EXACT`], else hidden by noise. So is a parameter whose standard uncertainty exceeds its
//! plausible size. What is stated with a standard uncertainty is known to that, and held here.
//!
//! Several such directions span a space, and any basis of it is as true; the one given is sparse
//! (reduced row echelon form with complete pivoting), so that each can be put in words. This room
//! knows columns, not names: the report finds the words and the run that would help.

mod echelon;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use self::echelon::{clear_pivots, echelon};
use super::arrow::{LinearError, normal_matrix};
use super::eigen;
use crate::engine::gram::Normal;

/// A scaled singular value below this part of the largest is unobservable.
pub const UNOBSERVABLE: f64 = 1e-4;
/// A scaled singular value below this part of the largest is zero up to rounding.
pub const EXACT: f64 = 1e-7;
/// Entries of a direction below this part of its largest (scaled) one are not blamed for it.
pub const NEGLIGIBLE: f64 = 1e-2;
/// Entries below this part of a direction's largest (scaled) entry are rounding and left out.
const ROUNDING: f64 = 1e-6;
/// Correlation beyond which two implausible parameters share one direction.
const SAME: f64 = 0.99;
/// Part of the squared response to an implausible parameter that the others must leave for it to be
/// a direction of its own.
const OWN_RESPONSE: f64 = 0.5;

/// How badly a direction is determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Not at all: no reading changes.
    Exact,
    /// Formally, but noise hides it.
    UpToNoise,
}

/// What bounds the standard uncertainty of a column that counts as determined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Limit {
    /// Any finite uncertainty counts.
    #[default]
    Unlimited,
    /// The plausible size, in the column's own unit.
    Size(f64),
    /// It is stated with a standard uncertainty, and known to that.
    Stated,
}

/// What the readings and priors of a problem determine.
#[derive(Clone, Debug, PartialEq)]
pub struct Examined {
    /// The combinations that they do not determine.
    pub directions: Vec<Direction>,
    /// Covariance of the columns with what is stated held and exact directions left out, own units.
    pub judged: DMatrix<f64>,
}

/// A combination of unknowns that the readings do not determine.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// Column and how far it moves along the direction, in the column's own unit; scaled so that
    /// the largest scaled entry is 1, and sorted from the largest scaled entry to the least. One
    /// entry means that the unknown alone has no effect. An implausible parameter comes first.
    pub weights: Vec<(usize, f64)>,
    /// The scaled entries (weight × column length) in the same order, between -1 and 1.
    pub shares: Vec<f64>,
    /// Singular value along the direction over the largest.
    pub singular_value: f64,
    /// How badly it is determined.
    pub kind: Kind,
    /// Whether a plausible size alone is exceeded: the readings determine it all the same.
    pub is_implausible: bool,
    /// Standard uncertainty of the first unknown of `weights`, own unit; `None` if it is unbounded.
    pub standard_uncertainty: Option<f64>,
}

/// What the readings and priors of an undamped problem determine, and which directions they do not.
///
/// `limits` holds the limit of each column; missing entries count as unlimited. Exact directions
/// come first, columns without any effect foremost. No direction if everything is determined.
///
/// # Errors
/// [`LinearError`] if the sums do not fit their blocks or are not finite.
pub fn examine(normal: &Normal, limits: &[Limit]) -> Result<Examined, LinearError> {
    let (hessian, _) = normal_matrix(normal)?;
    let n = hessian.nrows();
    if let Some(at) = hessian.iter().position(|x| !x.is_finite()) {
        return Err(LinearError::Singular { column: at / n });
    }
    let length = DVector::from_fn(n, |i, _| hessian[(i, i)].max(0.0).sqrt());
    let (active, silent): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| length[i] > 0.0);
    let mut directions: Vec<Direction> = silent.into_iter().map(Direction::silent).collect();
    let mut judged = DMatrix::zeros(n, n);
    let view = |columns: Vec<usize>| {
        let first = columns[0];
        Scaled::new(&hessian, &length, columns).ok_or(LinearError::Singular { column: first })
    };
    if active.is_empty() {
        return Ok(Examined { directions, judged });
    }
    let is_stated = |i: &usize| limits.get(*i) == Some(&Limit::Stated);
    let unstated: Vec<usize> = active.iter().copied().filter(|i| !is_stated(i)).collect();
    let whole = view(active)?;
    let exact = echelon(whole.basis(|ratio| ratio < EXACT));
    directions.extend(exact.iter().map(|(v, _)| whole.direction(v, Kind::Exact, None)));
    if unstated.is_empty() {
        return Ok(Examined { directions, judged });
    }
    let held = if unstated.len() == whole.active.len() { whole } else { view(unstated)? };
    let mut hidden = held.basis(|ratio| (EXACT..UNOBSERVABLE).contains(&ratio));
    clear_pivots(&mut hidden, &echelon(held.basis(|ratio| ratio < EXACT)));
    let mut hidden = echelon(hidden);
    hidden.retain(|(vector, _)| held.is_open(vector, limits));
    directions.extend(hidden.iter().map(|(v, _)| held.direction(v, Kind::UpToNoise, None)));
    directions.extend(held.implausible(limits));
    held.covariance_into(&mut judged);
    Ok(Examined { directions, judged })
}

impl Direction {
    /// Of a column that no reading notices.
    fn silent(column: usize) -> Self {
        Self {
            weights: vec![(column, 1.0)],
            shares: vec![1.0],
            singular_value: 0.0,
            kind: Kind::Exact,
            is_implausible: false,
            standard_uncertainty: None,
        }
    }
}

/// The problem with unit columns, without those that have no effect.
struct Scaled {
    /// Column of each row.
    active: Vec<usize>,
    length: Vec<f64>,
    matrix: DMatrix<f64>,
    eigen: SymmetricEigen<f64, nalgebra::Dyn>,
    largest: f64,
}

impl Scaled {
    fn new(hessian: &DMatrix<f64>, length: &DVector<f64>, active: Vec<usize>) -> Option<Self> {
        let length: Vec<f64> = active.iter().map(|&i| length[i]).collect();
        let n = active.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            hessian[(active[i], active[j])] / (length[i] * length[j])
        });
        let eigen = eigen::symmetric(matrix.clone())?;
        let largest = eigen.eigenvalues.max().max(0.0).sqrt();
        Some(Self { active, length, matrix, eigen, largest })
    }

    /// Singular value of each eigenvector over the largest.
    fn ratio(&self, index: usize) -> f64 {
        self.eigen.eigenvalues[index].max(0.0).sqrt() / self.largest
    }

    /// The eigenvectors whose ratio is wanted, as rows.
    fn basis(&self, wanted: impl Fn(f64) -> bool) -> Vec<DVector<f64>> {
        (0..self.active.len())
            .filter(|&i| wanted(self.ratio(i)))
            .map(|i| self.eigen.eigenvectors.column(i).into_owned())
            .collect()
    }

    /// Covariance of scaled unknowns over the eigenvectors above a ratio.
    fn covariance(&self, above: f64, i: usize, j: usize) -> f64 {
        (0..self.active.len())
            .filter(|&k| self.ratio(k) >= above)
            .map(|k| {
                let v = self.eigen.eigenvectors.column(k);
                v[i] * v[j] / self.eigen.eigenvalues[k]
            })
            .sum()
    }

    /// Whether a weak direction moves a column too far, or one of which no size is plausible.
    fn is_open(&self, vector: &DVector<f64>, limits: &[Limit]) -> bool {
        let blamed = |i: &usize| vector[*i].abs() >= NEGLIGIBLE * vector.amax();
        (0..self.active.len()).filter(blamed).any(|i| match limits.get(self.active[i]) {
            Some(Limit::Size(size)) => self.covariance(EXACT, i, i).sqrt() / self.length[i] > *size,
            _ => true,
        })
    }

    /// Covariance in the unknowns' own units, exact directions left out.
    fn covariance_into(&self, judged: &mut DMatrix<f64>) {
        for (i, a) in self.active.iter().enumerate() {
            for (j, b) in self.active.iter().enumerate() {
                judged[(*a, *b)] = self.covariance(EXACT, i, j) / (self.length[i] * self.length[j]);
            }
        }
    }

    /// A direction in the unknowns' own units; `first` leads, else the largest entry.
    fn direction(&self, vector: &DVector<f64>, kind: Kind, first: Option<usize>) -> Direction {
        let largest =
            vector.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        let vector = vector / largest;
        let mut order: Vec<usize> = (0..vector.len())
            .filter(|&i| vector[i].abs() >= ROUNDING || Some(i) == first)
            .collect();
        order.sort_by(|&a, &b| {
            let leads = |i| Some(i) == first;
            // Equal shares keep the order of columns, whatever their rounding.
            let rounded = |i: usize| (vector[i].abs() * 1e6).round();
            leads(b).cmp(&leads(a)).then(rounded(b).total_cmp(&rounded(a)))
        });
        let length =
            (vector.dot(&(&self.matrix * &vector)).max(0.0) / vector.norm_squared()).sqrt();
        let lead = order.first().copied().unwrap_or_default();
        Direction {
            weights: order.iter().map(|&i| (self.active[i], vector[i] / self.length[i])).collect(),
            shares: order.iter().map(|&i| vector[i]).collect(),
            singular_value: length / self.largest,
            kind,
            is_implausible: false,
            standard_uncertainty: match kind {
                Kind::Exact => None,
                Kind::UpToNoise => {
                    Some(self.covariance(EXACT, lead, lead).sqrt() / self.length[lead])
                }
            },
        }
    }

    /// Parameters whose uncertainty, from what is otherwise determined, is beyond plausible: each
    /// with how the others make up for it (its column of the covariance), or by itself where they do
    /// not.
    fn implausible(&self, limits: &[Limit]) -> Vec<Direction> {
        let sigma = |i: usize| self.covariance(UNOBSERVABLE, i, i).sqrt();
        let limit = |i: usize| match limits.get(self.active[i]) {
            Some(Limit::Size(size)) => Some(*size),
            _ => None,
        };
        let mut beyond: Vec<(f64, usize)> = (0..self.active.len())
            .filter_map(|i| {
                let excess = sigma(i) / self.length[i] / limit(i)?;
                (excess > 1.0).then_some((excess, i))
            })
            .collect();
        if beyond.is_empty() {
            return Vec::new();
        }
        beyond.sort_by(|a, b| b.0.total_cmp(&a.0));
        let n = self.active.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| self.covariance(UNOBSERVABLE, i, j));
        let mut leaders: Vec<usize> = Vec::new();
        for (excess, i) in beyond {
            let shared = leaders.iter().any(|&l| {
                let correlation = covariance[(i, l)] / (sigma(i) * sigma(l));
                correlation.abs() > SAME
            });
            // What is known well enough once the leaders are is no direction of its own.
            let left = beside(&covariance, &leaders, i).map_or(0.0, |left| left[i].max(0.0));
            let left = left.sqrt() / sigma(i);
            if !shared && excess * left > 1.0 {
                leaders.push(i);
            }
        }
        leaders
            .iter()
            .map(|&i| {
                let others: Vec<usize> = leaders.iter().copied().filter(|&l| l != i).collect();
                let column = beside(&covariance, &others, i);
                let mut column = column.unwrap_or_else(|| covariance.column(i).into_owned());
                // Where it is implausible with all others known, those that hardly follow it are no part.
                let is_unseen = limit(i).is_some_and(|limit| 1.0 / self.length[i] > limit);
                if is_unseen && column[i] * OWN_RESPONSE < 1.0 {
                    column.fill(0.0);
                    column[i] = 1.0;
                }
                let direction = self.direction(&column, Kind::UpToNoise, Some(i));
                Direction { is_implausible: true, ..direction }
            })
            .collect()
    }
}

/// A column of a covariance beside some others that are held; `None` where these are dependent.
fn beside(covariance: &DMatrix<f64>, held: &[usize], i: usize) -> Option<DVector<f64>> {
    let column = covariance.column(i).into_owned();
    if held.is_empty() {
        return Some(column);
    }
    let across = covariance.select_columns(held);
    let known = across.select_rows(held).cholesky()?.solve(&column.select_rows(held));
    Some(column - across * known)
}
