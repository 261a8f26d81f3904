//! The answer, put together from what the driver found. It looks for nothing.

use std::collections::BTreeMap;

use crate::diagnose::fitted::{Fitted, name_of};
use crate::diagnose::gap::gap;
use crate::diagnose::gap::steps::Steps;
use crate::diagnose::library::place::{Of, Place};
use crate::diagnose::library::prior::{Cause, Prior};
use crate::engine::Problem;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, Estimate, finish};
use crate::estimate::contradicted::contradicted;
use crate::system::Selected;
use crate::units::Unit;

use super::absorbed::absorbed;
use super::answer::{
    Diagnosis, Doubtful, FAR_BEYOND_STATED, Findings, Ranked, Remainder, Row, Size, decide,
};
use super::driver::Found;
use super::held_out::Folded;
use super::judge::Objection;
use super::linear::{Linear, Start, columns_of};
use super::member::member_uncertainties;
use super::noise_scale::{autocorrelation, levels, scale_noise, scatter, white_scale};
use super::pieces::Pieces;
use super::price::Gain;
use super::search::Pools;
use super::selection::Selection;
use super::thresholds::{CONFOUNDED, ENTER, TIE};

/// Effects that are compared with a row.
const RIVALS: usize = 8;

impl Diagnosis {
    /// Puts the answer together beside the nominal calibration.
    ///
    /// # Errors
    /// [`FitError`] where a model cannot be fitted at all.
    pub fn of(mut self, found: Found, prior: &Prior, options: &Options) -> Result<Self, FitError> {
        let Found { linear, rows, judged, scale, left_out, noise, objections, log } = found;
        let mut selection = Selection::new(&linear.sums, &linear.terms, &linear.active);
        selection.adopt_scale(&scale);
        let budget = Budget { linear: &linear, selection: &selection, model: &judged.model };
        self.left_out.extend(left_out);
        self.noise = noise;
        self.levels = levels(&linear, &scale);
        self.autocorrelation = autocorrelation(&linear.fitted.problem);
        self.log = log;
        let in_fit = linear.rows();
        let stands: Vec<usize> = (0..judged.model.len())
            .filter(|at| {
                in_fit.contains(&judged.model[*at]) && !judged.nameless.contains(&judged.model[*at])
            })
            .collect();
        let rest: Vec<usize> = (0..judged.model.len()).filter(|at| !stands.contains(at)).collect();
        let folded = Folded::new(
            &selection,
            &judged.model,
            &Pieces::new(&linear, &selection, &judged.model),
        );
        let gains = selection.contributions(&judged.model);
        let shares = budget.shares(&folded);
        if !stands.is_empty() {
            let mut with_rows = linear.fitted.clone();
            scale_noise(&mut with_rows.problem, &linear, &scale);
            let with_rows = with_rows.again(options)?;
            let selected: Vec<Selected> = rows
                .iter()
                .filter_map(|row| {
                    let all = with_rows.recipes.iter().flat_map(|recipe| &recipe.effects);
                    all.into_iter().find(|one| name_of(one) == row.name).cloned()
                })
                .collect();
            let steps = Steps::of(&with_rows, &selected, options)?;
            let degrees = stands.iter().map(|at| gains[*at].degrees).sum();
            let leftover = rest.iter().map(|at| excess(gains[*at])).sum();
            self.gap = Some(gap(&steps, degrees, leftover, 0.0, true));
            let members = member_uncertainties(&with_rows, &selected, options)?;
            let Fitted { problem, fit, .. } = with_rows.clone();
            let explained = finish(problem, fit, Vec::new(), Vec::new())?;
            for at in &stands {
                let own = budget.row(*at, &explained, &gains, &folded, &shares);
                self.rows.push(own);
            }
            for row in &mut self.rows {
                let own = members.iter().filter(|one| one.effect == row.name);
                for one in own {
                    row.member_sigma.insert(one.family.clone(), one.sigma);
                    for (instance, share) in &one.shares {
                        let own = row.values.iter_mut().filter(|v| v.instance == Some(*instance));
                        own.for_each(|v| v.sigma = v.sigma.map(|sigma| sigma.hypot(*share)));
                    }
                }
            }
            self.rows.sort_by(|a, b| b.gain.gain.total_cmp(&a.gain.gain));
            self.contradicted = contradicted(&explained);
            // A row may absorb what a wrong stated value does.
            if self.contradicted.is_empty() {
                self.contradicted = contradicted(&self.nominal);
            }
            self.steps = Some(steps);
            self.explained = Some(explained);
        } else {
            self.contradicted = contradicted(&self.nominal);
        }
        self.remainder = budget.remainder(&rest, &gains);
        self.doubtful = budget.doubtful(&objections);
        (self.candidates, self.causes) = budget.candidates(prior);
        let (found, not_testable) = absorbed(&linear, &selection);
        (self.absorbed, self.not_testable) = (found, not_testable);
        let white = white_scale(&linear, &scale);
        let largest_scale = white.iter().copied().fold(0.0, f64::max);
        if largest_scale > FAR_BEYOND_STATED {
            self.remainder.extend(scatter(&linear, &white));
        }
        self.verdict = decide(Findings {
            rows: self.rows.len(),
            remainder: self.remainder.len(),
            noise: self.noise.len()
                + self.autocorrelation.len()
                + usize::from(!self.left_out.is_empty() || !self.lost.is_empty()),
            largest_scale,
        });
        Ok(self)
    }
}

