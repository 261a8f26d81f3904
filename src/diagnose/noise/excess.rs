//! Scatter beyond what is stated, told as it is and named by the effects of the library that stand
//! for it.

use crate::diagnose::evidence::thresholds::level;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{Level, Noise, NoiseEffect};
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::stage::Stage;
use crate::effect::Target;
use crate::engine::layout::qualified;
use crate::graph::MeasurandKind;
use crate::statistics::{ln_chi_squared, ln_normal};

/// Tells levels that are not as stated, and names the effects of the library that stand for scatter
/// beyond it. What has a memory is no matter of levels: `white` is the part of the variance
/// without.
pub(super) fn name_levels(
    stage: &Stage,
    stated: &[Vec<f64>],
    white: &[(usize, usize, f64)],
    noise: &mut Noise,
) {
    let parts = &stage.fitted.problem.parts;
    for part in parts {
        for (run, levels) in part.runs.iter().zip(&part.run_levels) {
            for (one, factor) in part.system.assembly.names.measurands.iter().zip(levels) {
                if *factor != 1.0 {
                    let run = qualified(part.label.as_deref(), &run.name);
                    noise.run_levels.push((one.name.clone(), run, *factor));
                }
            }
        }
    }
    for (part, stated) in parts.iter().zip(stated) {
        let names = &part.system.assembly.names.measurands;
        for ((measurand, sigma), stated) in names.iter().zip(&part.sigma).zip(stated) {
            if sigma != stated {
                let (measurand, of) = (measurand.name.clone(), part.label.clone());
                noise.levels.push(Level { measurand, of, factor: sigma / stated });
            }
        }
    }
    for candidate in &stage.noise {
        let tests = 2 * stage.noise.len() + 1;
        let each: Vec<(Option<String>, Size)> = (0..parts.len())
            .filter_map(|p| {
                let of_each = beyond(stage, candidate, p, stated, white);
                // Readings that scatter otherwise than each other have no level in common.
                let together = Size::of_all(&of_each).filter(|all| !all.differ(&of_each, tests));
                Some((parts[p].label.clone(), together?))
            })
            .collect();
        let sizes: Vec<Size> = each.iter().map(|(_, size)| size.clone()).collect();
        let together = Size::of_all(&sizes);
        let differ = together.as_ref().is_some_and(|all| all.differ(&sizes, tests));
        let told =
            if differ { each } else { together.map(|size| (None, size)).into_iter().collect() };
        for (of, Size { value, sigma, .. }) in told {
            let ln_p = ln_normal(value / sigma);
            if value > 0.0 && ln_p <= level(tests) {
                noise.effects.extend(named(candidate, of, (value, sigma), ln_p));
            }
        }
    }
}

/// By how much readings scatter beyond what is stated.
#[derive(Clone)]
struct Size {
    value: f64,
    sigma: f64,
    /// Sum of the squared factors on what is stated, and their number.
    squares: f64,
    count: f64,
    /// Twice the readings that say so.
    freedom: f64,
}

impl Size {
    fn of(squares: f64, count: f64, freedom: f64) -> Self {
        let value = (squares / count).sqrt() - 1.0;
        Self { value, sigma: (1.0 + value) / freedom.max(1.0).sqrt(), squares, count, freedom }
    }

    /// That of several together; `None` of none.
    fn of_all(all: &[Self]) -> Option<Self> {
        let (squares, count, freedom) = all.iter().fold((0.0, 0.0, 0.0), |(s, c, f), one| {
            (s + one.squares, c + one.count, f + one.freedom)
        });
        (count > 0.0).then(|| Self::of(squares, count, freedom))
    }

    /// Whether several are not all of this size, but for chance.
    fn differ(&self, each: &[Self], tests: usize) -> bool {
        let squares = each.iter().map(|one| ((one.value - self.value) / one.sigma).powi(2));
        each.len() > 1 && ln_chi_squared(squares.sum(), each.len() - 1) <= level(tests)
    }
}

/// By how much each of the measurands of a campaign that an effect patches scatters beyond what is
/// stated; none where it patches none.
fn beyond(
    stage: &Stage,
    candidate: &Candidate,
    p: usize,
    stated: &[Vec<f64>],
    white: &[(usize, usize, f64)],
) -> Vec<Size> {
    let part = &stage.fitted.problem.parts[p];
    let present = part.present();
    let levels = part.sigma.iter().zip(&stated[p]).enumerate();
    levels
        .filter(|(measurand, _)| patches_level(candidate, stage, (p, *measurand)))
        .map(|(measurand, (sigma, stated))| {
            let own = white.iter().filter(|(q, m, _)| (*q, *m) == (p, measurand));
            let white = own.map(|(.., part)| *part).fold(1.0, f64::min);
            // How much of the variance has a memory is known less well than the variance.
            let worth = if white < 1.0 { 9.0 } else { 1.0 };
            let freedom = 2.0 * present[measurand] as f64 / worth;
            Size::of(white * (sigma / stated).powi(2), 1.0, freedom)
        })
        .collect()
}

/// An effect on the level of noise; `None` where it has no parameter.
fn named(
    candidate: &Candidate,
    of: Option<String>,
    (value, sigma): (f64, f64),
    ln_p: f64,
) -> Option<NoiseEffect> {
    let parameter = candidate.selected.effect.parameters.first()?;
    Some(NoiseEffect {
        name: candidate.name.clone(),
        selected: None,
        parameter: format!("{}.{}", candidate.name, parameter.name),
        of,
        unit: parameter.unit.clone(),
        value,
        sigma,
        also: Vec::new(),
        aliases: Vec::new(),
        memory: None,
        ln_p,
    })
}

/// Whether an effect patches the noise level of a measurand of a campaign.
pub(in crate::diagnose) fn patches_level(
    candidate: &Candidate,
    stage: &Stage,
    (campaign, measurand): (usize, usize),
) -> bool {
    let Fitted { problem, recipes, .. } = &stage.fitted;
    let one = &problem.parts[campaign].system.assembly.names.measurands[measurand];
    let model = &recipes[campaign].model;
    let head = candidate.selected.head.as_ref().and_then(|head| model.heads.get(head));
    let role = |name: &String| head.and_then(|own| own.get(name)).or_else(|| model.roles.get(name));
    let is_called = |name: &String| role(name).map_or(name, |role| &role.owner) == &one.name;
    let is_read = || head.is_none_or(|own| own.values().any(|role| role.owner == one.name));
    candidate.selected.effect.patches.iter().any(|line| match &line.target {
        Target::Sigma(name) => is_called(name),
        Target::EachAngleSigma => matches!(one.kind, MeasurandKind::Angle { .. }) && is_read(),
        _ => false,
    })
}
