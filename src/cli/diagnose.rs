//! `homepoint diagnose`: why simulation and reality differ.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;

use clap::Args;

use crate::campaign::Run;
use crate::diagnose::{Diagnosis, diagnose, judge};
use crate::diagnostic::Diagnostic;
use crate::engine::layout::Instance;
use crate::engine::open::{Opened, Recipe, held_that_act};
use crate::engine::{Part, Problem};
use crate::estimate::batch::Options;
use crate::model::Setting;
use crate::report;
use crate::report::diagnosis_text::Asked;

use super::arguments::{CampaignArguments, Format};
use super::load::{notices, refusals};
use super::shell::{in_shell, typed};
use super::wanted::WantedArguments;
use super::{Failure, doubts, load, output, prior, render};

#[derive(Debug, Args)]
pub(super) struct Diagnose {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    #[command(flatten)]
    library: WantedArguments,
    /// State how probable a cause is before the readings: nothing=0.3, library=0.5, unknown=0.2
    /// unless said otherwise, or EFFECT=3 for one three times as probable as others (repeat for
    /// more)
    #[arg(long = "prior", value_name = "CAUSE=NUMBER")]
    prior: Vec<String>,
    /// Judge the shrinkage on a campaign that the fit never saw
    #[arg(long, value_name = "CAMPAIGN")]
    holdout: Option<PathBuf>,
    /// List this many candidates
    #[arg(long, value_name = "N")]
    top: Option<usize>,
}

/// Refuses a held-out campaign to which what is found says nothing.
fn same_models(fitted: &[Recipe], held_out: &Opened) -> Result<(), Failure> {
    let names: Vec<&str> = fitted.iter().map(|recipe| recipe.model.name.as_str()).collect();
    let other = held_out.recipes.iter().find(|one| !names.contains(&one.model.name.as_str()));
    other.map_or(Ok(()), |other| {
        Err(Diagnostic::error(format!(
            "the held-out campaign has the model `{}`, but effects are looked for with `{}`",
            other.model.name,
            names.join("`, `")
        ))
        .help("give a campaign with the same model")
        .into())
    })
}

/// Refuses a held-out campaign with a run that is fitted.
fn other_readings(fitted: &Problem, held_out: &Opened) -> Result<(), Failure> {
    let all = |problem: &Problem| -> Vec<(u64, String)> {
        let runs = problem.parts.iter().flat_map(|part| &part.runs);
        runs.filter_map(|run| Some((fingerprint(run)?, run.name.clone()))).collect()
    };
    let known = all(fitted);
    let same = |one: &(u64, String)| known.iter().any(|(other, _)| *other == one.0);
    all(&held_out.problem).into_iter().find(same).map_or(Ok(()), |(_, name)| {
        let message = format!("the run `{name}` of the held-out campaign is one that is fitted");
        Err(Diagnostic::error(message).help("hold another campaign out").into())
    })
}

/// The same for runs of the same times and readings, wherever these are kept; `None` without
/// readings.
fn fingerprint(run: &Run) -> Option<u64> {
    let (mut hasher, mut has_readings) = (DefaultHasher::new(), false);
    run.record.walk(|stretch| {
        for sample in stretch.each() {
            sample.time().to_bits().hash(&mut hasher);
            for reading in &sample.samples.readings {
                has_readings |= !reading[sample.at].is_nan();
                reading[sample.at].to_bits().hash(&mut hasher);
            }
        }
    });
    has_readings.then(|| hasher.finish())
}

/// Warns of effects of the user's own that cannot be tested: what is wrong in them is not looked
/// for in a table.
fn own_untested(recipes: &[Recipe], found: &Diagnosis) -> Vec<Diagnostic> {
    let Some(recipe) = recipes.first() else { return Vec::new() };
    let of = |name: &str| found.not_testable.iter().find(|one| one.name == name);
    let mut misfits = recipe.own_that_do_not_fit();
    misfits.retain(|(name, _)| of(name).is_some());
    let is_misfit = |name: &String| misfits.iter().any(|(own, _)| own == name);
    let others = recipe.library.own_effects().filter(|effect| !is_misfit(&effect.name));
    let others = others.filter_map(|effect| {
        let one = of(&effect.name)?;
        let message = format!("`{}`: `{}` cannot be tested here", effect.source.file, one.name);
        Some(Diagnostic::warning(message).help(one.why.clone()))
    });
    let others: Vec<Diagnostic> = others.collect();
    misfits.into_iter().map(|(_, misfit)| misfit).chain(others).collect()
}

