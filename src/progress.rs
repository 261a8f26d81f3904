//! How far a long task has come, told to whoever shows it.
//!
//! The library tells; what is drawn, where and whether, is the faces' business.

use std::fmt;
use std::sync::Arc;

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Data files are read; counted in bytes of the files.
    Reading,
    /// A fit is in this iteration; counted in samples, from the start at each pass over them.
    Fitting {
        /// From 1.
        iteration: usize,
    },
    /// Readings are solved for their delays; counted in samples of a measurand.
    Solving,
    /// Readings are drawn; counted in samples.
    Drawing,
    /// Simulated campaigns are diagnosed; counted in campaigns.
    Trials,
}

/// Takes what is told: the task, how much of it is done, and how much there is.
type Listener = dyn Fn(Task, u64, u64) + Send + Sync;

/// Whom to tell; nobody unless stated.
#[derive(Clone, Default)]
pub struct Progress(Option<Arc<Listener>>);

impl Progress {
    /// Tells this one.
    pub fn to(listener: impl Fn(Task, u64, u64) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(listener)))
    }

    /// Tells that `done` of `all` is done.
    pub fn tell(&self, task: Task, done: u64, all: u64) {
        if let Some(listener) = &self.0 {
            listener(task, done, all);
        }
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Progress(told)" } else { "Progress" })
    }
}
