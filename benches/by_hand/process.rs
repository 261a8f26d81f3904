//! What every bench needs of its process: threads, memory, and words on standard output.

use std::fs;
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

/// A line of /proc/self/status in MB.
pub(crate) fn status(key: &str) -> Option<f64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with(key))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1e3)
}
