//! Readings that are repeated for long while inputs move.

use crate::diagnostic::Diagnostic;
use crate::engine::Problem;
use crate::estimate::repeats::long_repeats;

/// A warning for each campaign that has some. It is of the readings that are used: those that a user
/// leaves out are gone before.
pub fn repeated(problem: &Problem) -> Vec<Diagnostic> {
    let long = long_repeats(problem);
    let of_part = long.chunk_by(|a, b| a.0.part == b.0.part);
    let words = of_part.filter_map(|all| {
        let (of, samples) = all.iter().max_by_key(|one| one.1.len())?;
        let (together, others): (Vec<_>, Vec<_>) =
            all.iter().partition(|one| (one.0.run, &one.1) == (of.run, samples));
        let measurands = together.iter().map(|one| format!("`{}`", one.0.names(problem).1));
        let record = &problem.parts[of.part].runs[of.run].record;
        let rows = record.rows(&[samples.start, samples.end - 1]);
        let message = format!(
            "{} {} bit for bit in rows {} to {} of run `{}`{}, while inputs move",
            measurands.collect::<Vec<_>>().join(", "),
            if together.len() == 1 { "repeats its reading" } else { "repeat their readings" },
            rows.first()?,
            rows.last()?,
            of.names(problem).0,
            match others.len() {
                0 => String::new(),
                1 => ", and in 1 more stretch".to_owned(),
                more => format!(", and in {more} more stretches"),
            }
        );
        let help = "has the instrument lost its target, or is it at its limit? the search for a start passes over these rows, a fit uses them: `homepoint diagnose` judges them";
        Some(Diagnostic::warning(message).help(help))
    });
    words.collect()
}
