//! The cubics of a curve, in the form that its size asks for.

/// Knots beyond which a curve keeps what its cubics follow from: half of the memory, a division more
/// for each evaluation.
const MANY: usize = 200_000;

/// The cubic of each interval between knots.
#[derive(Clone, Debug)]
pub(super) enum Pieces {
    /// `[a, b, c, d]` of each interval: `a + b u + c u² + d u³`, `u` from its left knot.
    Cubics(Vec<[f64; 4]>),
    /// `[value, second derivative]` at each knot.
    Knots(Vec<[f64; 2]>),
}

impl Pieces {
    /// Those with given values and second derivatives at knots.
    pub(super) fn of(knots: &[f64], value: &[f64], second: &[f64]) -> Self {
        let both = value.iter().zip(second).map(|(value, second)| [*value, *second]);
        let both: Vec<[f64; 2]> = both.collect();
        if knots.len() > MANY {
            return Self::Knots(both);
        }
        let cubics = knots.windows(2).zip(both.windows(2));
        Self::Cubics(cubics.map(|(x, at)| cubic(x, at)).collect())
    }

    /// Number of intervals.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Cubics(cubics) => cubics.len(),
            Self::Knots(knots) => knots.len().saturating_sub(1),
        }
    }

    /// The cubic of an interval.
    #[inline]
    pub(super) fn at(&self, piece: usize, knots: &[f64]) -> [f64; 4] {
        match self {
            Self::Cubics(cubics) => cubics[piece],
            Self::Knots(at) => cubic(&knots[piece..piece + 2], &at[piece..piece + 2]),
        }
    }

    /// The values at the left knots of all intervals.
    pub(super) fn values(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).map(|piece| match self {
            Self::Cubics(cubics) => cubics[piece][0],
            Self::Knots(knots) => knots[piece][0],
        })
    }

    /// A constant and a sum with factors, all over the same knots.
    pub(super) fn sum(constant: f64, terms: &[(f64, &Self)]) -> Option<Self> {
        let mut sum = terms.first()?.1.clone();
        match &mut sum {
            Self::Cubics(own) => {
                own.fill([constant, 0.0, 0.0, 0.0]);
                for (factor, term) in terms {
                    let Self::Cubics(term) = term else { return None };
                    add(own, *factor, term);
                }
            }
            Self::Knots(own) => {
                own.fill([constant, 0.0]);
                for (factor, term) in terms {
                    let Self::Knots(term) = term else { return None };
                    add(own, *factor, term);
                }
            }
        }
        Some(sum)
    }
}

fn add<const N: usize>(sum: &mut [[f64; N]], factor: f64, term: &[[f64; N]]) {
    for (sum, term) in sum.iter_mut().zip(term) {
        sum.iter_mut().zip(term).for_each(|(sum, own)| *sum += factor * own);
    }
}

/// The cubic between two knots with their values and second derivatives.
#[inline]
fn cubic(x: &[f64], at: &[[f64; 2]]) -> [f64; 4] {
    let h = x[1] - x[0];
    let [[value, second], [next, next_second]] = [at[0], at[1]];
    let slope = (next - value) / h - h * (2.0 * second + next_second) / 6.0;
    [value, slope, second / 2.0, (next_second - second) / (6.0 * h)]
}

#[cfg(test)]
mod tests {
    use super::{MANY, Pieces};

    /// Both forms are the same cubics, and sums of them too.
    #[test]
    fn both_forms_are_the_same_cubics() {
        let count = MANY + 2;
        let knots: Vec<f64> = (0..count).map(|n| n as f64 + 0.2 * (n as f64).sin()).collect();
        let value: Vec<f64> = knots.iter().map(|x| (0.3 * x).sin()).collect();
        let second: Vec<f64> = knots.iter().map(|x| -0.09 * (0.3 * x).sin()).collect();
        let many = Pieces::of(&knots, &value, &second);
        let few = Pieces::of(&knots[..50], &value[..50], &second[..50]);
        assert!(matches!((&many, &few), (Pieces::Knots(_), Pieces::Cubics(_))));
        for piece in 0..few.len() {
            assert_eq!(many.at(piece, &knots), few.at(piece, &knots[..50]));
        }
        let sum = |one: &Pieces| Pieces::sum(2.0, &[(0.5, one), (-3.0, one)]);
        let both = sum(&many).zip(sum(&few));
        assert!(both.is_some());
        let Some((many, few)) = both else { return };
        for piece in 0..few.len() {
            let both = many.at(piece, &knots).into_iter().zip(few.at(piece, &knots));
            both.for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{piece}: {a} {b}"));
        }
    }
}
