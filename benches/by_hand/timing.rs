//! Several ways to the same answer timed in turn, round by round, so that whatever else the machine does meets
//! all of them alike.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::time::{Duration, Instant};

/// One way: its name and one pass over all samples.
pub(crate) struct Way<'a> {
    name: &'a str,
    pass: Box<dyn FnMut() + 'a>,
}

impl<'a> Way<'a> {
    pub(crate) fn new(name: &'a str, pass: impl FnMut() + 'a) -> Self {
        Self { name, pass: Box::new(pass) }
    }
}

/// Rounds at least, and for how long at least.
const ROUNDS: usize = 15;
const LONG_ENOUGH: Duration = Duration::from_secs(4);
/// A round that is slower than this is not repeated for long.
const SLOW: Duration = Duration::from_secs(2);

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

/// Median seconds of a pass of each way, the ways taken in turn.
pub(crate) fn medians(ways: &mut [Way<'_>]) -> Vec<f64> {
    ways.iter_mut().for_each(|way| (way.pass)());
    let began = Instant::now();
    let mut seconds = vec![Vec::new(); ways.len()];
    loop {
        let round = Instant::now();
        for (way, seconds) in ways.iter_mut().zip(&mut seconds) {
            let start = Instant::now();
            (way.pass)();
            seconds.push(start.elapsed().as_secs_f64());
        }
        let enough = if round.elapsed() > SLOW { 5 } else { ROUNDS };
        let rounds = seconds.first().map_or(enough, Vec::len);
        if rounds >= enough && began.elapsed() > LONG_ENOUGH {
            return seconds.into_iter().map(median).collect();
        }
    }
}

/// Times the ways and says nanoseconds for each of `count` things and the ratio to the last way, the baseline.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn report(
    question: &str,
    thing: &str,
    count: usize,
    ways: &mut [Way<'_>],
) -> io::Result<()> {
    let seconds = medians(ways);
    let mut text =
        format!("\n{question} ({count} x {thing}, medians, one after the other in turn)\n");
    let baseline = seconds.last().copied().unwrap_or(f64::NAN);
    for (way, seconds) in ways.iter().zip(&seconds) {
        let each = 1e9 * seconds / count as f64;
        let (name, ratio) = (way.name, baseline / seconds);
        let _ = writeln!(text, "  {name:<28} {each:>10.1} ns a {thing:<10} {ratio:>8.3} x as fast");
    }
    say(&text)
}

/// Writes to standard output.
///
/// # Errors
/// It cannot be written.
pub(crate) fn say(text: &str) -> io::Result<()> {
    io::stdout().lock().write_all(text.as_bytes())
}