/// The name of what a campaign's values belong to.
type Owner = fn(&Part) -> Option<&String>;

/// Warns where what is held was learnt with another instrument or rig.
fn other_owners(fitted: &Problem, held_out: &Opened) -> Vec<Diagnostic> {
    let owners: [(&str, Owner); 2] =
        [("instrument", |part| part.instrument.as_ref()), ("rig", |part| part.rig.as_ref())];
    let mut warnings = Vec::new();
    for (what, of) in owners {
        let known: Vec<&String> = fitted.parts.iter().filter_map(of).collect();
        let mut others = held_out.problem.parts.iter().filter_map(of);
        if let (Some(other), false) = (others.find(|one| !known.contains(one)), known.is_empty()) {
            let message = format!("the held-out campaign has another {what}, `{other}`");
            let held =
                format!("what belongs to the {what} is held at the values of `{}`", known[0]);
            warnings.push(Diagnostic::warning(message).help(held));
        }
    }
    warnings.extend(other_values(fitted, &held_out.problem));
    warnings
}

/// Standard uncertainties by which values that two campaigns state of the same thing may differ.
const APART: f64 = 5.0;

/// Warns of values of rig and instrument that a held-out campaign states otherwise.
fn other_values(fitted: &Problem, held_out: &Problem) -> Vec<Diagnostic> {
    let warnings = held_out.layout.instances.iter().filter_map(|other| {
        let mut own = fitted.layout.instances.iter().filter(|one| one.name == other.name);
        let message = own.find_map(|one| apart(one, other))?;
        let help = "if it is another rig or instrument, it cannot judge what was found here; else correct one of the two";
        Some(Diagnostic::warning(message).help(help))
    });
    warnings.collect()
}

/// What two campaigns state of a parameter, where that is too far apart; a value without an
/// uncertainty that is not fixed is a guess.
fn apart(one: &Instance, other: &Instance) -> Option<String> {
    let stated = |instance: &Instance, k: usize| {
        let Setting { value, sigma, fixed, .. } = &instance.setting;
        let value = *value.as_ref().filter(|_| instance.of.is_none())?.get(k)?;
        let sigma = sigma.as_ref().and_then(|sigma| sigma.get(k)).copied();
        if *fixed { Some((value, 0.0)) } else { Some((value, sigma?)) }
    };
    (0..one.dimension()).find_map(|k| {
        let ((a, of_a), (b, of_b)) = (stated(one, k)?, stated(other, k)?);
        let allowed = APART * f64::hypot(of_a, of_b) + 1e-9 * a.abs().max(b.abs());
        let shown = |value: f64, sigma: f64| report::figure::measured(value, sigma, &one.unit);
        ((a - b).abs() > allowed).then(|| {
            format!(
                "the held-out campaign states `{}` = {}, the fitted one {}",
                other.name,
                shown(b, of_b),
                shown(a, of_a)
            )
        })
    })
}

/// A variance factor, with what was found and by the noise as stated, beyond which it is asked whether a convention was
/// mistaken.
const BAD: f64 = 4.0;

/// Options that state the delays that the diagnosis held at zero and that act with what it found.
fn held(recipes: &[Recipe], found: &Diagnosis) -> Vec<String> {
    let Some(explained) = &found.explained else { return Vec::new() };
    let names = held_that_act(recipes, &explained.problem);
    names.iter().map(|name| format!("--set {name}=\"0 s\"")).collect()
}

/// The tables that `--out` asks for.
const CANDIDATES: &str = "candidates.csv";
const LEFT_OUT: &str = "left_out.csv";

