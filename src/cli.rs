//! The command line: a file a command.
//!
//! Results go to standard output, progress and warnings to standard error. Exit status: 0 done; 2
//! anything the user can mend in what they gave; 1 could not (disk or pipe, no convergence, no
//! unique solution).

mod arguments;
mod calibrate;
mod catalogue;
mod check;
mod clean;
mod compare;
mod completions;
mod delays;
mod deviations;
mod diagnose;
mod doubts;
mod joint;
mod leave_out;
mod load;
mod new;
mod output;
mod power;
mod prior;
mod progress;
mod render;
mod shell;
mod show;
mod simulate;
mod suggestions;
mod threads;
mod trials;
mod wanted;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use serde_json::{Value, json};

use self::arguments::{CampaignArguments, Format};
use crate::diagnostic::{Diagnostic, Diagnostics};

/// Calibrates instruments in motion and finds out why simulation and reality differ.
#[derive(Debug, Parser)]
#[command(name = "homepoint", version, about, max_term_width = 100)]
#[command(
    after_help = "Start with `homepoint new`, or with a campaign that ships with the project:\n  homepoint calibrate examples/hand_eye"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a model to start from, about 20 lines
    New(new::New),
    /// Check models, effects and campaigns without computing anything
    Check(check::Check),
    /// Show a model's equations, with effects if asked for
    Show(show::Show),
    /// List the models
    Models(catalogue::Models),
    /// List the effects, and which of them a model can test
    Effects(catalogue::Effects),
    /// Draw a campaign's readings from its model
    Simulate(simulate::Simulate),
    /// Solve each reading for its own delay
    Delays(delays::DelaysCommand),
    /// Estimate delays, transformation and all other parameters jointly
    Calibrate(calibrate::CalibrateCommand),
    /// Find out why simulation and reality differ
    Diagnose(diagnose::Diagnose),
    /// Try the diagnosis on simulated campaigns of the same design
    Trials(trials::Trials),
    /// Find out what a campaign can see, before there are any data
    Power(power::PowerCommand),
    /// Compare the delay of each reading, in the mean, with the joint estimate
    Compare(compare::CompareCommand),
    /// Distances of measured points from the arm, and the motion that the head must follow
    Deviations(deviations::DeviationsCommand),
    /// Print a completion script for a shell, or the manual page
    Completions(completions::Completions),
}

impl Command {
    /// The arguments that it shares with others.
    fn common(&self) -> Option<&CampaignArguments> {
        match self {
            Self::Simulate(command) => Some(&command.common),
            Self::Delays(command) => Some(&command.common),
            Self::Calibrate(command) => Some(&command.common),
            Self::Diagnose(command) => Some(&command.common),
            Self::Trials(command) => Some(&command.common),
            Self::Power(command) => Some(&command.common),
            Self::Compare(command) => Some(&command.common),
            Self::Deviations(command) => Some(&command.common),
            Self::New(_)
            | Self::Check(_)
            | Self::Show(_)
            | Self::Models(_)
            | Self::Effects(_)
            | Self::Completions(_) => None,
        }
    }

    /// Whether warnings and progress are left out.
    fn quiet(&self) -> bool {
        match self {
            Self::New(command) => command.quiet,
            Self::Check(command) => command.quiet,
            Self::Show(command) => command.quiet,
            Self::Models(command) => command.quiet,
            Self::Effects(command) => command.quiet,
            other => other.common().is_some_and(|common| common.quiet),
        }
    }

    /// How its result is written.
    fn format(&self) -> Format {
        match self {
            Self::Models(command) => command.format,
            Self::Effects(command) => command.format,
            other => other.common().map_or(Format::Text, |common| common.format),
        }
    }
}

/// Why a command did not end well.
#[derive(Debug)]
enum Failure {
    /// Something the user can mend: exit status 2.
    Input(Diagnostics),
    /// It could not be done: exit status 1.
    Could(String),
    /// The same, with what programs are to know of it.
    NoAnswer(String, Value),
    /// In the result itself: exit status 1.
    Reported,
}

impl From<Diagnostics> for Failure {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Input(diagnostics)
    }
}

impl From<Diagnostic> for Failure {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::Input(diagnostic.into())
    }
}

/// Runs the program; returns its exit status.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are not errors; the rest is usage, status 2.
            let code = u8::try_from(error.exit_code()).unwrap_or(2);
            return if usage(error).is_ok() { ExitCode::from(code) } else { ExitCode::from(1) };
        }
    };
    let common = cli.command.common();
    let format = cli.command.format();
    let asked = common.and_then(|common| common.threads);
    let quiet = cli.command.quiet();
    match threads::Threads::start(asked, quiet).run(|| execute(cli.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ExitCode::from(failed(failure, format)),
    }
}

/// Prints help, or what is wrong with the arguments: as it is drawn, but for arguments that would
/// act on the terminal.
fn usage(mut error: clap::Error) -> std::io::Result<()> {
    suggestions::keep_near(&mut error);
    let acts = |argument: OsString| clean::acts_on_terminal(&argument.to_string_lossy());
    if !std::env::args_os().any(acts) {
        return error.print();
    }
    let plain = error.render().to_string();
    writeln!(anstream::stderr(), "{}", clean::text(&plain))
}

/// Says why a command did not end well, to people on standard error and to programs that asked for
/// JSON as the one object on standard output; the exit status.
fn failed(failure: Failure, format: Format) -> u8 {
    let (why, result) = match failure {
        Failure::Input(diagnostics) => {
            render::all(&diagnostics.0);
            return 2;
        }
        Failure::Could(why) => (why, json!({})),
        Failure::NoAnswer(why, result) => (why, result),
        Failure::Reported => return 1,
    };
    if format == Format::Json && !output::has_result() {
        let mut object = result;
        load::merge(&mut object, json!({ "error": why }));
        // A closed pipe is no reason to say less to people.
        let _ = output::json(&object);
    }
    render::one(&Diagnostic::error(why));
    1
}

fn execute(command: Command) -> Result<(), Failure> {
    match command {
        Command::New(command) => command.run(),
        Command::Check(command) => command.run(),
        Command::Show(command) => command.run(),
        Command::Models(command) => command.run(),
        Command::Effects(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Delays(command) => command.run(),
        Command::Calibrate(command) => command.run(),
        Command::Diagnose(command) => command.run(),
        Command::Trials(command) => command.run(),
        Command::Power(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Deviations(command) => command.run(),
        Command::Completions(command) => command.run(Cli::command()),
    }
}
