//! Hash tables of nodes. A graph is made by looking nodes up, and most of that time is hashing, so
//! it is quick here; the keys are the program's own, nobody can choose them so that they collide.
//! The same tables are iterated in the same order in every run.

use std::collections::{HashMap, HashSet};

use foldhash::fast::FixedState;

/// A table.
pub type Table<K, V> = HashMap<K, V, FixedState>;

/// A set.
pub type Set<K> = HashSet<K, FixedState>;
