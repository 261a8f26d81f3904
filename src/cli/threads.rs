//! How many threads a command computes with.
//!
//! As many as there are processors, or as `--threads` or `RAYON_NUM_THREADS` says, up to
//! [`FOR_EACH`] for each processor: more would only cost. Where so many cannot be started, half as
//! many are tried, down to the one thread that there is. The result is the same at any number.

use std::num::NonZeroUsize;

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::render;
use crate::diagnostic::Diagnostic;

/// Most threads for each processor.
const FOR_EACH: usize = 4;
/// This many may be asked for on any machine.
const ALWAYS: usize = 8;
/// The stack of a thread (bytes): a command runs on one of them, as it would on the first.
const STACK: usize = 8 << 20;

/// What a command runs in.
pub(super) struct Threads {
    pool: Option<ThreadPool>,
}

impl Threads {
    /// Starts threads; `asked` is what `--threads` says. Warns where there are fewer than asked for,
    /// unless it is to be quiet.
    pub(super) fn start(asked: Option<NonZeroUsize>, quiet: bool) -> Self {
        let processors = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let asked = asked.map(NonZeroUsize::get).or_else(from_environment);
        let most = most(processors);
        let wanted = asked.unwrap_or(processors).min(most);
        let (pool, started) = started(wanted, build);
        let words = match asked {
            Some(asked) if started < wanted => {
                Some(format!("{asked} threads are asked for, {started} could be started"))
            }
            Some(asked) if asked > most => Some(format!(
                "{asked} threads are asked for, {most} are used: no more than {FOR_EACH} for each of {processors} processors"
            )),
            None if started < wanted => {
                Some(format!("{started} of {wanted} threads could be started"))
            }
            _ => None,
        };
        if let Some(words) = words.filter(|_| !quiet) {
            let help = "the result is the same at any number";
            render::all(&[Diagnostic::warning(words).help(help)]);
        }
        Self { pool }
    }

    /// Runs a command in them.
    pub(super) fn run<T: Send>(&self, command: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(command),
            None => command(),
        }
    }
}

/// What the environment asks for; nothing and 0 mean as many as there are processors.
fn from_environment() -> Option<usize> {
    let said = std::env::var("RAYON_NUM_THREADS").ok()?;
    said.trim().parse().ok().filter(|count| *count > 0)
}

fn most(processors: usize) -> usize {
    (FOR_EACH * processors).max(ALWAYS)
}

/// A pool of so many threads, or of half as many and so on; its threads, 1 where there is none.
fn started(
    wanted: usize,
    build: impl Fn(usize) -> Option<ThreadPool>,
) -> (Option<ThreadPool>, usize) {
    let mut count = wanted.max(1);
    loop {
        if let Some(pool) = build(count) {
            return (Some(pool), count);
        }
        if count == 1 {
            // A pool of the thread that there is already: none is started.
            let own = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
            return (own.ok(), 1);
        }
        count /= 2;
    }
}

fn build(count: usize) -> Option<ThreadPool> {
    ThreadPoolBuilder::new().num_threads(count).stack_size(STACK).build().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_threads_than_a_few_for_each_processor() {
        assert_eq!([1, 2, 3, 64].map(most), [8, 8, 12, 256]);
    }

    #[test]
    fn where_threads_cannot_be_started_there_are_fewer() {
        let up_to = |limit: usize| move |count| (count <= limit).then(|| build(count)).flatten();
        for (wanted, limit, count) in [(8, 8, 8), (8, 5, 4), (7, 2, 1), (8, 1, 1)] {
            assert_eq!(started(wanted, up_to(limit)).1, count, "{wanted} {limit}");
        }
        // Not even one: in a thread of its own, for the pool stays with it.
        let none = std::thread::spawn(|| {
            let (pool, count) = started(8, |_| None);
            let sum = || rayon::iter::IntoParallelIterator::into_par_iter(0..1000_u64);
            let sum = || rayon::iter::ParallelIterator::sum::<u64>(sum());
            (count, pool.map(|pool| pool.install(sum)))
        });
        assert_eq!(none.join().ok(), Some((1, Some(499_500))));
    }
}
