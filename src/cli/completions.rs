//! `homepoint completions`: completion scripts and the manual page.

use clap::{Args, ValueEnum};

use super::{Failure, output};

/// For whom.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum For {
    Bash,
    Elvish,
    Fish,
    Powershell,
    Zsh,
    Man,
}

#[derive(Debug, Args)]
pub(super) struct Completions {
    /// The shell, or `man` for the manual page
    #[arg(value_enum)]
    shell: For,
}

impl Completions {
    pub(super) fn run(&self, mut command: clap::Command) -> Result<(), Failure> {
        use clap_complete::{Shell, generate};
        let mut text = Vec::new();
        let shell = match self.shell {
            For::Bash => Shell::Bash,
            For::Elvish => Shell::Elvish,
            For::Fish => Shell::Fish,
            For::Powershell => Shell::PowerShell,
            For::Zsh => Shell::Zsh,
            For::Man => {
                clap_mangen::Man::new(command)
                    .render(&mut text)
                    .map_err(|error| Failure::Could(error.to_string()))?;
                return output::text(&String::from_utf8_lossy(&text));
            }
        };
        generate(shell, &mut command, "homepoint", &mut text);
        output::text(&String::from_utf8_lossy(&text))
    }
}
