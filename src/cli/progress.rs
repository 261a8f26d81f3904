//! How far a command has come, with the time left, on standard error.
//!
//! One bar, for there is one terminal; none where standard error is not a terminal, with `--quiet`,
//! or where the command is done before anybody could read it.

use std::io::IsTerminal;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::progress::{Progress, Task};

/// A command that takes no longer shows no bar.
const PATIENCE: Duration = Duration::from_millis(500);
/// The bar with its task, counted in bytes or in samples.
const BYTES: &str = "{msg:22} {wide_bar} {bytes}/{total_bytes}  {left}";
const SAMPLES: &str = "{msg:22} {wide_bar} {percent:>3} %  {left}";

static SHOWN: OnceLock<Mutex<Shown>> = OnceLock::new();

struct Shown {
    begun: Instant,
    bar: Option<(Task, ProgressBar)>,
}

/// Where progress goes: the bar, unless nobody would see it or wants to.
pub(super) fn shown(quiet: bool) -> Progress {
    if quiet || !std::io::stderr().is_terminal() {
        return Progress::default();
    }
    let shown = SHOWN.get_or_init(|| Mutex::new(Shown { begun: Instant::now(), bar: None }));
    Progress::to(|task, done, all| {
        shown.lock().unwrap_or_else(PoisonError::into_inner).draw(task, done, all);
    })
}

/// Takes the bar away; it comes back with the next news.
pub(super) fn clear() {
    if let Some(shown) = SHOWN.get() {
        let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, bar)) = shown.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Shown {
    fn draw(&mut self, task: Task, done: u64, all: u64) {
        if self.begun.elapsed() < PATIENCE {
            return;
        }
        let bar = match self.bar.take() {
            Some((shown, bar)) if shown == task => bar,
            other => {
                if let Some((_, bar)) = other {
                    bar.finish_and_clear();
                }
                new(task, all)
            }
        };
        bar.set_length(all);
        bar.set_position(done);
        self.bar = Some((task, bar));
    }
}

/// The time left; before anything is done nobody knows it.
fn left(state: &ProgressState, text: &mut dyn std::fmt::Write) {
    if state.pos() > 0 {
        // A terminal that cannot be written to shows no bar; there is nobody to tell.
        let _ = write!(text, "{:#} left", HumanDuration(state.eta()));
    }
}

fn new(task: Task, all: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(all), ProgressDrawTarget::stderr());
    let form = if task == Task::Reading { BYTES } else { SAMPLES };
    if let Ok(style) = ProgressStyle::with_template(form) {
        bar.set_style(style.progress_chars("=> ").with_key("left", left));
    }
    bar.with_message(match task {
        Task::Reading => "reading".to_owned(),
        Task::Fitting { iteration } => format!("fitting, iteration {iteration}"),
        Task::Solving => "solving for delays".to_owned(),
        Task::Drawing => "drawing".to_owned(),
        Task::Trials => "trials".to_owned(),
    })
}
