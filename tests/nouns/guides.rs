//! The guides name everything that the library holds.

use homepoint::library::embedded::{EFFECTS, MODELS};

/// The first cells of a guide's tables.
fn first_cells(guide: &str) -> String {
    let rows = guide.lines().filter_map(|line| line.strip_prefix("| "));
    rows.filter_map(|row| row.split('|').next()).collect()
}

#[test]
fn every_effect_is_a_row_of_the_guide() {
    let named = first_cells(include_str!("../../docs/effects.md"));
    let named: Vec<&str> = named.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    for (name, _) in EFFECTS {
        assert!(named.contains(name), "`{name}` is not in the tables of docs/effects.md");
    }
}

#[test]
fn the_readme_counts_instruments_and_effects() {
    let counts = format!("{} instruments, {} effects", MODELS.len(), EFFECTS.len());
    let readme = include_str!("../../README.md");
    assert!(readme.contains(&counts), "README.md does not say `{counts}`");
}
