//! `homepoint simulate`: a campaign's readings drawn from its model.

use clap::Args;
use serde_json::{Map, Value, json};

use super::arguments::{CampaignArguments, Format};
use super::calibrate::{estimate_measured, unsound};
use super::load::{notices, refusals};
use super::{Failure, load, output, render};
use crate::campaign::write::{check_targets, write_campaign_with};
use crate::campaign::write_run::RunTable;
use crate::diagnostic::Diagnostic;
use crate::engine::point::from_components;
use crate::engine::simulate::draw_run;
use crate::engine::{Point, Problem};
use crate::system::Declared;

#[derive(Debug, Args)]
pub(super) struct Simulate {
    #[command(flatten)]
    pub(super) common: CampaignArguments,
    /// Seed of the random numbers; the same seed gives the same readings
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Simulate {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let Some(folder) = &self.common.out else {
            return Err(Diagnostic::error("`simulate` needs a folder to write to")
                .help("say where with `--out DIR`")
                .into());
        };
        let loaded = load::load(&self.common)?;
        if loaded.labels.len() > 1 {
            return Err(Diagnostic::error("`simulate` takes one campaign at a time").into());
        }
        let canonical = |path: &std::path::Path| std::fs::canonicalize(path).ok();
        if canonical(folder).is_some_and(|out| canonical(&loaded.campaigns[0].folder) == Some(out))
        {
            return Err(Diagnostic::error("`--out` is the campaign's own folder")
                .help("name another one: its recordings would be lost")
                .into());
        }
        if folder.join("campaign.toml").exists() && !folder.join("truth.json").exists() {
            let message = format!("`{}` holds a campaign that was not simulated", folder.display());
            let help = "name another folder: its recordings would be lost";
            return Err(Diagnostic::error(message).help(help).into());
        }
        let truth_file = folder.join("truth.json");
        check_targets(folder, &loaded.campaigns[0], &loaded.problem.parts[0].runs)?;
        loaded.files.refuse_replacing(&truth_file)?;
        notices::tell_not_put_in(&loaded, false);
        let mut problem = loaded.problem;
        let point = truth(&mut problem, &loaded.stated, &loaded.about, self.common.format)?;
        if let Some((measurand, factor)) = problem.negative_noise(&point) {
            let message = format!(
                "the standard uncertainty of `{measurand}` would be {factor:.3} times what is stated"
            );
            return Err(Diagnostic::error(message)
                .help("see the effects on its noise: a level is added to 1, so -0.5 leaves half of the noise and -1 none")
                .into());
        }
        let (campaign, model) = (&loaded.campaigns[0], &loaded.models[0]);
        let draw = &mut |run: usize, table: &mut RunTable| {
            table.seed(self.seed, run);
            let planned = !problem.parts[0].has_readings(run);
            table.expect_all(planned);
            draw_run(&problem, (0, run), &point, self.seed, planned, &mut |stretch, drawn| {
                table.write(stretch, Some(drawn))
            })?;
            refusals::read_back(&problem)
        };
        let written = write_campaign_with(folder, campaign, model, &problem.parts[0].runs, draw)
            .map_err(|error| {
                Failure::Could(format!("cannot write into {}: {error}", folder.display()))
            })?;
        if !self.common.quiet {
            render::all(&written);
        }
        let truth = truth_of(&problem, &point, self.seed, &self.common);
        let text =
            serde_json::to_string_pretty(&truth).map_err(|e| Failure::Could(e.to_string()))?;
        output::file(&truth_file, &(text + "\n"), &loaded.files)?;
        match self.common.format {
            Format::Json => output::json(&json!({ "campaign": folder, "truth": truth_file })),
            Format::Text => {
                output::text(&format!("wrote {} with its truth beside it\n", folder.display()))
            }
        }
    }
}

