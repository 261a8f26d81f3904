//! `homepoint trials`: how well a diagnosis does on this campaign, by trials whose truth is known.

mod replay;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::arguments::{CampaignArguments, Format};
use super::load::refusals;
use super::{Failure, load, output, progress, render};
use crate::diagnostic::Diagnostic;
use crate::engine::open::Opened;
use crate::report;
use crate::trials::design::Design;
use crate::trials::heading::Heading;
use crate::trials::ledger::{Ledger, LedgerError};
use crate::trials::plan::{Kind, Plan};
use crate::trials::{run, tally::tally};

/// The file of finished trials.
const LEDGER: &str = "trials.jsonl";
/// Trials where nothing else is asked for.
const TRIALS: usize = 200;
/// Trials of each special situation.
const OF_EACH_SITUATION: usize = 8;

#[derive(Debug, Args)]
pub(super) struct Trials {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    /// Simulate and diagnose this many campaigns (200; of special situations 8 of each)
    #[arg(long, value_name = "N")]
    trials: Option<usize>,
    /// Seed of the random numbers; the same seed gives the same score
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Try this alone (repeat for more)
    #[arg(long = "kind", value_name = "KIND", value_enum)]
    kinds: Vec<KindChoice>,
    /// Give effects this length, in units of the noise (repeat for more)
    #[arg(long = "lambda", value_name = "LAMBDA")]
    lambdas: Vec<f64>,
    /// Try special situations: error codes, outliers, knocks, wrong statements, bad noise
    #[arg(long, conflicts_with_all = ["kinds", "lambdas", "mixtures"])]
    situations: bool,
    /// Try three to five effects at once, also beside a cause outside the library
    #[arg(long, conflicts_with_all = ["kinds", "lambdas"])]
    mixtures: bool,
    /// A line for each effect
    #[arg(long)]
    each: bool,
    /// Make the recorded trials of this file again and list what differs
    #[arg(long, value_name = "LEDGER", conflicts_with_all = ["trials", "seed", "kinds", "lambdas", "situations", "mixtures", "each"])]
    replay: Option<PathBuf>,
    /// Replay this many of them, spread over all kinds
    #[arg(long, value_name = "N", requires = "replay")]
    sample: Option<usize>,
    /// What is compared with the recorded trials
    #[arg(long, value_enum, default_value_t, requires = "replay")]
    compare: Comparison,
}

/// What is compared with recorded trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Comparison {
    /// Verdict, names and probabilities of each trial
    #[default]
    Each,
    /// The scores, for a diagnosis that has changed: only a worse one counts
    Summary,
}

/// What is true in a trial.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum KindChoice {
    /// Nothing but the stated noise
    None,
    /// One effect
    One,
    /// Two effects
    Two,
    /// One effect that the library of the diagnosis lacks
    Withheld,
    /// Noise that is not what is stated
    Noise,
}

impl From<KindChoice> for Kind {
    fn from(choice: KindChoice) -> Self {
        match choice {
            KindChoice::None => Self::None,
            KindChoice::One => Self::One,
            KindChoice::Two => Self::Two,
            KindChoice::Withheld => Self::Withheld,
            KindChoice::Noise => Self::Noise,
        }
    }
}

impl Trials {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if let Some(wrong) = self.lambdas.iter().find(|one| !one.is_finite() || **one <= 0.0) {
            return Err(Diagnostic::error(format!("`--lambda {wrong}` is no length"))
                .help("a number above 0, as in --lambda 8; effects are declared from about 5")
                .into());
        }
        if self.trials == Some(0) {
            return Err(Diagnostic::error("`--trials 0` tries nothing")
                .help("a rate needs trials: 200 say something, 4500 say it well")
                .into());
        }
        if let Some(path) = &self.replay {
            return replay::run(self, path);
        }
        let (design, about) = self.design()?;
        let plan = self.plan();
        let heading = Heading::of(&plan, &design);
        let mut ledger = match &self.common.out {
            Some(folder) => Some(ledger(folder, &heading)?),
            None => None,
        };
        let unreadable = ledger.as_ref().map_or(0, |one| one.unreadable);
        self.warn_of_unreadable(LEDGER, unreadable, "the trials that stood there are made again");
        let shown = progress::shown(self.common.quiet);
        let outcomes =
            run(&design, &plan, ledger.as_mut(), rayon::current_num_threads(), &shown)
                .map_err(|error| Failure::Could(format!("cannot write {LEDGER}: {error}")))?;
        let score = tally(&outcomes);
        match self.common.format {
            Format::Json => {
                let mut value = about.head;
                load::merge(&mut value, report::trials::json(&score, self.seed));
                output::json(&value)
            }
            Format::Text => {
                output::text(&report::trials_text::text(&about.title, &score, self.each))
            }
        }
    }

    /// The campaign, ready for trials, and what is said of it.
    fn design(&self) -> Result<(Design, About), Failure> {
        let loaded = load::load(&self.common)?;
        loaded.keep_files(self.common.out.as_ref(), [LEDGER])?;
        refusals::refuse_correlated(&loaded.problem)?;
        let opened = Opened {
            problem: loaded.problem,
            campaigns: loaded.campaigns,
            models: loaded.models,
            warnings: Vec::new(),
            stated: loaded.stated,
            recipes: loaded.recipes,
        };
        let design = Design::new(opened).map_err(|error| Failure::Could(error.to_string()))?;
        Ok((design, About { title: loaded.title, head: loaded.head }))
    }

    fn warn_of_unreadable(&self, file: &str, lines: usize, help: &str) {
        if lines > 0 && !self.common.quiet {
            let are = if lines == 1 { "1 line" } else { &format!("{lines} lines") };
            let message = format!("{are} of {file} cannot be read");
            render::all(&[Diagnostic::warning(message).help(help)]);
        }
    }

    fn plan(&self) -> Plan {
        let trials = self.trials.unwrap_or(TRIALS);
        if self.situations {
            let each = Plan::situations(0, self.seed).strata.len() * OF_EACH_SITUATION;
            return Plan::situations(self.trials.unwrap_or(each), self.seed);
        }
        if self.mixtures {
            return Plan::mixtures(trials, self.seed);
        }
        if self.kinds.is_empty() && self.lambdas.is_empty() {
            return Plan::standard(trials, self.seed);
        }
        let kinds: Vec<Kind> = if self.kinds.is_empty() {
            vec![Kind::One, Kind::Two, Kind::Withheld]
        } else {
            self.kinds.iter().map(|kind| Kind::from(*kind)).collect()
        };
        Plan::of(trials, self.seed, &kinds, &self.lambdas)
    }
}

/// What is said of a campaign.
struct About {
    title: String,
    /// What a result for programs begins with.
    head: serde_json::Value,
}

/// The file of finished trials in a folder.
fn ledger(folder: &Path, heading: &Heading) -> Result<Ledger, Failure> {
    let path = folder.join(LEDGER);
    let cannot = |why: String| format!("cannot go on with {}: {why}", path.display());
    std::fs::create_dir_all(folder).map_err(|error| Failure::Could(cannot(error.to_string())))?;
    Ledger::open(&path, heading).map_err(|error| match error {
        LedgerError::Other { .. } | LedgerError::NoHeading => Diagnostic::error(cannot(error.to_string()))
            .help("name another folder with `--out`, or give the same seed, kinds, sizes, campaign and library")
            .into(),
        LedgerError::Disk(_) | LedgerError::Unread(_) => {
            Failure::Could(cannot(error.to_string()))
        }
    })
}
