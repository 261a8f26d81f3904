//! Circles of imports: files none of which can be read before the others.

use std::collections::{BTreeMap, BTreeSet};

use crate::imports::Import;

/// Files that import each other, directly or by way of others, with the imports between them.
#[derive(Debug, PartialEq)]
pub(crate) struct Circle {
    pub(crate) files: Vec<String>,
    imports: Vec<Import>,
}

impl std::fmt::Display for Circle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} files import each other: {}", self.files.len(), self.files.join(", "))?;
        for same in
            self.imports.chunk_by(|a, b| (&a.from, a.line, &a.to) == (&b.from, b.line, &b.to))
        {
            let Import { from, line, to, .. } = &same[0];
            let paths: Vec<String> = same.iter().map(|it| format!("`{}`", it.path)).collect();
            writeln!(f, "  src/{from}:{line} takes {} from src/{to}", paths.join(", "))?;
        }
        Ok(())
    }
}

/// The circles among files: the strongly connected components of more than one file.
pub(crate) fn circles(imports: &[Import]) -> Vec<Circle> {
    let mut graph: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for Import { from, to, .. } in imports {
        graph.entry(from).or_default().insert(to);
        graph.entry(to).or_default();
    }
    let mut search = Search::new(&graph);
    graph.keys().for_each(|file| search.visit(file));
    let mut found: Vec<Circle> =
        search.components.into_iter().map(|files| circle(files, imports)).collect();
    found.sort_by(|a, b| a.files.cmp(&b.files));
    found
}

fn circle(files: BTreeSet<&str>, imports: &[Import]) -> Circle {
    let is_between =
        |it: &&Import| files.contains(it.from.as_str()) && files.contains(it.to.as_str());
    let imports = imports.iter().filter(is_between).cloned().collect();
    Circle { files: files.into_iter().map(str::to_owned).collect(), imports }
}

/// Tarjan's search for strongly connected components.
struct Search<'g> {
    graph: &'g BTreeMap<&'g str, BTreeSet<&'g str>>,
    /// Number of each file in the order of the search, and the lowest one that it leads back to.
    numbers: BTreeMap<&'g str, usize>,
    lowest: BTreeMap<&'g str, usize>,
    open: Vec<&'g str>,
    components: Vec<BTreeSet<&'g str>>,
}

impl<'g> Search<'g> {
    fn new(graph: &'g BTreeMap<&'g str, BTreeSet<&'g str>>) -> Self {
        let (numbers, lowest) = (BTreeMap::new(), BTreeMap::new());
        Self { graph, numbers, lowest, open: Vec::new(), components: Vec::new() }
    }

    fn visit(&mut self, file: &'g str) {
        if self.numbers.contains_key(file) {
            return;
        }
        let number = self.numbers.len();
        self.numbers.insert(file, number);
        let mut lowest = number;
        self.open.push(file);
        for next in &self.graph[file] {
            self.visit(next);
            if self.open.contains(next) {
                lowest = lowest.min(self.lowest.get(next).copied().unwrap_or(self.numbers[next]));
            }
        }
        self.lowest.insert(file, lowest);
        if lowest == number {
            let first = self.open.iter().position(|open| *open == file).unwrap();
            let component: BTreeSet<&str> = self.open.drain(first..).collect();
            if component.len() > 1 {
                self.components.push(component);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::circles;
    use crate::imports::Crate;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let owned = files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned()));
        circles(&Crate::new(owned).imports()).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn files_that_import_each_other_are_listed_with_their_lines() {
        let found = found(&[
            ("lib.rs", "pub mod a;\npub mod b;\npub mod c;\npub mod d;"),
            ("a.rs", "use crate::{b::{self, B}, d::D};\n"),
            ("b.rs", "pub struct B;\nfn f() -> crate::c::C {}\n"),
            ("c.rs", "pub struct C;\n\nuse super::a;\nfn f() { a::g(); }\n"),
            ("d.rs", "pub struct D;\n#[cfg(test)]\nmod tests { use crate::a::A; }\n"),
        ]);
        assert_eq!(
            found,
            ["3 files import each other: a.rs, b.rs, c.rs\n\
              \x20 src/a.rs:1 takes `crate::b::B` from src/b.rs\n\
              \x20 src/b.rs:2 takes `crate::c::C` from src/c.rs\n\
              \x20 src/c.rs:4 takes `a::g` from src/a.rs\n"]
        );
    }

    /// A parent's file may hand on what its children define, one of which may take from another by
    /// way of it, and they may use its types; but no other file may lead from it to a child.
    #[test]
    fn a_parent_that_hands_items_on_makes_no_circle_by_itself() {
        let parent = "pub mod x;\npub mod y;\npub use x::X;\nuse self::y::Y;\n";
        let y = "use crate::a::X;\npub struct Y;\n";
        let lib = ("lib.rs", "pub mod a;\n");
        let handed_on = [lib, ("a.rs", parent), ("a/x.rs", "pub struct X;\n"), ("a/y.rs", y)];
        assert!(found(&handed_on).is_empty(), "{:?}", found(&handed_on));
        for child in ["use super::Own;\n", "fn f(x: crate::a::Own) {}\n", "use super::*;\n"] {
            let x = format!("{child}pub struct X;\n");
            let own = format!("{parent}pub struct Own;\n");
            let files = [lib, ("a.rs", &own), ("a/x.rs", &x), ("a/y.rs", y)];
            assert!(found(&files).is_empty(), "{child}: {:?}", found(&files));
            let other = ("other.rs", "use crate::a::X;\npub struct Other;\n");
            let own = format!("{own}use crate::other::Other;\n");
            let files = [lib, ("a.rs", &own), ("a/x.rs", &x), ("a/y.rs", y), other];
            let found = found(&files);
            assert!(found.len() == 1 && found[0].contains(": a.rs, a/x.rs, other.rs"), "{found:?}");
        }
    }

    #[test]
    fn two_circles_are_two() {
        let of = |other: &str| format!("use crate::{other}::T;\npub struct T;\n");
        let [a, b, c, d] = ["b", "a", "d", "c"].map(of);
        let both = format!("{c}use crate::a::T as Other;\n");
        let files = [("a.rs", &a[..]), ("b.rs", &b), ("c.rs", &both), ("d.rs", &d)];
        let found = found(&files);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains(": a.rs, b.rs\n") && found[1].contains(": c.rs, d.rs\n"));
    }
}
