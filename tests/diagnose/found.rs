//! What a diagnosis found, in short.

use homepoint::diagnose::Diagnosis;

/// The names of its rows.
pub(crate) fn names(found: &Diagnosis) -> Vec<&str> {
    found.rows.iter().map(|one| one.name.as_str()).collect()
}

/// What it says, in short, and how it came to it: for a test that fails.
pub(crate) fn told(found: &Diagnosis) -> String {
    let noise: Vec<&str> = found.noise.iter().map(|one| one.name.as_str()).collect();
    let remainder: Vec<String> = found
        .remainder
        .iter()
        .map(|one| format!("{} ({:.0})", one.place.words, one.gain.gain))
        .collect();
    let doubtful: Vec<String> =
        found.doubtful.iter().map(|one| format!("{} {:?}", one.name, one.objection)).collect();
    format!(
        "{} rows {:?} noise {noise:?} remainder {remainder:?} doubtful {doubtful:?} scale {:?}, {} readings out\n{}",
        found.verdict.word(),
        names(found),
        found.levels,
        found.left_out.readings.len(),
        found.log.join("\n")
    )
}
