//! `homepoint trials --replay`: recorded trials made again, and what differs.

use std::path::Path;

use crate::cli::arguments::Format;
use crate::cli::{Failure, load, output, progress, render};
use crate::diagnostic::Diagnostic;
use crate::report::trials_replay::{self, Replayed};
use crate::report::trials_replay_text;
use crate::trials::heading::Heading;
use crate::trials::ledger::{LedgerError, Recorded};
use crate::trials::paired::compare;
use crate::trials::replay::{self, Pair, ReplayError};

use super::{Comparison, Trials};

/// Exit status 1 where something differs, or, of scores, is worse.
pub(super) fn run(arguments: &Trials, path: &Path) -> Result<(), Failure> {
    if arguments.common.out.is_some() {
        return Err(Diagnostic::error("`--out` has no use with `--replay`: it writes no file")
            .help("leave one of them out")
            .into());
    }
    if arguments.sample == Some(0) {
        return Err(Diagnostic::error("`--sample 0` replays nothing")
            .help("a number of trials, as in --sample 40; without it all are replayed")
            .into());
    }
    let recorded = read(path)?;
    let file = path.display().to_string();
    arguments.warn_of_unreadable(&file, recorded.unreadable.len(), "they are not replayed");
    let plan = replay::plan(&recorded).map_err(|error| refused(path, &error))?;
    let (design, about) = arguments.design()?;
    let present = Heading::of(&plan, &design);
    let is_summary = arguments.compare == Comparison::Summary;
    let mut warnings = Vec::new();
    if let Err(error) = replay::same_design(&recorded.heading, &present) {
        if !is_summary {
            return Err(refused(path, &error));
        }
        let help = "trials that turn out to be other ones are counted, and left out of the scores";
        warnings.push(Diagnostic::warning(error.to_string()).help(help));
    }
    if recorded.heading.version != present.version {
        let was = match recorded.heading.version.as_str() {
            "" => "an unknown version",
            version => version,
        };
        let message = format!("its trials were recorded by {was}, this is {}", present.version);
        warnings.push(Diagnostic::warning(message));
    }
    if !arguments.common.quiet {
        render::all(&warnings);
    }
    let total = recorded.outcomes.len();
    let chosen = replay::sample(&plan, &recorded.outcomes, arguments.sample.unwrap_or(total));
    let shown = progress::shown(arguments.common.quiet);
    let pairs = replay::replay(&design, &plan, chosen, rayon::current_num_threads(), &shown);
    let replayed = compared(&pairs, is_summary, total);
    match arguments.common.format {
        Format::Json => {
            let mut value = about.head;
            load::merge(&mut value, trials_replay::json(&replayed));
            output::json(&value)?;
        }
        Format::Text => output::text(&trials_replay_text::text(&about.title, &replayed))?,
    }
    if replayed.is_good() { Ok(()) } else { Err(Failure::Reported) }
}

fn compared(pairs: &[Pair], is_summary: bool, total: usize) -> Replayed {
    if is_summary {
        Replayed::Summary { summary: compare(pairs), total }
    } else {
        Replayed::each(pairs, total)
    }
}

fn read(path: &Path) -> Result<Recorded, Failure> {
    Recorded::read(path).map_err(|error| {
        let message = match error {
            LedgerError::Unread(why) => why,
            other => format!("`{}` is no file of trials: {other}", path.display()),
        };
        Diagnostic::error(message)
            .help("name a file that `homepoint trials CAMPAIGN --out DIR` wrote: DIR/trials.jsonl, plain or packed as .gz")
            .into()
    })
}

fn refused(path: &Path, error: &ReplayError) -> Failure {
    let message = format!("cannot replay `{}`: {error}", path.display());
    let help = match error {
        ReplayError::Design { .. } => {
            "name the campaign that it was made of, with the same effects; or compare scores alone: --compare summary"
        }
        ReplayError::Plan => "it was written by a later version, or changed by hand: make it again",
        ReplayError::Empty => "make some: homepoint trials CAMPAIGN --out DIR",
    };
    Diagnostic::error(message).help(help).into()
}
