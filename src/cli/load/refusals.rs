//! Problems that commands refuse: no readings, readings that are correlated, standard uncertainties
//! that cannot be, samples that cannot be read back.

use std::io;

use crate::cli::Failure;
use crate::diagnostic::{Diagnostic, Span};
use crate::engine::open::correlated;
use crate::engine::{Point, Problem};
use crate::report;

/// Refuses a standard uncertainty stated as a formula that is no positive number for some reading.
pub(in crate::cli) fn refuse_impossible_sigma(
    problem: &Problem,
    at: &Point,
) -> Result<(), Failure> {
    let Some((p, run, sample, m, sigma)) = problem.impossible_sigma(at) else {
        return Ok(());
    };
    let part = &problem.parts[p];
    let (run, one) = (&part.runs[run], &part.system.assembly.names.measurands[m]);
    let found = report::figure::size(sigma, &one.unit);
    let message = format!(
        "the standard uncertainty of `{}` is {found} in run `{}`, row {}: expected a number above zero",
        one.name,
        run.name,
        run.record.row(sample)
    );
    let formula = one.sigma.as_ref();
    let place = formula.map(|formula| {
        formula.source.place(Span::new(formula.offset, formula.offset + formula.text.len()))
    });
    let error = Diagnostic::error(message).at_maybe(place.as_ref());
    Err(error.help("see its formula and, where it names a column, that cell; leave the reading empty if it is not to count").into())
}

/// Refuses what estimators cannot take account of.
pub(in crate::cli) fn refuse_correlated(problem: &Problem) -> Result<(), Failure> {
    let names = correlated(problem);
    if names.is_empty() {
        return Ok(());
    }
    let names = names.join("`, `");
    Err(Diagnostic::error(format!(
        "`{names}` is correlated from reading to reading, which this estimate does not take account of"
    ))
    .help("leave the effect out; `simulate` can put it in")
    .into())
}

/// Refuses campaigns without readings.
pub(in crate::cli) fn refuse_empty(problem: &Problem) -> Result<(), Failure> {
    if problem.reading_count() > 0 {
        return Ok(());
    }
    Err(Diagnostic::error("there are no readings to estimate from: all runs are planned or empty")
        .help("`homepoint simulate` draws readings from a plan")
        .into())
}

/// Whether all samples could be read back from where they were kept: results are good for nothing
/// otherwise.
pub(in crate::cli) fn read_back(problem: &Problem) -> io::Result<()> {
    let mut runs = problem.parts.iter().flat_map(|part| &part.runs);
    let lost = runs.find_map(|run| Some((&run.name, run.record.fault()?)));
    lost.map_or(Ok(()), |(name, why)| {
        let message = format!("run `{name}` cannot be read back from its temporary file: {why}");
        Err(io::Error::other(message))
    })
}

/// The same, as the end of a command.
pub(in crate::cli) fn trust(problem: &Problem) -> Result<(), Failure> {
    read_back(problem).map_err(|error| Failure::Could(error.to_string()))
}
