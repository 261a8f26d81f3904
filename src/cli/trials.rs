//! `homepoint trials`: how well a diagnosis does on this campaign, by trials whose truth is known.

use std::path::Path;

use clap::{Args, ValueEnum};

use super::arguments::{CampaignArguments, Format};
use super::{Failure, load, output, progress, render};
use crate::diagnostic::Diagnostic;
use crate::engine::open::Opened;
use crate::report;
use crate::trials::design::Design;
use crate::trials::ledger::{Heading, Ledger, LedgerError};
use crate::trials::plan::{Kind, Plan};
use crate::trials::{run, tally::tally};

/// The file of finished trials.
const LEDGER: &str = "trials.jsonl";

#[derive(Debug, Args)]
pub(super) struct Trials {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    /// Simulate and diagnose this many campaigns
    #[arg(long, value_name = "N", default_value_t = 200)]
    trials: usize,
    /// Seed of the random numbers; the same seed gives the same score
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Try this alone (repeat for more)
    #[arg(long = "kind", value_name = "KIND", value_enum)]
    kinds: Vec<KindChoice>,
    /// Give effects this length, in units of the noise (repeat for more)
    #[arg(long = "lambda", value_name = "LAMBDA")]
    lambdas: Vec<f64>,
    /// A line for each effect
    #[arg(long)]
    each: bool,
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
        if self.trials == 0 {
            return Err(Diagnostic::error("`--trials 0` tries nothing")
                .help("a rate needs trials: 200 say something, 4500 say it well")
                .into());
        }
        let loaded = load::load(&self.common)?;
        loaded.keep_files(self.common.out.as_ref(), [LEDGER])?;
        load::refuse_correlated(&loaded.problem)?;
        let opened = Opened {
            problem: loaded.problem,
            campaigns: loaded.campaigns,
            models: loaded.models,
            warnings: Vec::new(),
            stated: loaded.stated,
            recipes: loaded.recipes,
        };
        let could = |error: &dyn std::fmt::Display| Failure::Could(error.to_string());
        let design = Design::new(opened).map_err(|error| could(&error))?;
        let plan = self.plan();
        let mut ledger = match &self.common.out {
            Some(folder) => Some(ledger(folder, &Heading::of(&plan, &design))?),
            None => None,
        };
        if let Some(lines) = ledger.as_ref().map(|one| one.unreadable).filter(|lines| *lines > 0)
            && !self.common.quiet
        {
            let are = if lines == 1 { "1 line" } else { &format!("{lines} lines") };
            let message = format!("{are} of {LEDGER} cannot be read");
            let help = "the trials that stood there are made again";
            render::all(&[Diagnostic::warning(message).help(help)]);
        }
        let threads = rayon::current_num_threads();
        let told = progress::shown(self.common.quiet);
        let outcomes = run(&design, &plan, ledger.as_mut(), threads, &told)
            .map_err(|error| Failure::Could(format!("cannot write {LEDGER}: {error}")))?;
        let score = tally(&outcomes);
        match self.common.format {
            Format::Json => {
                let mut value = loaded.head.clone();
                load::merge(&mut value, report::trials::json(&score, self.seed));
                output::json(&value)
            }
            Format::Text => {
                output::text(&report::trials_text::text(&loaded.title, &score, self.each))
            }
        }
    }

    fn plan(&self) -> Plan {
        if self.kinds.is_empty() && self.lambdas.is_empty() {
            return Plan::standard(self.trials, self.seed);
        }
        let kinds: Vec<Kind> = if self.kinds.is_empty() {
            vec![Kind::One, Kind::Two, Kind::Withheld]
        } else {
            self.kinds.iter().map(|kind| Kind::from(*kind)).collect()
        };
        Plan::of(self.trials, self.seed, &kinds, &self.lambdas)
    }
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
        LedgerError::Disk(error) => Failure::Could(cannot(error.to_string())),
    })
}
