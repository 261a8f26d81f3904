//! A campaign read against its model: units settled, signals ready, every sigma known.

use std::collections::HashSet;

use crate::campaign::calibration::InputSpread;
use crate::campaign::columns::reading_columns;
use crate::campaign::delay_range::DelayRange;
use crate::campaign::file::CampaignFile;
use crate::campaign::loader::{InputSetting, Loader};
use crate::campaign::overlap::overlap;
use crate::campaign::planned::planned;
use crate::campaign::record::Record;
use crate::campaign::recorder::Store;
use crate::campaign::run::Run;
use crate::campaign::samples::Samples;
use crate::campaign::spline::Smoothing;
use crate::campaign::statement;
use crate::diagnostic::{Diagnostic, Diagnostics, Span};
use crate::document::COPY_INTO_FOLDER;
use crate::document::entries::{Item, Named, get};
use crate::document::files::Refused;
use crate::formula::Formula;
use crate::formula::angles::brings_angle;
use crate::library::{effect_files, model_file};
use crate::model::Model;
use crate::units::Unit;

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

    fn input_settings(
        &self,
        model: &Model,
        loader: &mut Loader<'_>,
    ) -> (Vec<InputSetting>, Vec<InputSpread>) {
        let known: Vec<&str> = model.inputs.iter().map(|input| input.name.as_str()).collect();
        for over in &self.inputs {
            if !known.contains(&over.name.text.as_str()) {
                loader.reader.unknown(over.name.span, "input", &over.name.text, &known);
            }
        }
        let mut settings = Vec::new();
        let mut spreads = Vec::new();
        for input in &model.inputs {
            let over = self.inputs.iter().find(|over| over.name.text == input.name);
            let unit = &input.unit;
            let mut say = |item: Option<&Item>, what: &str, like: &Unit| {
                let item = item?;
                loader.reader.positive_of(item, &format!("{what} of `{}`", input.name), like)
            };
            let sigma = say(over.and_then(|o| o.sigma.as_ref()), "sigma", unit).or(input.sigma);
            let resolution = say(over.and_then(|o| o.resolution.as_ref()), "resolution", unit);
            let smooth = say(over.and_then(|o| o.smooth.as_ref()), "smooth", &Unit::second())
                .or(input.smooth);
            let period = say(over.and_then(|o| o.period.as_ref()), "period", unit).or(input.period);
            let (calibration, corrections) = over
                .and_then(|o| o.calibration.as_ref())
                .map_or((None, None), |item| loader.calibration(input, item));
            let spread = InputSpread { noise: sigma, resolution, calibration };
            let smoothing = match (smooth, spread.random().filter(|sigma| *sigma > 0.0)) {
                // `smooth` is the period of an oscillation that comes out half as large.
                (Some(period), _) => Smoothing::TimeConstant(period / std::f64::consts::TAU),
                (None, Some(sigma)) => Smoothing::Noise(sigma),
                (None, None) => Smoothing::CrossValidation,
            };
            let needed = needs(model, &input.name);
            settings.push(InputSetting { smoothing, period, needed, corrections });
            spreads.push(spread);
        }
        (settings, spreads)
    }

    /// Standard uncertainty of a reading of each measurand, and the degrees of freedom it rests on.
    fn measurand_sigmas(
        &self,
        model: &Model,
        loader: &mut Loader<'_>,
    ) -> (Vec<f64>, Vec<Option<f64>>) {
        let known: Vec<&str> = model.measurands.iter().map(|m| m.name.as_str()).collect();
        let rates = self.specification.rates.iter().map(|(name, _)| name);
        for name in self.measurands.iter().map(|over| &over.name).chain(rates) {
            if !known.contains(&name.text.as_str()) {
                loader.reader.unknown(name.span, "measurand", &name.text, &known);
            }
        }
        let (mut sigmas, mut degrees) = (Vec::new(), Vec::new());
        for measurand in &model.measurands {
            let name = &measurand.name;
            if measurand.sigma_formula.is_some() {
                // The formula has all of it.
                let over = self.measurands.iter().find(|over| &over.name.text == name);
                let said = over.map_or(&[][..], |over| &over.said);
                if let Some(also) = said.iter().find(|entry| entry.key != "sigma") {
                    let message =
                        format!("`{}` stands beside a `sigma` that is a formula", also.key);
                    loader.reader.fault(also.span, message, "state one of them");
                }
                if let Some(formula) = over.and_then(|over| over.sigma.as_ref()) {
                    check_angles(model, loader, (name, formula), &measurand.unit);
                }
                sigmas.push(1.0);
                degrees.push(None);
                continue;
            }
            let over = self.measurands.iter().find(|over| &over.name.text == name);
            let said = over.map_or(&[][..], |over| &over.said);
            let stated = get(said, "sigma").or(get(said, "U"));
            let what = format!("`{name}`");
            let spread = statement::spread(&mut loader.reader, said, &what, &measurand.unit);
            let own = if stated.is_none() { measurand.sigma } else { None };
            let sigma = spread.map(|spread| spread.sigma).or(own);
            degrees.push(spread.and_then(|spread| spread.degrees_of_freedom));
            sigmas.push(match (sigma, stated) {
                (None, None) => f64::NAN,
                // A fault is noted already.
                (None, Some(_)) => 1.0,
                (Some(sigma), _) => sigma,
            });
        }
        (sigmas, degrees)
    }

    /// A sigma is needed of every measurand that is read, or may be: then a fault, else 1.
    fn need_sigmas(
        &self,
        model: &Model,
        loader: &mut Loader<'_>,
        runs: &[Run],
        sigmas: &mut [f64],
    ) {
        let planned = self.runs.iter().any(|run| !run.plan.is_empty());
        let columns = reading_columns(model);
        for (index, (measurand, sigma)) in model.measurands.iter().zip(sigmas).enumerate() {
            let read = |run: &Run| {
                let mut read = false;
                run.record.walk(|stretch| {
                    let all = columns.iter().zip(&stretch.samples.readings);
                    let mut own = all.filter(|((of, _), _)| *of == index);
                    read |= own.any(|(_, v)| v[stretch.range()].iter().any(|v| !v.is_nan()));
                });
                read
            };
            if !sigma.is_nan() {
                continue;
            }
            *sigma = 1.0;
            if planned || runs.iter().any(read) {
                let name = &measurand.name;
                let over = self.measurands.iter().find(|over| &over.name.text == name);
                let span = over.map_or(Span::default(), |over| over.name.span);
                let message = format!("the standard uncertainty of `{name}` is not stated");
                let symbol = &measurand.unit.symbol;
                let help = format!("in [measurands] write {name} = {{ sigma = \"... {symbol}\" }}");
                loader.reader.fault(span, message, help);
            }
        }
    }

    /// Constants of runs must be inputs of the model.
    fn check_constants(&self, model: &Model, loader: &mut Loader<'_>) {
        let known: Vec<&str> = model.inputs.iter().map(|input| input.name.as_str()).collect();
        for (name, _) in self.runs.iter().flat_map(|run| &run.inputs) {
            if known.contains(&name.text.as_str()) {
                continue;
            }
            // A constant recorded for effects that are not in use is no fault.
            let mut warning = Diagnostic::warning(format!(
                "the input `{}` is not used: model `{}` does not declare it",
                name.text, model.name
            ))
            .at(name.place.clone());
            if let Some(near) = crate::diagnostic::nearest(&name.text, known.iter().copied()) {
                warning = warning.help(format!("did you mean `{near}`?"));
            }
            if loader.warned.insert(name.text.clone()) {
                loader.warnings.push(warning);
            }
        }
    }

    fn load_runs(&self, model: &Model, loader: &mut Loader<'_>) -> (Vec<String>, Vec<Run>) {
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
fn setup_times(runs: &mut [Run]) {
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

/// Whether a formula of the model names an input.
fn needs(model: &Model, name: &str) -> bool {
    model.formulas().any(|formula| formula.root.names().iter().any(|(own, _)| *own == name))
}

/// A formula for the sigma of an angle needs a unit of angles.
fn check_angles(
    model: &Model,
    loader: &mut Loader<'_>,
    (name, formula): (&str, &Formula),
    unit: &Unit,
) {
    // What a quantity is, only the graph finds out.
    let may_be_angle = |name: &str| {
        let inputs = model.inputs.iter().map(|one| (&one.name, &one.unit));
        let parameters = model.parameters.iter().map(|one| (&one.name, &one.unit));
        let read = model.measurands.iter().map(|one| (&one.name, &one.unit));
        let mut known = inputs.chain(parameters).chain(read);
        let known = known.find(|(own, _)| *own == name);
        known.map_or(model.quantities.contains_key(name), |(_, unit)| unit.is_angle())
    };
    if unit.is_angle() && !brings_angle(&formula.root, &may_be_angle) {
        let span = Span::new(formula.offset, formula.offset + formula.text.len());
        let message =
            format!("the standard uncertainty of the angle `{name}` has no unit of angles");
        let help = "write the number with its unit, as in \"1 arcsec / cos(elevation)\"";
        loader.reader.fault(span, message, help);
    }
}
