//! The verdict, a pure function of what was found.

use crate::diagnose::thresholds::FAR_BEYOND_STATED;

/// What a diagnosis says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The residuals are consistent with noise as stated.
    Adequate,
    /// Rows of the budget, or noise of another form than stated, leave residuals that are
    /// consistent with noise.
    Explained,
    /// Rows explain a part of the gap; a remainder stays.
    PartlyExplained,
    /// There is a gap, and no row stands.
    Unknown,
    /// The readings do not determine the nominal parameters.
    Unobservable,
    /// The fit of the nominal parameters did not converge.
    NotConverged,
}

impl Verdict {
    /// Its key.
    pub fn word(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::Explained => "explained",
            Self::PartlyExplained => "partly_explained",
            Self::Unknown => "unknown",
            Self::Unobservable => "unobservable",
            Self::NotConverged => "not_converged",
        }
    }

    /// Whether there is a diagnosis at all.
    pub fn is_made(self) -> bool {
        !matches!(self, Self::Unobservable | Self::NotConverged)
    }

    /// Whether something is there that no row explains.
    pub fn has_remainder(self) -> bool {
        matches!(self, Self::PartlyExplained | Self::Unknown)
    }
}

/// What the verdict follows from.
#[derive(Clone, Copy, Debug, Default)]
pub struct Findings {
    /// Rows that stand.
    pub rows: usize,
    /// Parts of the remainder: basis blocks, and what is too small for a name.
    pub remainder: usize,
    /// Forms of noise other than stated: effects on the noise, readings that are left out.
    pub noise: usize,
    /// The largest noise scale factor beside the rows, of the part of the noise that is white.
    pub largest_scale: f64,
}

/// The verdict.
pub fn decide(found: Findings) -> Verdict {
    let has_remainder = found.remainder > 0 || found.largest_scale > FAR_BEYOND_STATED;
    match (found.rows > 0, has_remainder) {
        (true, true) => Verdict::PartlyExplained,
        (true, false) => Verdict::Explained,
        (false, true) => Verdict::Unknown,
        (false, false) if found.noise > 0 => Verdict::Explained,
        (false, false) => Verdict::Adequate,
    }
}

#[cfg(test)]
mod tests {
    use super::{Findings, Verdict, decide};

    #[test]
    fn the_verdict_follows_from_rows_and_remainder() {
        let of = |rows, remainder, noise, largest_scale| {
            decide(Findings { rows, remainder, noise, largest_scale })
        };
        assert_eq!(of(0, 0, 0, 1.0), Verdict::Adequate);
        assert_eq!(of(0, 0, 0, 4.5), Verdict::Adequate);
        assert_eq!(of(0, 0, 0, 7.0), Verdict::Unknown);
        assert_eq!(of(0, 0, 3, 1.0), Verdict::Explained);
        assert_eq!(of(0, 0, 3, 402.0), Verdict::Unknown);
        assert_eq!(of(2, 0, 0, 1.2), Verdict::Explained);
        assert_eq!(of(2, 0, 0, 7.0), Verdict::PartlyExplained);
        assert_eq!(of(2, 1, 0, 1.0), Verdict::PartlyExplained);
        assert_eq!(of(0, 1, 0, 1.0), Verdict::Unknown);
    }
}
