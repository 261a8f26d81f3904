//! Which file of a crate imports from which: paths followed to the file that defines their item.
//!
//! - An item that a module hands on (`pub use`) counts for the file that defines it.
//! - A module by itself counts for nothing: what is named of it does.
//! - What a parent's file takes from the files in its own folder is not counted. It declares them,
//!   hands their items on and puts them together, while they may use the types that it defines:
//!   parent and child are one module in parts. What a child takes from its parent's file counts, so
//!   a circle by way of any other file is found.

use std::collections::BTreeMap;

use crate::scan::{Module, Use, Written, scan};

/// How many `use` lines may lead from one to the next.
const MOST_STEPS: usize = 32;

/// That a file names something that another one defines.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Import {
    pub(crate) from: String,
    pub(crate) line: usize,
    pub(crate) to: String,
    pub(crate) path: String,
}

/// What a path leads to.
enum Target {
    /// A module, by its path.
    Module(Vec<String>),
    /// An item that a module defines.
    Item(Vec<String>),
}

/// The modules of a crate by their paths, each with its file.
#[derive(Default)]
pub(crate) struct Crate {
    modules: BTreeMap<Vec<String>, (String, Module)>,
}

impl Crate {
    /// The crate of these files: name below the crate's folder (`graph/node.rs`), and text.
    pub(crate) fn new(files: impl IntoIterator<Item = (String, String)>) -> Self {
        let mut modules = BTreeMap::new();
        for (name, text) in files {
            let stem = name.trim_end_matches(".rs");
            let path: Vec<String> = match stem {
                "lib" => Vec::new(),
                _ => stem.split('/').map(str::to_owned).collect(),
            };
            for module in scan(&path, &text) {
                modules.insert(module.path.clone(), (name.clone(), module));
            }
        }
        Self { modules }
    }

    /// Every import of one file from another, in order.
    pub(crate) fn imports(&self) -> Vec<Import> {
        let mut found = Vec::new();
        for (from, module) in self.modules.values() {
            let uses = module.uses.iter().map(|it| (&it.written, it.name.is_none()));
            // What stands on a name that a `use` brought in was counted there.
            let is_new = |it: &&Written| {
                !matches!(
                    self.target(&module.path, &it.path[..1], MOST_STEPS),
                    Some(Target::Item(_))
                )
            };
            let inline = module.inline.iter().filter(is_new).map(|it| (it, false));
            for (written, all) in uses.chain(inline) {
                let Written { path, line } = written;
                let defined = match self.target(&module.path, path, MOST_STEPS) {
                    Some(Target::Item(module)) => module,
                    Some(Target::Module(module)) if all => module,
                    _ => continue,
                };
                let to = &self.modules[&defined].0;
                let own_folder = format!("{}/", from.trim_end_matches(".rs"));
                if to != from && !to.starts_with(&own_folder) {
                    let (from, to, path) = (from.clone(), to.clone(), path.join("::"));
                    found.push(Import { from, line: *line, to, path });
                }
            }
        }
        found.sort();
        found.dedup();
        found
    }

    /// What a path that stands in module `from` leads to, if it leads into the crate.
    fn target(&self, from: &[String], path: &[String], steps: usize) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.follow(Vec::new(), rest, steps),
            "self" => self.follow(from.to_vec(), rest, steps),
            "super" => self.follow(from[..from.len().checked_sub(1)?].to_vec(), rest, steps),
            name => {
                let child = [from, &[name.to_owned()]].concat();
                if self.modules.contains_key(&child) {
                    return self.follow(child, rest, steps);
                }
                match self.used(from, name, steps)? {
                    Target::Module(module) => self.follow(module, rest, steps),
                    item @ Target::Item(_) => Some(item),
                }
            }
        }
    }

    /// What a path leads to from a module on.
    fn follow(&self, mut at: Vec<String>, path: &[String], steps: usize) -> Option<Target> {
        for name in path {
            let child = [&at[..], std::slice::from_ref(name)].concat();
            if name == "super" {
                at.pop()?;
            } else if self.modules.contains_key(&child) {
                at = child;
            } else {
                match self.used(&at, name, steps) {
                    Some(Target::Module(module)) => at = module,
                    Some(item) => return Some(item),
                    None => return Some(Target::Item(at)),
                }
            }
        }
        Some(Target::Module(at))
    }

    /// What a name stands for in a module that does not define it.
    fn used(&self, module: &[String], name: &str, steps: usize) -> Option<Target> {
        let steps = steps.checked_sub(1)?;
        let uses = &self.modules.get(module)?.1.uses;
        let is_it = |it: &&Use| it.name.as_deref() == Some(name);
        if let Some(known) = uses.iter().find(is_it) {
            return self.target(module, &known.written.path, steps);
        }
        let all = uses.iter().filter(|it| it.name.is_none());
        all.filter_map(|it| self.target(module, &it.written.path, steps)).find_map(|target| {
            let Target::Module(other) = target else { return None };
            let child = [&other[..], &[name.to_owned()]].concat();
            match self.modules.contains_key(&child) {
                true => Some(Target::Module(child)),
                false => self.used(&other, name, steps),
            }
        })
    }
}