impl Diagnose {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut loaded = load::load(&self.common)?;
        refusals::refuse_correlated(&loaded.problem)?;
        notices::tell_not_put_in(&loaded, true);
        refusals::refuse_empty(&loaded.problem)?;
        let mut wanted = self.library.wanted(&loaded.recipes)?;
        wanted.prior = prior::read(&self.prior, &loaded.recipes, &wanted)?;
        let held_out = self.holdout.as_ref().map(|path| self.opened(path)).transpose()?;
        if let Some(other) = &held_out {
            other.campaigns.iter().for_each(|campaign| loaded.files.extend(&campaign.files));
            same_models(&loaded.recipes, other)?;
            other_readings(&loaded.problem, other)?;
            if !self.common.quiet {
                render::all(&other_owners(&loaded.problem, other));
            }
        }
        loaded.keep_files(self.common.out.as_ref(), [CANDIDATES, LEFT_OUT])?;
        let suspicion = loaded.suspicion();
        let as_loaded = loaded.problem.clone();
        let recipes = loaded.recipes.clone();
        let mut found = diagnose(loaded.problem, recipes, &wanted, &Options::default())
            .map_err(|error| Failure::Could(error.to_string()))?;
        if let Some(held_out) = &held_out {
            judge(&mut found, held_out, &Options::default())
                .map_err(|error| Failure::Could(error.to_string()))?;
        }
        let is_bad = found.verdict.has_remainder() || !found.verdict.is_made();
        // What spoils a run, or a stated value, may be how numbers are read.
        let is_spoilt = !found.left_out.runs.is_empty() || found.set_free.is_some();
        let is_suspicious = (is_bad && found.variance_factor_without_changes() > BAD) || is_spoilt;
        let mistaken = || suspicion.mistaken(&as_loaded, &found.nominal.fit.point);
        let mistaken = is_suspicious.then(mistaken).flatten();
        let found = found.with_mistaken(mistaken);
        let runs = load::runs(&loaded.campaigns);
        if !self.common.quiet {
            render::all(&own_untested(&loaded.recipes, &found));
            doubts::tell_of_logs(&found.nominal);
        }
        if let Some(folder) = &self.common.out {
            let table = report::diagnosis::table(&found);
            output::file(&folder.join(CANDIDATES), &table, &loaded.files)?;
            let table = report::left_out::table(&found);
            output::file(&folder.join(LEFT_OUT), &table, &loaded.files)?;
        }
        match self.common.format {
            Format::Json => {
                let mut value = loaded.head.clone();
                load::merge(&mut value, report::diagnosis::json(&found, self.top));
                load::merge(
                    &mut value,
                    report::conventions::json_for(found.mistaken.as_ref(), runs),
                );
                load::merge(&mut value, report::smoothing::json(&found.nominal));
                output::json(&value)?;
            }
            Format::Text => {
                let path = |path: &PathBuf| typed(&path.display().to_string());
                let campaigns: Vec<String> = self.common.campaigns.iter().map(path).collect();
                let out = self.common.out.as_ref().map(path);
                let asked = Asked {
                    campaigns: &campaigns.join(" "),
                    options: &self.given(),
                    beside: &self.beside(),
                    held: &held(&loaded.recipes, &found),
                    out: out.as_deref(),
                    top: self.top,
                    runs,
                };
                output::text(&report::diagnosis_text::text(&loaded.title, &found, &asked))?;
                let smoothing = report::smoothing::text(&found.nominal);
                if !smoothing.is_empty() {
                    output::text(&(smoothing + report::smoothing::WHERE))?;
                }
                if held_out.is_some() && found.rows.is_empty() && !found.is_misread() {
                    output::text(
                        "\nNo effect stands as a row: there is nothing to judge on the held-out campaign.\n",
                    )?;
                }
            }
        }
        if found.verdict.is_made() { Ok(()) } else { Err(Failure::Reported) }
    }

    /// The options of this command that an estimate of what was found needs, too.
    fn given(&self) -> Vec<String> {
        let CampaignArguments { with, effects, set, start, leave_out, .. } = &self.common;
        let path = |file: &PathBuf| file.display().to_string();
        let options = [
            ("--effects", effects.iter().map(path).collect::<Vec<_>>()),
            ("--set", set.clone()),
            ("--start", start.clone()),
            ("--leave-out", leave_out.iter().map(path).collect()),
            ("--with", with.clone()),
        ];
        let skip = self.common.skip_bad_rows.then(|| "--skip-bad-rows".to_owned());
        options.into_iter().flat_map(in_shell).chain(skip).collect()
    }

    /// The options of this command that an estimate does not have.
    fn beside(&self) -> Vec<String> {
        let held_out = self.holdout.iter().map(|path| path.display().to_string()).collect();
        let options = [("--prior", self.prior.clone()), ("--holdout", held_out)];
        self.library.given().into_iter().chain(options).flat_map(in_shell).collect()
    }

    /// Another campaign, read as the first ones were.
    fn opened(&self, path: &PathBuf) -> Result<Opened, Failure> {
        let opened = load::read(&self.common, std::slice::from_ref(path))?;
        refusals::refuse_correlated(&opened.problem)?;
        refusals::refuse_empty(&opened.problem)?;
        Ok(opened)
    }
}
