//! What every bench needs of its process: threads, and words on standard output.

use std::io::{self, Write as _};

use rayon::ThreadPoolBuilder;

/// Runs on a pool of so many threads.
///
/// # Errors
/// The threads cannot be made.
pub(crate) fn on_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> T + Send,
) -> Result<T, rayon::ThreadPoolBuildError> {
    Ok(ThreadPoolBuilder::new().num_threads(threads).build()?.install(work))
}

/// Writes to standard output.
///
/// # Errors
/// It cannot be written.
pub(crate) fn say(text: &str) -> io::Result<()> {
    io::stdout().lock().write_all(text.as_bytes())
}
