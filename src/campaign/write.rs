//! Writes a campaign of the same form: campaign.toml and a CSV a run, in the model's units.
//!
//! Files are whole or not at all: written beside their place and then renamed. Streams are copied.

mod campaign_toml;
mod targets;

use std::fs;
use std::io;
use std::path::Path;

use crate::campaign::loaded::Campaign;
use crate::campaign::run::Run;
use crate::campaign::whole::{WholeFile, write_whole};
use crate::campaign::write_run::RunTable;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::document::files::open_regular;
use crate::model::Model;
use targets::{CAMPAIGN, Targets};

pub use campaign_toml::write_campaign_toml;

/// Writes a campaign with other runs (simulated ones) into a folder, which is made if need be.
///
/// `runs` are in the order of the campaign's own; constants of runs stay in campaign.toml, streams
/// are copied beside it. What the user should look at is returned.
///
/// # Errors
/// The disk's; those of [`check_targets`].
pub fn write_campaign(
    folder: &Path,
    campaign: &Campaign,
    model: &Model,
    runs: &[Run],
) -> io::Result<Vec<Diagnostic>> {
    write_campaign_with(folder, campaign, model, runs, &mut |run, table| {
        runs[run].record.try_walk(|stretch| table.write(stretch, None))
    })
}

/// The same with other readings: `fill` writes the table of each run, by its index.
///
/// # Errors
/// As for [`write_campaign`].
pub fn write_campaign_with(
    folder: &Path,
    campaign: &Campaign,
    model: &Model,
    runs: &[Run],
    fill: &mut dyn FnMut(usize, &mut RunTable) -> io::Result<()>,
) -> io::Result<Vec<Diagnostic>> {
    let targets = Targets::of(folder, campaign, runs).map_err(io::Error::other)?;
    fs::create_dir_all(folder)?;
    for (place, text) in &targets.declarations {
        let place = folder.join(place);
        place.parent().map_or(Ok(()), fs::create_dir_all)?;
        write_whole(&place, text.as_bytes())?;
    }
    let mut warnings = Vec::new();
    for (index, (run, file)) in runs.iter().zip(&targets.tables).enumerate() {
        let timing = campaign.timing.as_ref().zip(campaign.entries.get(index));
        let replies = campaign.request_to_reply.iter().find(|one| one.run == run.name);
        let capturing = timing.map(|(timing, entry)| timing.capturing(&entry.timing, replies));
        let path = folder.join(file);
        let mut table = RunTable::create_captured(&path, model, &run.record, capturing)?;
        table.count_from(campaign.zero);
        fill(index, &mut table)?;
        warnings.extend(table.finish()?.into_iter().map(|gap| gap.warning(&run.name)));
    }
    for (stream, name) in &targets.streams {
        let mut file = WholeFile::create(&folder.join(name))?;
        io::copy(&mut open_regular(&campaign.folder.join(stream))?, &mut file)?;
        file.finish()?;
    }
    let Targets { tables, streams, .. } = &targets;
    write_campaign_toml(&folder.join(CAMPAIGN), campaign, model, runs, tables, streams)?;
    Ok(warnings)
}

/// Whether a campaign can be written into a folder.
///
/// # Errors
/// A file that the campaign reads would be replaced; a file that would be copied is a link that
/// leads out of the campaign's folder.
pub fn check_targets(folder: &Path, campaign: &Campaign, runs: &[Run]) -> Result<(), Diagnostics> {
    Targets::of(folder, campaign, runs).map(drop)
}