/// A model on its sums.
struct Budget<'a> {
    linear: &'a Linear,
    selection: &'a Selection<'a>,
    model: &'a [usize],
}

fn excess(gain: Gain) -> f64 {
    (gain.gain - gain.degrees as f64).max(0.0)
}

impl Budget<'_> {
    /// For each term the part of the gap that it closes on held-out readings.
    fn shares(&self, folded: &Folded) -> Vec<f64> {
        let drops: Vec<f64> = (0..self.model.len()).map(|at| folded.drop(at).max(0.0)).collect();
        let all = folded.drop_of_all().max(f64::MIN_POSITIVE);
        drops.iter().map(|drop| (drop / all).min(1.0)).collect()
    }

    fn without(&self, term: usize) -> Vec<usize> {
        self.model.iter().copied().filter(|own| *own != term).collect()
    }

    fn row(
        &self,
        at: usize,
        explained: &Calibration,
        gains: &[Gain],
        folded: &Folded,
        shares: &[f64],
    ) -> Row {
        let Self { linear, selection, .. } = self;
        let term = self.model[at];
        let own = &linear.terms[term];
        let rest = self.without(term);
        let ln_bayes = selection.ln_bayes_factor(term, gains[at]);
        let pools = Pools::of(selection);
        let rivals = selection.ranked(&rest, &pools.effects, 0.0);
        let rivals: Vec<_> =
            rivals.into_iter().filter(|one| one.term != term).take(RIVALS).collect();
        let aliases: Vec<String> = rivals
            .iter()
            .filter(|one| one.ln_bayes >= ENTER && one.ln_bayes > ln_bayes - TIE)
            .map(|one| linear.terms[one.term].name.clone())
            .filter(|name| *name != own.name)
            .collect();
        let blocks = selection.ranked(&rest, &pools.blocks, 0.0);
        let others = rivals.iter().chain(blocks.first()).map(|one| one.ln_bayes - ln_bayes);
        let odds: f64 = others.chain([-ln_bayes]).map(f64::exp).sum();
        let effects = linear.fitted.recipes.iter().flat_map(|recipe| &recipe.effects);
        let selected = effects.into_iter().find(|one| name_of(one) == own.name);
        let values = self.values(&own.name, at, explained);
        let alone = selection.gain(&[], term);
        let total = selection.chi_squared(&[]) - selection.chi_squared(self.model);
        Row {
            name: own.name.clone(),
            member: selected.map(|one| one.member.clone()).unwrap_or_default(),
            member_sigma: BTreeMap::new(),
            ratio_to_typical: ratio_to_typical(&linear.fitted.problem, &values),
            values,
            gain: gains[at],
            ln_bayes,
            closes: shares[at],
            alone: (excess(alone) / total.max(f64::MIN_POSITIVE)).min(1.0),
            posterior: 1.0 / (1.0 + odds),
            held_out: folded.drop(at),
            aliases,
            unmodelled_alias: blocks
                .first()
                .filter(|one| one.ln_bayes > ln_bayes - TIE)
                .and_then(|one| Some(linear.terms[one.term].place.as_ref()?.words.clone())),
            confounded: self.confounded(at),
        }
    }

    /// Where the columns of a term begin among those of the model.
    fn first(&self, at: usize) -> usize {
        let terms = &self.linear.terms;
        let before: usize = self.model[..at].iter().map(|term| terms[*term].columns.len()).sum();
        self.selection.nominal() + before
    }

    /// The values of a row beside the whole budget.
    fn values(&self, name: &str, at: usize, explained: &Calibration) -> Vec<Estimate> {
        let (values, covariance) = self.selection.solved(self.model);
        let first = self.first(at);
        let own: Vec<usize> =
            columns_of(&self.linear.fitted, name).into_iter().map(|(column, _)| column).collect();
        let layout = &self.linear.fitted.problem.layout;
        let prefix = format!("{name}.");
        let mut component: BTreeMap<usize, usize> = BTreeMap::new();
        let all = explained.estimates().into_iter().filter(|one| one.name.starts_with(&prefix));
        all.map(|mut one| {
            let Some(instance) = one.instance else { return one };
            let k = component.entry(instance).or_default();
            let columns = layout.columns_of(instance, *k);
            *k += 1;
            let place = |column: usize| own.iter().position(|own| *own == column);
            let placed: Vec<(usize, f64)> = columns
                .iter()
                .filter_map(|(column, by)| Some((first + place(*column)?, *by)))
                .collect();
            if placed.is_empty() || one.value.is_none() || one.sigma.is_none() {
                return one;
            }
            let value: f64 = placed.iter().map(|(column, by)| by * values[*column]).sum();
            let mut variance = 0.0;
            for (i, p) in &placed {
                variance += placed.iter().map(|(j, q)| p * q * covariance[(*i, *j)]).sum::<f64>();
            }
            one.value = Some(value);
            one.sigma = Some(variance.max(0.0).sqrt());
            one
        })
        .collect()
    }

    /// Rows whose values are correlated with those of a row.
    fn confounded(&self, at: usize) -> Vec<(String, f64)> {
        let (_, covariance) = self.selection.solved(self.model);
        let range = |at: usize| {
            let first = self.first(at);
            first..first + self.linear.terms[self.model[at]].columns.len()
        };
        let mut found = Vec::new();
        for other in (0..self.model.len()).filter(|other| *other != at) {
            let own = &self.linear.terms[self.model[other]];
            if !own.is_effect() {
                continue;
            }
            let mut most = 0.0_f64;
            for i in range(at) {
                for j in range(other) {
                    let root = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                    let correlation = covariance[(i, j)] / root;
                    if correlation.abs() > most.abs() {
                        most = correlation;
                    }
                }
            }
            if most.abs() >= CONFOUNDED {
                found.push((own.name.clone(), most));
            }
        }
        found
    }

    /// Effects that did not stand as rows, the last reason of each.
    fn doubtful(&self, objections: &[(String, Objection)]) -> Vec<Doubtful> {
        let Self { linear, selection, .. } = self;
        let mut found: Vec<Doubtful> = Vec::new();
        for (name, objection) in objections.iter().rev() {
            let term = (0..linear.terms.len()).find(|n| linear.terms[*n].name == *name);
            let Some(term) = term.filter(|_| !found.iter().any(|one| one.name == *name)) else {
                continue;
            };
            let blocks = self
                .model
                .iter()
                .copied()
                .filter(|own| linear.terms[*own].is_effect() && *own != term);
            let rows: Vec<usize> = blocks.collect();
            let gain = selection.gain(&rows, term);
            if gain.degrees > 0 {
                found.push(Doubtful {
                    name: name.clone(),
                    gain,
                    objection: objection.clone(),
                    values: sizes(linear, linear.start(selection, &rows, term)),
                });
            }
        }
        found
    }

    /// The parts of the remainder.
    fn remainder(&self, rest: &[usize], gains: &[Gain]) -> Vec<Remainder> {
        let Self { linear, selection, .. } = self;
        let (values, _) = selection.solved(self.model);
        let pools = Pools::of(selection);
        let total = selection.chi_squared(&[]) - selection.chi_squared(self.model);
        let total = total.max(f64::MIN_POSITIVE);
        let mut found: Vec<Remainder> = rest
            .iter()
            .map(|at| {
                let term = &linear.terms[self.model[*at]];
                let first = self.first(*at);
                let own: Vec<f64> = (0..term.columns.len()).map(|k| values[first + k]).collect();
                let place = term.place.clone().unwrap_or_else(|| Place::like(&term.name));
                let rest = self.without(self.model[*at]);
                let ranked = selection.ranked(&rest, &pools.effects, 0.0);
                let nearest = ranked.first().filter(|one| one.ln_bayes > 0.0).map(|one| {
                    let share = one.gain.gain / gains[*at].gain.max(f64::MIN_POSITIVE);
                    (linear.terms[one.term].name.clone(), share.min(1.0))
                });
                let is_wave = own.len() == 2 && term.members > 1;
                Remainder {
                    place,
                    gain: gains[*at],
                    share: (excess(gains[*at]) / total).min(1.0),
                    rms: self.rms(self.model[*at], &own),
                    amplitude: is_wave.then(|| own[0].hypot(own[1])),
                    nearest,
                }
            })
            .collect();
        found.sort_by(|a, b| b.gain.gain.total_cmp(&a.gain.gain));
        found
    }

    /// The rms of what a term does (SI): of an error of a measurand in that one, else in the one in
    /// which it is largest against the noise.
    fn rms(&self, term: usize, values: &[f64]) -> Option<(f64, String)> {
        let Self { linear, selection, .. } = self;
        let own = match &linear.terms[term].place {
            Some(Place { of: Of::Measurand(name), .. }) => Some(name),
            _ => None,
        };
        let form = selection.beyond_nominal(term, values);
        let mut best: Option<(f64, f64, String)> = None;
        for (part, data) in linear.fitted.problem.parts.iter().enumerate() {
            for measurand in 0..data.slots().len() {
                let number = linear.sums.first_measurand[part] + measurand;
                let readings = linear.sums.readings[number] as f64;
                let name = &data.system.assembly.names.measurands[measurand].name;
                if readings == 0.0 || own.is_some_and(|own| own != name) {
                    continue;
                }
                let mut square = 0.0;
                for (i, p) in &form {
                    let of = |(j, q): &(usize, f64)| q * linear.sums.product_in(number, *i, *j);
                    square += p * form.iter().map(of).sum::<f64>();
                }
                let rms = (square.max(0.0) / readings).sqrt();
                let against = rms / selection.scale[number];
                if best.as_ref().is_none_or(|(known, ..)| against > *known) {
                    best = Some((against, rms * data.sigma[measurand], name.clone()));
                }
            }
        }
        best.map(|(_, rms, name)| (rms, name))
    }

    /// All effects against the nominal model alone, and the probabilities of nothing, of one of
    /// them and of an unmodelled effect.
    fn candidates(&self, prior: &Prior) -> (Vec<Ranked>, Option<[f64; 3]>) {
        let Self { linear, selection, .. } = self;
        let pools = Pools::of(selection);
        let total = selection.chi_squared(&[]) - selection.chi_squared(self.model);
        let mut live = (*selection).clone();
        live.live = linear.terms.iter().map(|term| !term.columns.is_empty()).collect();
        let ranked = live.ranked(&[], &pools.effects, 0.0);
        let ranked: Vec<_> = ranked.into_iter().filter(|one| one.gain.degrees > 0).collect();
        let blocks = live.ranked(&[], &pools.blocks, 0.0);
        let blocks: Vec<_> = blocks.into_iter().filter(|one| one.gain.degrees > 0).collect();
        let all = || ranked.iter().chain(&blocks).map(|one| one.ln_bayes);
        let most = all().fold(0.0, f64::max);
        let weight = |cause: Cause, ln_bayes: f64| prior.of(cause) * (ln_bayes - most).exp();
        let nothing = weight(Cause::Nothing, 0.0);
        let library: f64 = ranked.iter().map(|one| weight(Cause::Library, one.ln_bayes)).sum();
        let unknown: f64 = blocks.iter().map(|one| weight(Cause::Unknown, one.ln_bayes)).sum();
        let sum = nothing + library + unknown;
        let candidates = ranked.iter().map(|one| {
            let term = &linear.terms[one.term];
            let member = linear.candidates.get(term.candidate);
            let member = member.map(|one| one.selected.member.clone()).unwrap_or_default();
            Ranked {
                name: term.name.clone(),
                member,
                gain: one.gain,
                ln_bayes: one.ln_bayes,
                share: if total > 0.0 { (one.gain.gain / total).clamp(0.0, 1.0) } else { 0.0 },
                probability: weight(Cause::Library, one.ln_bayes) / sum,
                values: sizes(linear, linear.start(&live, &[], one.term)),
            }
        });
        (candidates.collect(), Some([nothing / sum, library / sum, unknown / sum]))
    }
}

/// Values with the units in which their parameters are declared.
fn sizes(linear: &Linear, values: Start) -> Vec<Size> {
    let unit = |name: &str| {
        let names = linear.candidates.iter().filter(|one| {
            name.strip_prefix(one.name.as_str()).is_some_and(|rest| rest.starts_with('.'))
        });
        names.map(|one| one.unit(name)).next().unwrap_or_else(Unit::one)
    };
    let size = |(parameter, component, of, value): (String, usize, Option<String>, f64)| Size {
        unit: unit(&parameter),
        parameter,
        component,
        of,
        value,
    };
    values.into_iter().map(size).collect()
}

/// The ratio of the largest value to its typical magnitude.
fn ratio_to_typical(problem: &Problem, values: &[Estimate]) -> Option<f64> {
    let ratio = |one: &Estimate| {
        let typical = problem.layout.instances[one.instance?].setting.typical?;
        Some(one.value?.abs() / typical)
    };
    values.iter().filter_map(ratio).reduce(f64::max)
}
