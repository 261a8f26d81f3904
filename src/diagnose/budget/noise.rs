//! The noise as it is found in the residuals of a model: outliers, timestamp jitter,
//! autocorrelation. Structure comes first: what no term explains is judged here.
//!
//! Noise scale factors are part of every model ([`super::selection`]).

use std::collections::BTreeMap;

use crate::diagnose::found::{LeftOut, Reading};
use crate::engine::Problem;
use crate::engine::gauss_markov::GaussMarkov;
use crate::statistics::robust;

use super::autocorrelation::{Component, again, autocorrelation};
use super::linear::Linear;
use super::rows::Values;
use super::selection::Selection;
use crate::diagnose::thresholds::{FAR_BEYOND_STATED, LONE_OUTLIER, NOISE, OUTLIERS};

/// The place of a reading: its run (of all), sample, and measurand (of all campaigns).
pub type ReadingAt = (usize, usize, usize);

/// A reading that is far out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlier {
    /// Where.
    pub at: ReadingAt,
    /// How many robust standard deviations.
    pub deviations: f64,
}

/// Timestamp jitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jitter {
    /// Variance of the reference times (s²).
    pub variance: f64,
    /// Its standard uncertainty.
    pub sigma: f64,
    /// Standard score against none.
    pub score: f64,
}

/// Samples with the largest products, without which jitter is found, too: a share of all, and at least so
/// many.
const FAR_OUT: (f64, usize) = (0.01, 2);

/// The noise of a model's residuals.
#[derive(Clone, Debug, Default)]
pub struct NoiseFound {
    /// Readings that are far out, in order.
    pub outliers: Vec<Outlier>,
    /// Timestamp jitter.
    pub jitter: Option<Jitter>,
    /// Autocorrelated noise, by campaign and residual component.
    pub autocorrelation: Vec<(usize, usize, GaussMarkov)>,
}

/// Components by campaign, measurand (of all campaigns) and residual component.
pub type Components = BTreeMap<(usize, usize, usize), Component>;

/// The residuals of a model; `see` is shown each of them with its row.
pub fn components(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
    see: &mut dyn FnMut(&Values<'_>, f64),
) -> Components {
    let values = selection.values(model);
    let mut components = Components::new();
    linear.visit(selection, model, &[], &mut |row: Values<'_>| {
        let explained: f64 = row.model.iter().zip(values.iter()).map(|(x, b)| x * b).sum();
        let part = linear.fitted.problem.run_at(row.run).0;
        let component = components.entry((part, row.measurand, row.row)).or_default();
        let own = component.entry(row.run).or_default();
        let residual = row.residual - explained;
        own.push((row.sample, row.time, residual));
        see(&row, residual);
    });
    components
}

/// Looks at the residuals of a model; `known` outliers say nothing of the rest, and autocorrelated noise
/// may be estimated anew where it `may_change`.
pub fn noise(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
    known: &[Outlier],
    may_change: bool,
) -> NoiseFound {
    let delays = delay_columns(linear, selection);
    // Of each reading what it says of its time: residual times rate, and rate, both weighted.
    let mut timed: Vec<((usize, usize), usize, [f64; 2])> = Vec::new();
    let mut components = components(linear, selection, model, &mut |row, residual| {
        let scale = selection.scale[row.measurand];
        let rate: f64 = delays.iter().map(|column| row.model[*column]).sum();
        if rate != 0.0 {
            let of_time = [residual * rate / scale.powi(2), (rate / scale).powi(2)];
            timed.push(((row.run, row.sample), row.measurand, of_time));
        }
    });
    let mut found = NoiseFound { outliers: outliers(&components), ..NoiseFound::default() };
    let is_among = |outliers: &[Outlier], at: ReadingAt| {
        outliers.binary_search_by_key(&at, |one| one.at).is_ok()
    };
    for ((_, measurand, _), runs) in &mut components {
        for (run, values) in runs {
            values.retain(|(sample, ..)| !is_among(&found.outliers, (*run, *sample, *measurand)));
        }
    }
    // By sample: sums of u, u², v, v² over its readings. Jitter makes outliers where things are fast.
    let mut samples: BTreeMap<(usize, usize), [f64; 4]> = BTreeMap::new();
    for (at, _, [u, v]) in timed.iter().filter(|one| !is_among(known, (one.0.0, one.0.1, one.1))) {
        let sums = samples.entry(*at).or_default();
        sums.iter_mut().zip([*u, u * u, *v, v * v]).for_each(|(sum, more)| *sum += more);
    }
    found.jitter = jitter(samples.values());
    let problem = &linear.fitted.problem;
    for ((part, measurand, row), runs) in &components {
        let may_change = may_change && selection.scale[*measurand] <= FAR_BEYOND_STATED;
        let correlated = match problem.parts[*part].gauss_markov[*row] {
            Some(known) if may_change => again(runs, known),
            Some(_) => None,
            None => autocorrelation(runs),
        };
        found.autocorrelation.extend(correlated.map(|one| (*part, *row, one)));
    }
    found
}

/// Places, among a model's columns, of the delays.
fn delay_columns(linear: &Linear, selection: &Selection<'_>) -> Vec<usize> {
    let layout = &linear.fitted.problem.layout;
    let delays: Vec<usize> = (0..layout.instances.len())
        .filter(|index| layout.instances[*index].is_delay())
        .flat_map(|index| layout.own_columns(index).map(|(_, column)| column).collect::<Vec<_>>())
        .collect();
    let nominal = selection.columns(&[]);
    let is_delay = |place: &usize| delays.contains(&nominal[*place][0].0);
    (0..nominal.len()).filter(is_delay).collect()
}

