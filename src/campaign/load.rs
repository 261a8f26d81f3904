//! A campaign read against its model: units settled, signals ready, every sigma known.

mod inputs;
mod runs;
mod uncertainties;

use std::collections::HashSet;

use crate::campaign::calibration::InputSpread;
use crate::campaign::delay_range::DelayRange;
use crate::campaign::file::CampaignFile;
use crate::campaign::loader::Loader;
use crate::campaign::overlap::overlap;
use crate::campaign::recorder::Store;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::document::COPY_INTO_FOLDER;
use crate::document::entries::Named;
use crate::document::files::Refused;
use crate::library::{effect_files, model_file};
use crate::model::Model;
use runs::setup_times;

pub use crate::campaign::loaded::{Campaign, LeftOut, LoadOptions, MEMORY};

impl CampaignFile {
    /// Reads the data of all runs against a model.
    ///
    /// # Errors
    /// Every fault found: inputs or measurands the model does not have, a sigma missing or not
    /// positive, wrong dimensions, faults of the data files, runs that lack an input.
    pub fn load(self, model: &Model, options: &LoadOptions) -> Result<Campaign, Diagnostics> {
        self.load_into(&mut Store::new(options.memory), model, options)
    }

    /// The same with memory that several campaigns share, instead of that of the options.
    ///
    /// # Errors
    /// As for [`CampaignFile::load`].
    pub fn load_into(
        mut self,
        store: &mut Store,
        model: &Model,
        options: &LoadOptions,
    ) -> Result<Campaign, Diagnostics> {
        self.files.show_outside(options.show_outside);
        self.declare_files(options.confined)?;
        let stated = options.delay_range.map(DelayRange::even).or(self.delay_range.clone());
        let mut loader = Loader {
            model,
            folder: self.folder.clone(),
            reader: self.reader.clone(),
            files: self.files.clone(),
            inputs: Vec::new(),
            delay_range: stated.unwrap_or_default(),
            delay_ranges: Vec::new(),
            skip_bad_rows: options.skip_bad_rows,
            warnings: Vec::new(),
            warned: HashSet::new(),
            skipped: Vec::new(),
            skipped_count: 0,
            left_out: Vec::new(),
            streamed: Vec::new(),
            recognised: Vec::new(),
            timing: self.timing.clone(),
            request_to_reply: Vec::new(),
            head_units: Vec::new(),
            store,
            progress: options.progress.clone(),
            bytes: (0, self.bytes()),
        };
        let (inputs, input_spread) = self.input_settings(model, &mut loader);
        loader.inputs = inputs;
        loader.delay_ranges = loader.delay_range.of(model, &mut loader.reader);
        let (mut measurand_sigma, measurand_degrees_of_freedom) =
            self.measurand_sigmas(model, &mut loader);
        self.check_constants(model, &mut loader);
        let (setups, mut runs) = self.load_runs(model, &mut loader);
        setup_times(&mut runs);
        loader.warnings.extend(overlap(&self.runs, &runs));
        self.need_sigmas(model, &mut loader, &runs, &mut measurand_sigma);
        loader.reader.result()?;
        let name = std::path::absolute(&self.folder)
            .ok()
            .and_then(|folder| Some(folder.file_name()?.to_string_lossy().into_owned()))
            .unwrap_or_else(|| "campaign".to_owned());
        Ok(Campaign {
            title: if self.title.is_empty() { name.clone() } else { self.title },
            name,
            folder: self.folder,
            source: self.reader.source,
            model: self.model,
            instrument: self.instrument,
            rig: self.rig,
            effects: self.effects,
            metadata: self.metadata,
            setups,
            runs,
            entries: self.runs,
            parameters: self.parameters,
            inputs: self.inputs,
            input_sigma: input_spread.iter().map(InputSpread::random).collect(),
            input_spread,
            measurand_sigma,
            output: self.output,
            specification: self.specification,
            measurand_degrees_of_freedom,
            delay_range: loader.delay_range,
            zero: if self.timing.is_none() { loader.store.zero(None) } else { 0 },
            timing: self.timing,
            request_to_reply: loader.request_to_reply,
            head_units: loader.head_units,
            warnings: loader.warnings,
            skipped: loader.skipped,
            skipped_count: loader.skipped_count,
            left_out: loader.left_out,
            recognised: loader.recognised,
            files: loader.files,
        })
    }

    /// Takes the files of the model and of effects, which others read, for files of the campaign.
    ///
    /// # Errors
    /// The campaign's own file lies outside its folder, and that is not allowed.
    fn declare_files(&mut self, confined: bool) -> Result<(), Diagnostics> {
        self.files.confine(confined);
        if confined && self.files.is_outside(&self.path) {
            let message = format!("`{}` {}", self.path.display(), Refused::Outside);
            return Err(Diagnostic::error(message).help(COPY_INTO_FOLDER).into());
        }
        let effects = effect_files(&self.folder.join("effects")).unwrap_or_default();
        for file in model_file(&self.model.text, &self.folder).iter().chain(&effects) {
            self.files.note(file);
        }
        Ok(())
    }

    /// Bytes of all data files, as far as they are there.
    fn bytes(&self) -> u64 {
        let names = self.runs.iter().flat_map(|run| {
            let tables = run.data.iter().chain(&run.signals).map(|table| &table.name);
            tables.chain(run.timing.captures.iter())
        });
        let size = |name: &Named| std::fs::metadata(self.folder.join(&name.text)).ok();
        names.filter_map(size).map(|file| file.len()).sum()
    }
}
