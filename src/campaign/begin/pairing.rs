//! Which of several logs belong together: those of one recording, by their names and stamps.

use crate::campaign::begin::log::Log;

/// Data and stream of each recording, the most alike first; the others have no partner. Of two
/// logs the one with more rows a second is the stream.
pub(super) fn recordings(logs: &[Log]) -> Vec<[usize; 2]> {
    let all_alike = logs.windows(2).all(|two| two[0].heads() == two[1].heads());
    let mut all: Vec<([usize; 2], (bool, usize))> = Vec::new();
    for a in 0..logs.len() {
        for b in a + 1..logs.len() {
            // Logs with the same columns are of the same recorder, at two times.
            if all_alike || logs[a].heads() != logs[b].heads() {
                all.push(([a, b], (overlap(&logs[a], &logs[b]), alike(&logs[a], &logs[b]))));
            }
        }
    }
    all.sort_by_key(|one| std::cmp::Reverse(one.1));
    let mut taken = vec![false; logs.len()];
    let mut found = Vec::new();
    for ([a, b], _) in all {
        if !taken[a] && !taken[b] {
            (taken[a], taken[b]) = (true, true);
            found.push(ordered(logs, [a, b]));
        }
    }
    found
}

/// The data before the stream.
fn ordered(logs: &[Log], [a, b]: [usize; 2]) -> [usize; 2] {
    let spacing = |at: usize| logs[at].spacing().unwrap_or(f64::INFINITY);
    if spacing(a) < spacing(b) { [b, a] } else { [a, b] }
}

/// Whether the stamps of two logs have moments in common.
fn overlap(a: &Log, b: &Log) -> bool {
    let (Some(a), Some(b)) = (a.span(), b.span()) else { return false };
    a[0] < b[1] && b[0] < a[1]
}

/// How many letters the names of two files share at their beginnings and ends.
fn alike(a: &Log, b: &Log) -> usize {
    let name = |log: &Log| -> Vec<char> {
        let stem = log.survey.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        stem.chars().collect()
    };
    let (a, b) = (name(a), name(b));
    let before = a.iter().zip(&b).take_while(|(a, b)| a == b).count();
    let most = a.len().min(b.len()) - before;
    let behind = a.iter().rev().zip(b.iter().rev()).take(most).take_while(|(a, b)| a == b).count();
    before + behind
}
