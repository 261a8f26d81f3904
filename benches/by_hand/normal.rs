//! Whitened products of the rows of [`super::jacobian`], summed over samples.
//!
//! The three rows share their products of common columns, so those are added up before they go to
//! memory; a measurand's own columns meet only its own row. Of the 315 products of full rows 176
//! are left.

use super::jacobian::{
    COMMON, COMMON_COLUMNS, DISTANCE_COLUMNS, HORIZONTAL_COLUMNS, Model, Row, VERTICAL_COLUMNS,
};
use super::{COLUMNS, Columns};

/// Upper triangle of the products of all columns and the residual.
pub(crate) type Gram = [[f64; COLUMNS + 1]; COLUMNS + 1];

/// Products of the columns that only one measurand has.
#[derive(Clone, Copy, Debug)]
struct Own<const N: usize> {
    common: [[f64; COMMON + 1]; N],
    own: [[f64; N]; N],
}

impl<const N: usize> Own<N> {
    const ZERO: Self = Self { common: [[0.0; COMMON + 1]; N], own: [[0.0; N]; N] };

    #[inline(always)]
    fn add(&mut self, row: &Row<N>) {
        for k in 0..N {
            for (sum, value) in self.common[k].iter_mut().zip(row.common) {
                *sum += row.own[k] * value;
            }
            for l in k..N {
                self.own[k][l] += row.own[k] * row.own[l];
            }
        }
    }

    fn add_to(&self, gram: &mut Gram, columns: [usize; N]) {
        for k in 0..N {
            for (sum, other) in self.common[k].iter().zip(COMMON_COLUMNS) {
                gram[columns[k].min(other)][columns[k].max(other)] += sum;
            }
            for l in k..N {
                gram[columns[k]][columns[l]] += self.own[k][l];
            }
        }
    }
}

/// The sums over a run; `sigma` are the standard uncertainties of the readings.
pub(crate) fn gram(model: &Model, data: &Columns<'_>, sigma: [f64; 3]) -> Gram {
    let weights = sigma.map(|sigma| 1.0 / sigma);
    let mut common = [[0.0; COMMON + 1]; COMMON + 1];
    let (mut h, mut v, mut d) = (Own::<3>::ZERO, Own::<2>::ZERO, Own::<2>::ZERO);
    for sample in 0..data.len() {
        let rows = model.rows(data, sample, weights);
        let [a, b, c] = [rows.horizontal.common, rows.vertical.common, rows.distance.common];
        for i in 0..=COMMON {
            // From the even column on, so that pairs stay pairs.
            for j in (i & !1)..=COMMON {
                common[i][j] += a[i] * a[j] + b[i] * b[j] + c[i] * c[j];
            }
        }
        h.add(&rows.horizontal);
        v.add(&rows.vertical);
        d.add(&rows.distance);
    }
    let mut gram = [[0.0; COLUMNS + 1]; COLUMNS + 1];
    for i in 0..=COMMON {
        for j in i..=COMMON {
            gram[COMMON_COLUMNS[i]][COMMON_COLUMNS[j]] = common[i][j];
        }
    }
    h.add_to(&mut gram, HORIZONTAL_COLUMNS);
    v.add_to(&mut gram, VERTICAL_COLUMNS);
    d.add_to(&mut gram, DISTANCE_COLUMNS);
    gram
}