/// Parameter values: as stated. What is not stated comes from a fit of the campaign's own readings
/// without the effects that are to be put in, or stays where iteration would start; effects act at
/// their typical size. What sums to zero over its scope alternates in sign.
fn truth(
    problem: &mut Problem,
    set: &[String],
    about: &Value,
    format: Format,
) -> Result<Point, Failure> {
    let stated = Point::stated(&problem.layout);
    let effects = effect_parameters(problem);
    let known = |index: usize| {
        let instance = &problem.layout.instances[index];
        instance.setting.value.is_some() || set.contains(&instance.name)
    };
    let open = |index: usize| {
        let setting = &problem.layout.instances[index].setting;
        !known(index) && !setting.fixed && setting.start.is_none() && effects[index].is_none()
    };
    let mut point = stated.clone();
    if problem.reading_count() > 0 && (0..stated.values.len()).any(open) {
        let measured = estimate_measured(&without_effects(problem))?;
        if !measured.fit.is_sound() {
            unsound(&measured.fit, about, format)?;
        }
        if !measured.unplaced.is_empty() {
            let message = format!("no file states where {} stand", measured.unplaced.join(", "));
            let help = "a setup that is only planned stands where [setups.NAME] states it, as in position = { value = [\"2 m\", \"0 m\", \"0.5 m\"] }";
            return Err(Diagnostic::error(message).help(help).into());
        }
        point = measured.point;
    }
    for (index, effect) in effects.iter().enumerate() {
        if known(index) {
            point.values[index] = stated.values[index];
        } else if let Some(typical) = *effect {
            let kind = problem.layout.instances[index].kind;
            point.values[index] = from_components(kind, &[typical; 3]);
        }
    }
    alternate(problem, &mut point);
    for part in &mut problem.parts {
        for (k, random) in part.system.randoms.iter().enumerate() {
            part.random_sigma[k] = random.sigma.or(random.typical).unwrap_or(0.0);
        }
    }
    Ok(point)
}

/// Gives what sums to zero over its scope, but has one size for all, alternating signs, and takes
/// the mean off.
fn alternate(problem: &Problem, point: &mut Point) {
    for members in problem.layout.sums_to_zero() {
        for component in 0..problem.layout.instances[members[0]].dimension() {
            let size = point.values[members[0]][component];
            if members.iter().any(|index| point.values[*index][component] != size) {
                continue;
            }
            let sign = |number: usize| if number.is_multiple_of(2) { 1.0 } else { -1.0 };
            let mean = (0..members.len()).map(sign).sum::<f64>() / members.len() as f64;
            for (number, index) in members.iter().enumerate() {
                point.values[*index][component] = size * (sign(number) - mean);
            }
        }
    }
}

/// For each instance, the typical size of an effect's parameter; `None` for the model's own.
fn effect_parameters(problem: &Problem) -> Vec<Option<f64>> {
    let part = &problem.parts[0];
    let mut typical = vec![None; problem.layout.instances.len()];
    for run in &problem.layout.used[0] {
        for (parameter, instance) in run.iter().enumerate() {
            if part.system.declared[parameter].effect.is_some() {
                typical[*instance] = Some(part.system.settings[parameter].typical.unwrap_or(0.0));
            }
        }
    }
    typical
}

/// The same problem with every effect switched off: what its file leaves free is held at zero,
/// constants stay what they are.
fn without_effects(problem: &Problem) -> Problem {
    let mut parts = problem.parts.clone();
    for part in &mut parts {
        let effects = &part.system.effects;
        let is_free = |declared: &Declared| {
            declared.effect.is_some_and(|number| {
                let mut own = effects[number].effect.parameters.iter();
                own.any(|parameter| parameter.name == declared.local && !parameter.setting.fixed)
            })
        };
        let free: Vec<bool> = part.system.declared.iter().map(is_free).collect();
        for (parameter, _) in free.into_iter().enumerate().filter(|(_, free)| *free) {
            for setting in part.system.settings_mut(parameter) {
                setting.fixed = true;
                setting.value = None;
            }
        }
        for (sigma, random) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
            if random.effect.is_some() {
                *sigma = 0.0;
            }
        }
    }
    let mut alone = Problem::new(parts);
    alone.progress = problem.progress.clone();
    alone
}

/// What was put in, for a reader who wants to compare; no estimator reads it.
fn truth_of(problem: &Problem, point: &Point, seed: u64, common: &CampaignArguments) -> Value {
    let mut parameters = Vec::new();
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        parameters.push(json!({
            "name": instance.name,
            "of": instance.of,
            "value": point.components(&problem.layout, index),
        }));
    }
    let randoms: Map<String, Value> = problem.parts[0]
        .system
        .randoms
        .iter()
        .zip(&problem.parts[0].random_sigma)
        .map(|(random, sigma)| (random.name.clone(), json!(sigma)))
        .collect();
    let placed = problem.parts[0].system.effects.iter().filter(|one| !one.member.is_empty());
    let members: Map<String, Value> =
        placed.map(|one| (one.effect.name.clone(), json!(one.member))).collect();
    json!({
        "seed": seed,
        "effects": common.with,
        "members": members,
        "parameters": parameters,
        "random": randoms,
    })
}
