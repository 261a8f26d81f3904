//! The house rules that a machine can hold: layers import one way, no files import each other in a
//! circle, one file names the dual-number library, files stay readable, every module says what it
//! answers.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

mod circles;
mod imports;
mod scan;

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::circles::circles;
use crate::imports::Crate;

/// The layers from the ground up; a room may import from its own layer and those before it.
const LAYERS: &[(&str, &[&str])] = &[
    ("number", &["number", "units", "quaternion", "statistics"]),
    ("language", &["diagnostic", "formula", "graph", "document", "progress"]),
    ("nouns", &["model", "effect", "convention", "library", "campaign", "system"]),
    ("engine", &["engine"]),
    ("estimate", &["estimate"]),
    ("diagnose", &["diagnose"]),
    ("trials", &["trials"]),
    ("faces", &["report", "cli", "main", "lib"]),
];

/// The rooms of the diagnosis from the ground up; a room may import from those before it.
const ROOMS: &[&str] = &[
    "thresholds",
    "price",
    "fitted",
    "library",
    "evidence",
    "found",
    "outliers",
    "gap",
    "budget",
    "power",
];

/// Lines a source file may have, its tests not counted.
const MAXIMUM_LINES: usize = 500;

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

fn source_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// First part of the path below `src`, without `.rs`.
fn room(path: &Path) -> String {
    let inside = path.strip_prefix(source_folder()).unwrap();
    let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
    first.trim_end_matches(".rs").to_owned()
}

/// The text before its unit tests.
fn without_tests(text: &str) -> &str {
    text.split("\n#[cfg(test)]").next().unwrap()
}

#[test]
fn layers_import_one_way() {
    let rank: HashMap<&str, usize> = LAYERS
        .iter()
        .enumerate()
        .flat_map(|(rank, (_, rooms))| rooms.iter().map(move |room| (*room, rank)))
        .collect();
    let mut faults = Vec::new();
    for path in sources(&source_folder()) {
        let own = room(&path);
        let Some(own_rank) = rank.get(own.as_str()) else {
            faults.push(format!("{own} is in no layer: add it to LAYERS"));
            continue;
        };
        if own == "lib" || own == "main" {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for (number, line) in without_tests(&text).lines().enumerate() {
            let code = line.split("//").next().unwrap();
            for part in code.split("crate::").skip(1) {
                let target = name_of(part);
                if rank.get(target.as_str()).is_some_and(|other| other > own_rank) {
                    let place = path.display();
                    faults.push(format!("{place}:{}: {own} imports {target}", number + 1));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The name that a path goes on with.
fn name_of(path: &str) -> String {
    path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[test]
fn rooms_of_the_diagnosis_import_one_way() {
    let folder = source_folder().join("diagnose");
    let rank = |name: &str| ROOMS.iter().position(|room| *room == name);
    let mut faults = Vec::new();
    for path in sources(&folder) {
        let inside = path.strip_prefix(&folder).unwrap();
        let own = name_of(inside.to_str().unwrap());
        let Some(own_rank) = rank(&own) else {
            faults.push(format!("{own} is no room: add it to ROOMS"));
            continue;
        };
        let from_here =
            if inside.components().count() == 1 { "super::" } else { "crate::diagnose::" };
        let text = fs::read_to_string(&path).unwrap();
        for (number, line) in without_tests(&text).lines().enumerate() {
            let code = line.split("//").next().unwrap();
            for prefix in ["crate::diagnose::", from_here] {
                for part in code.split(prefix).skip(1) {
                    let target = name_of(part);
                    if rank(&target).is_some_and(|other| other > own_rank) {
                        let place = path.display();
                        faults.push(format!("{place}:{}: {own} imports {target}", number + 1));
                    }
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let folder = source_folder();
    let files = sources(&folder).into_iter().map(|path| {
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap().to_owned();
        (name, fs::read_to_string(path).unwrap())
    });
    // The program is a crate of its own.
    let imports = Crate::new(files.filter(|(name, _)| name != "main.rs")).imports();
    assert!(imports.len() > 1000, "only {} imports were found", imports.len());
    let faults: Vec<String> = circles(&imports).iter().map(ToString::to_string).collect();
    assert!(
        faults.is_empty(),
        "{}move what several of them need to a file of its own, below them all",
        faults.join("\n")
    );
}

#[test]
fn one_file_names_the_dual_number_library() {
    for path in sources(&source_folder()) {
        let text = fs::read_to_string(&path).unwrap();
        let named = text.contains("num_dual");
        assert_eq!(named, path.ends_with("src/number.rs"), "{}", path.display());
    }
}

#[test]
fn files_are_short_and_say_what_they_answer() {
    let mut faults = Vec::new();
    for path in sources(&source_folder()) {
        let text = fs::read_to_string(&path).unwrap();
        let lines = without_tests(&text).lines().count();
        if lines > MAXIMUM_LINES {
            faults.push(format!("{}: {lines} lines, at most {MAXIMUM_LINES}", path.display()));
        }
        if !text.starts_with("//! ") {
            faults.push(format!("{}: does not open with what it answers", path.display()));
        }
        if path.ends_with("mod.rs") {
            faults.push(format!("{}: a module's file bears its name", path.display()));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn there_is_nothing_unexpected_at_the_top() {
    let known = [
        "Cargo.toml",
        "build.rs",
        "Cargo.lock",
        "src",
        "models",
        "tests",
        "benches",
        "docs",
        "examples",
        "README.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "justfile",
        "clippy.toml",
        "rustfmt.toml",
        "target",
    ];
    for entry in fs::read_dir(env!("CARGO_MANIFEST_DIR")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(name.starts_with('.') || known.contains(&name.as_str()), "{name}");
    }
}
