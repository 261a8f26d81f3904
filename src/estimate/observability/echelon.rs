//! Sparse bases of spaces of directions.

use nalgebra::DVector;

/// A sparse basis of the space the vectors span, each with its pivot (an entry no other one has).
pub(super) fn echelon(mut vectors: Vec<DVector<f64>>) -> Vec<(DVector<f64>, usize)> {
    let mut done: Vec<(DVector<f64>, usize)> = Vec::with_capacity(vectors.len());
    loop {
        // A hair's preference for later columns makes ties, and so the words, reproducible.
        let Some((row, pivot, _)) = vectors
            .iter()
            .enumerate()
            .flat_map(|(r, v)| v.iter().enumerate().map(move |(c, x)| (r, c, x.abs())))
            .max_by(|a, b| {
                (a.2 * (1.0 + 1e-9 * a.1 as f64)).total_cmp(&(b.2 * (1.0 + 1e-9 * b.1 as f64)))
            })
        else {
            return done;
        };
        let chosen = vectors.swap_remove(row);
        let chosen = &chosen / chosen[pivot];
        for other in vectors.iter_mut().chain(done.iter_mut().map(|(v, _)| v)) {
            let factor = other[pivot];
            *other -= &chosen * factor;
            other[pivot] = 0.0;
        }
        done.push((chosen, pivot));
    }
}

/// Takes the pivots of an exact basis out of other vectors: no reading notices.
pub(super) fn clear_pivots(vectors: &mut [DVector<f64>], exact: &[(DVector<f64>, usize)]) {
    for vector in vectors {
        for (direction, pivot) in exact {
            let factor = vector[*pivot];
            *vector -= direction * factor;
        }
    }
}
