//! The `homepoint` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    homepoint::cli::run()
}
