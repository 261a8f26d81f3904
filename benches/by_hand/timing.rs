//! Several ways to the same answer timed in turn, round by round, so that whatever else the machine
//! does meets all of them alike.

use std::fmt::Write as _;
use std::io;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};

use crate::by_hand::process::say;

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
/// How long a way has its turn, at least one pass.
const TURN: Duration = Duration::from_millis(50);
/// A round that is slower than this is not repeated for long.
const SLOW: Duration = Duration::from_secs(2);

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

/// Seconds of a pass, repeated for a turn: a quick way is not timed with what a slow one left in
/// the caches.
fn turn(pass: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    let mut passes = 0.0;
    while start.elapsed() < TURN {
        pass();
        passes += 1.0;
    }
    start.elapsed().as_secs_f64() / passes
}

/// Median seconds of a pass of each way, the ways taken in turn.
pub(crate) fn medians(ways: &mut [Way<'_>]) -> Vec<f64> {
    ways.iter_mut().for_each(|way| (way.pass)());
    let began = Instant::now();
    let mut seconds = vec![Vec::new(); ways.len()];
    loop {
        let round = Instant::now();
        for (way, seconds) in ways.iter_mut().zip(&mut seconds) {
            seconds.push(turn(&mut way.pass));
        }
        let enough = if round.elapsed() > SLOW { 5 } else { ROUNDS };
        let rounds = seconds.first().map_or(enough, Vec::len);
        if rounds >= enough && began.elapsed() > LONG_ENOUGH {
            return seconds.into_iter().map(median).collect();
        }
    }
}

/// Times every way with criterion, which keeps its history; then all ways in turn, and says
/// nanoseconds for each of `count` things and how fast each way is against the last one, the
/// baseline. Returns the seconds of a pass of each.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn compare(
    criterion: &mut Criterion,
    question: &str,
    (count, thing): (usize, &str),
    ways: &mut [Way<'_>],
) -> io::Result<Vec<f64>> {
    let mut group = criterion.benchmark_group(question);
    group.throughput(Throughput::Elements(count as u64));
    for way in &mut *ways {
        group.bench_function(way.name, |bench| bench.iter(|| (way.pass)()));
    }
    group.finish();
    let seconds = medians(ways);
    let baseline = seconds.last().copied().unwrap_or(f64::NAN);
    let mut text = format!("\n{question}: {count} x {thing}, medians of passes taken in turn\n");
    for (way, seconds) in ways.iter().zip(&seconds) {
        let (name, each, ratio) = (way.name, 1e9 * seconds / count as f64, baseline / seconds);
        let _ = writeln!(text, "  {name:<24} {each:>10.1} ns a {thing}, {ratio:>7.3} x as fast");
    }
    say(&text)?;
    Ok(seconds)
}

/// Criterion set for passes of milliseconds to seconds.
pub(crate) fn criterion() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args()
}