/// Readings beyond [`NOISE`] robust standard deviations of their component, in order.
fn outliers(components: &Components) -> Vec<Outlier> {
    let mut found = Vec::new();
    for ((_, measurand, _), runs) in components {
        let deviation = robust(runs.values().flatten().map(|one| &one.2)).unwrap_or(0.0);
        for (run, values) in runs {
            let is_far = |value: f64| value.abs() > NOISE * deviation && deviation > 0.0;
            let far = values.iter().filter(|one| is_far(one.2)).map(|(sample, _, value)| {
                let deviations = value.abs() / deviation;
                Outlier { at: (*run, *sample, *measurand), deviations }
            });
            let far: Vec<Outlier> = far.collect();
            // A run of which most readings are far out differs as a whole: that is structure.
            if far.len() < OUTLIERS || 2 * far.len() <= values.len() {
                found.extend(far);
            }
        }
    }
    each_once(&mut found);
    few_are_far(&mut found);
    found
}

/// Puts outliers in order; a reading of several components is left out once.
fn each_once(outliers: &mut Vec<Outlier>) {
    outliers.sort_by(|a, b| a.at.cmp(&b.at).then(b.deviations.total_cmp(&a.deviations)));
    outliers.dedup_by_key(|one| one.at);
}

/// Readings far from zero and from those beside them in time: one by one they are wrong whatever the noise
/// has in common from one reading to the next.
pub(super) fn isolated_outliers(components: &Components) -> Vec<Outlier> {
    let mut found = Vec::new();
    for ((_, measurand, _), runs) in components {
        let scatter = |values: Vec<f64>| robust(&values).filter(|scatter| *scatter > 0.0);
        let values = || runs.values().flatten().map(|one| one.2);
        let steps = runs.values().flat_map(|own| own.windows(2).map(|two| two[1].2 - two[0].2));
        let bends = runs.values().flat_map(|own| {
            own.windows(3).map(|three| three[1].2 - 0.5 * (three[0].2 + three[2].2))
        });
        let (Some(whole), Some(of_steps), Some(of_bends)) =
            (scatter(values().collect()), scatter(steps.collect()), scatter(bends.collect()))
        else {
            continue;
        };
        for (run, own) in runs {
            let value = |at: usize| own.get(at).map(|one| one.2);
            for (at, (sample, _, residual)) in own.iter().enumerate() {
                let before = at.checked_sub(1).and_then(value);
                let apart = match (before, value(at + 1)) {
                    (Some(before), Some(next)) => (residual - 0.5 * (before + next)) / of_bends,
                    (Some(one), None) | (None, Some(one)) => (residual - one) / of_steps,
                    (None, None) => continue,
                };
                let deviations = (residual / whole).abs().min(apart.abs());
                if deviations > LONE_OUTLIER {
                    found.push(Outlier { at: (*run, *sample, *measurand), deviations });
                }
            }
        }
    }
    each_once(&mut found);
    found
}

/// Keeps of few outliers those that are none of a normal distribution by themselves.
pub fn few_are_far(outliers: &mut Vec<Outlier>) {
    if outliers.len() < OUTLIERS {
        outliers.retain(|one| one.deviations > LONE_OUTLIER);
    }
}

/// The variance of reference times from products of residuals of different readings of one sample,
/// which noise scale factors cannot make. Its uncertainty is that of the products as they scatter. Where a
/// few samples make nearly all of it, they are outliers.
fn jitter<'a>(samples: impl Iterator<Item = &'a [f64; 4]>) -> Option<Jitter> {
    let each = samples.map(|[u, uu, v, vv]| [0.5 * (u * u - uu), 0.5 * (v * v - vv)]);
    let mut each: Vec<[f64; 2]> = each.collect();
    each.sort_by(|a, b| b[0].total_cmp(&a[0]));
    let sums = |of: &[[f64; 2]]| of.iter().fold((0.0, 0.0), |a, one| (a.0 + one[0], a.1 + one[1]));
    let score = |of: &[[f64; 2]]| {
        let (products, weights) = sums(of);
        if weights > 0.0 { products / weights.sqrt() } else { 0.0 }
    };
    let far = ((FAR_OUT.0 * each.len() as f64) as usize).max(FAR_OUT.1).min(each.len());
    if score(&each) <= NOISE || score(&each[far..]) <= NOISE {
        return None;
    }
    let (products, weights) = sums(&each);
    let variance = products / weights;
    let scatter: f64 = each.iter().map(|[one, weight]| (one - variance * weight).powi(2)).sum();
    Some(Jitter { variance, sigma: scatter.sqrt() / weights, score: score(&each) })
}

/// Leaves readings out of a problem; what was left out, by row of the data file.
pub fn leave_out(problem: &mut Problem, linear: &Linear, outliers: &[Outlier]) -> LeftOut {
    let mut left_out = LeftOut::default();
    for Outlier { at: (run, sample, measurand), deviations } in outliers {
        let (number, run) = linear.fitted.problem.run_at(*run);
        let measurand = measurand - linear.sums.first_measurand[number];
        let part = &mut problem.parts[number];
        let columns = part.slots()[measurand].columns();
        let name = part.run_name(run);
        let record = &mut part.runs[run].record;
        left_out.readings.push(Reading {
            run: name.as_str().into(),
            row: record.row(*sample),
            measurand: part.system.assembly.names.measurands[measurand].name.as_str().into(),
            deviations: *deviations,
            instead: None,
        });
        record.leave_out([(*sample..sample + 1, columns)]);
    }
    left_out
}
