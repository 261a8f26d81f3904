//! How the values of an input that varies are spread: over so much, with places and means of their own.

/// Orders of waves of which constant parts are known.
const ORDERS: usize = 2;
/// Share of the mean square of a wave from which it is mostly a constant.
const MOSTLY: f64 = 0.5;

/// The pairs of places of two inputs that were visited several times.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Pairs {
    /// The other input.
    pub(in crate::diagnose) other: String,
    /// The places of both (SI), each in order.
    pub(in crate::diagnose) places: [Vec<f64>; 2],
    /// Those that were visited together, by their numbers.
    pub(in crate::diagnose) visited: Vec<[usize; 2]>,
}

/// How the values of an input that varies are spread.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Spread {
    /// Its name.
    pub(in crate::diagnose) input: String,
    /// The places (SI) at which a line over it bends: none of what turns.
    pub(in crate::diagnose) knots: Vec<f64>,
    /// Its places (SI) where they are more than its knots and each has several readings.
    pub(in crate::diagnose) levels: Vec<f64>,
    /// Difference between the largest and the least value (SI).
    pub(in crate::diagnose) span: f64,
    /// Inputs that go in proportion with it: what is over both is over either of them.
    pub(in crate::diagnose) alike: Vec<String>,
    /// Pairs of its places with those of other inputs.
    pub(in crate::diagnose) pairs: Vec<Pairs>,
    /// Of what turns the means of cosine and sine where they are mostly constant, order by order.
    constants: [[Option<f64>; 2]; ORDERS],
}

impl Spread {
    /// Of what turns, by its values.
    pub(in crate::diagnose) fn of_angle(input: String, values: &[f64], span: f64) -> Self {
        let constants = std::array::from_fn(|at| {
            [f64::cos, f64::sin].map(|wave| constant_part(wave, (at + 1) as f64, values))
        });
        Self { constants, ..Self::of_knots(input, Vec::new(), span) }
    }

    /// Of anything else.
    pub(in crate::diagnose) fn of_knots(input: String, knots: Vec<f64>, span: f64) -> Self {
        let (levels, alike, pairs) = (Vec::new(), Vec::new(), Vec::new());
        Self { input, knots, levels, span, alike, pairs, constants: [[None; 2]; ORDERS] }
    }

    /// The same with places at which it is read again and again.
    pub(in crate::diagnose) fn with_levels(self, levels: Vec<f64>) -> Self {
        Self { levels, ..self }
    }

    /// The same with inputs that go in proportion with it.
    pub(in crate::diagnose) fn with_alike(self, alike: Vec<String>) -> Self {
        Self { alike, ..self }
    }

    /// The same with pairs of its places with those of other inputs.
    pub(in crate::diagnose) fn with_pairs(self, pairs: Vec<Pairs>) -> Self {
        Self { pairs, ..self }
    }

    /// The constant parts of cosine and sine of an order.
    pub(super) fn constants(&self, order: usize) -> [Option<f64>; 2] {
        let known = order.checked_sub(1).and_then(|at| self.constants.get(at));
        known.copied().unwrap_or_default()
    }
}

/// The mean of a wave where it is mostly that, as a cosine over a part of a turn is.
fn constant_part(wave: fn(f64) -> f64, order: f64, values: &[f64]) -> Option<f64> {
    let (mut sum, mut squares) = (0.0, 0.0);
    for value in values {
        let value = wave(order * value);
        sum += value;
        squares += value * value;
    }
    let mean = sum / values.len().max(1) as f64;
    (mean * sum > MOSTLY * squares).then_some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cosine_over_a_part_of_a_turn_is_mostly_constant() {
        let over = |half: f64| {
            let values: Vec<f64> = (-20..=20).map(|step| half * f64::from(step) / 20.0).collect();
            Spread::of_angle("a".to_owned(), &values, 2.0 * half)
        };
        let [cosine, sine] = over(1.0).constants(1);
        assert!(cosine.is_some_and(|mean| (mean - 0.84).abs() < 0.01), "{cosine:?}");
        assert_eq!(sine, None);
        assert_eq!(over(1.0).constants(2), [None; 2]);
        assert_eq!(over(3.0).constants(1), [None; 2]);
        assert_eq!(Spread::of_knots("a".to_owned(), Vec::new(), 2.0).constants(1), [None; 2]);
    }
}
