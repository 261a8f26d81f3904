//! The runs of a campaign with their setups, measured or planned, one after the other.

use crate::campaign::file::CampaignFile;
use crate::campaign::loader::Loader;
use crate::campaign::planned::planned;
use crate::campaign::record::Record;
use crate::campaign::run::Run;
use crate::campaign::samples::Samples;
use crate::diagnostic::Diagnostic;
use crate::document::entries::Named;
use crate::model::Model;

impl CampaignFile {
    pub(super) fn load_runs(
        &self,
        model: &Model,
        loader: &mut Loader<'_>,
    ) -> (Vec<String>, Vec<Run>) {
        let mut setups: Vec<String> = Vec::new();
        let mut runs: Vec<Run> = Vec::new();
        let mut empty: Vec<&Named> = Vec::new();
        for entry in &self.runs {
            let setup =
                setups.iter().position(|setup| *setup == entry.setup).unwrap_or_else(|| {
                    setups.push(entry.setup.clone());
                    setups.len() - 1
                });
            let record = if entry.plan.is_empty() {
                loader.run(entry)
            } else {
                let ended =
                    runs.iter().rev().find(|run| run.setup == setup).map(|run| end(&run.record));
                planned(model, loader, entry, ended.unwrap_or(0.0))
            };
            if let Some(record) = record {
                if entry.plan.is_empty() && !reads(&record) {
                    empty.push(&entry.name);
                }
                runs.push(Run { name: entry.name.text.clone(), setup, role: entry.role, record });
            }
        }
        loader.tell_outside();
        // Of a campaign without any reading that is said once, where readings are needed.
        if runs.iter().any(|run| reads(&run.record)) {
            loader.warnings.extend(empty.into_iter().map(|name| {
                Diagnostic::warning(format!("run `{}` has no reading at all", name.text))
                    .at(name.place.clone())
                    .help("nothing of it enters: are its columns those of the model's measurands?")
            }));
        }
        (setups, runs)
    }
}

/// Whether a record has any reading.
fn reads(record: &Record) -> bool {
    // An error ends the walk: one is enough.
    let walked = record.try_walk(|stretch| {
        let mut readings = stretch.samples.readings.iter().flat_map(|all| &all[stretch.range()]);
        if readings.any(|reading| !reading.is_nan()) { Err(()) } else { Ok(()) }
    });
    walked.is_err()
}

/// When the sample after a run's last one would come.
fn end(record: &Record) -> f64 {
    let mut scratch = Samples::default();
    let last = record.stretch(record.len().saturating_sub(2)..record.len(), &mut scratch);
    match last.samples.time[last.range()] {
        [.., before, last] => last + (last - before),
        [last] => last,
        [] => 0.0,
    }
}

/// Fills `setup_time`: since the smallest time of the setup's runs.
pub(super) fn setup_times(runs: &mut [Run]) {
    let starts: Vec<f64> = runs
        .iter()
        .map(|run| {
            let same = runs.iter().filter(|other| other.setup == run.setup);
            same.filter_map(|other| other.record.first_time()).fold(f64::INFINITY, f64::min)
        })
        .collect();
    for (run, start) in runs.iter_mut().zip(starts) {
        run.record.set_setup_start(start);
    }
}
