//! Logged numbers as they are if a convention was mistaken.

use std::sync::Arc;

use crate::campaign::Samples;
use crate::campaign::signal::Track;
use crate::campaign::spline::Spline;
use crate::convention::Convention;
use crate::engine::Problem;
use crate::engine::gram::LeastSquares;
use crate::estimate::conventions::channels::{Channel, Source};
use crate::estimate::conventions::one_run::OneRun;
use crate::estimate::minima::thinned::Tried;
use crate::formula::{Expression, ExpressionKind};
use crate::model::name::error_of_input;

/// How far a formula may be off a linear one.
const LINEAR: f64 = 1e-9;
/// What one coordinate of a vector in another unit counts more than all of them, in letters.
const ONE_COORDINATE: usize = 100;

/// A convention that may have been mistaken for some numbers.
#[derive(Clone, Debug)]
pub(super) struct Suspected<'c> {
    pub(super) convention: &'c Convention,
    pub(super) channels: Vec<Channel>,
    /// The run in which it was; `None` for all.
    pub(super) only: Option<OneRun>,
}

impl Suspected<'_> {
    /// The numbers, of those as they were read.
    fn values(&self, read: &[f64]) -> Vec<f64> {
        let names = self.convention.form.components();
        let of_some = |read: &[f64]| -> Vec<f64> {
            let of = |name: &str| Some(read[names.iter().position(|one| *one == name)?]);
            let formulas = self.convention.formulas.iter();
            formulas.map(|formula| formula.root.value(&of).unwrap_or(f64::NAN)).collect()
        };
        // A convention of single numbers may be that of several.
        read.chunks(names.len()).flat_map(of_some).collect()
    }

    /// Constants and factors, where the formulas are linear: a row of factors for each number.
    fn linear(&self) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let count = self.channels.len();
        let constants = self.values(&vec![0.0; count]);
        let unit =
            |at: usize| (0..count).map(|one| f64::from(u8::from(one == at))).collect::<Vec<_>>();
        let columns: Vec<Vec<f64>> = (0..count).map(|at| self.values(&unit(at))).collect();
        let factors: Vec<Vec<f64>> = (0..count)
            .map(|row| columns.iter().map(|column| column[row] - constants[row]).collect())
            .collect();
        let probe: Vec<f64> = (0..count).map(|at| 0.37 + 0.81 * at as f64).collect();
        let is_linear = self.values(&probe).iter().zip(&constants).zip(&factors).all(
            |((value, constant), row)| {
                let sum: f64 = row.iter().zip(&probe).map(|(factor, value)| factor * value).sum();
                (value - constant - sum).abs() <= LINEAR * (1.0 + value.abs())
            },
        );
        is_linear.then_some((constants, factors))
    }

    /// How much its formulas say: letters of them all.
    pub(super) fn length(&self) -> usize {
        let is_one = matches!(self.channels.as_slice(), [one] if one.is_coordinate);
        let letters: usize = self.convention.formulas.iter().map(|one| one.text.len()).sum();
        letters + if is_one { ONE_COORDINATE } else { 0 }
    }

    /// Whether all of its numbers are readings, none an input.
    pub(super) fn is_of_readings(&self) -> bool {
        self.channels.iter().all(|one| matches!(one.source, Source::Reading(_)))
    }

    /// The factor by which readings are stretched, the mean of them; `None` where it is 1.
    fn stretch(&self) -> Option<f64> {
        let (_, factors) = self.linear().filter(|_| self.is_of_readings())?;
        let size = |row: &Vec<f64>| row.iter().map(|factor| factor * factor).sum::<f64>().sqrt();
        let mean = factors.iter().map(|row| size(row).ln()).sum::<f64>() / factors.len() as f64;
        (mean.abs() > LINEAR).then(|| mean.exp())
    }

    /// Logarithm of what the variance factor of a fit of the changed problem is multiplied by where the
    /// uncertainties of changed readings are stretched like these, by `s`: chi squared is that of the
    /// other readings and that of these over `s²`.
    pub(super) fn stretched(&self, changed: &Problem, fit: &Tried) -> f64 {
        let Some(stretch) = self.stretch() else { return 0.0 };
        let mut others = changed.clone();
        for one in OneRun::all(changed).filter(|one| self.is_in(*one)) {
            let record = &mut others.parts[one.part].runs[one.run].record;
            let own = self.channels.iter().filter_map(|channel| match channel.source {
                Source::Reading(column) => Some((0..record.len(), column..column + 1)),
                Source::Input(_) => None,
            });
            let own: Vec<_> = own.collect();
            record.leave_out(own);
        }
        others.reweight(&fit.point);
        let rest = others.cost(&fit.point).min(fit.chi_squared);
        let relative = rest + (fit.chi_squared - rest) / stretch.powi(2);
        (relative / fit.chi_squared).ln()
    }

    fn is_in(&self, run: OneRun) -> bool {
        self.only.is_none_or(|only| only == run)
    }

    /// The problem with these numbers changed; `None` where that cannot be done.
    pub(super) fn applied(&self, problem: &Problem) -> Option<Problem> {
        let mut problem = problem.clone();
        let mut is_possible = true;
        // Numbers that are changed together may be of several files.
        let count = self.convention.form.components().len();
        let of = |channels: &[Channel]| Self { channels: channels.to_vec(), ..self.clone() };
        let each: Vec<Self> = self.channels.chunks(count).map(of).collect();
        for one in OneRun::all(&problem).filter(|one| self.is_in(*one)).collect::<Vec<_>>() {
            let record = &mut problem.parts[one.part].runs[one.run].record;
            record.edit(|samples| {
                is_possible &= each.iter().all(|own| own.change(samples).is_some());
            });
        }
        self.stretch_scatter(&mut problem);
        is_possible.then_some(problem)
    }

    /// Gives the inputs that are changed the standard uncertainties of what they are made of: an input
    /// in thousandths scatters by thousandths, too. Those of one run are those of all: where one alone is
    /// changed they never grow.
    fn stretch_scatter(&self, problem: &mut Problem) {
        let Some((_, factors)) = self.linear() else { return };
        for part in &mut problem.parts {
            let place = |channel: &Channel| {
                let error = error_of_input(&channel.name);
                part.system.randoms.iter().position(|one| one.name == error)
            };
            let places: Vec<Option<usize>> = self.channels.iter().map(place).collect();
            let stated: Vec<f64> =
                places.iter().map(|at| at.map_or(0.0, |at| part.random_sigma[at])).collect();
            for (row, at) in factors.iter().zip(&places) {
                let Some(at) = *at else { continue };
                let squares = row.iter().zip(&stated).map(|(by, sigma)| (by * sigma).powi(2));
                let most = if self.only.is_some() { part.random_sigma[at] } else { f64::INFINITY };
                part.random_sigma[at] = squares.sum::<f64>().sqrt().min(most);
            }
        }
    }

    fn change(&self, samples: &mut Samples) -> Option<()> {
        let columns: Vec<usize> = self
            .channels
            .iter()
            .filter_map(|one| match one.source {
                Source::Reading(column) => Some(column),
                Source::Input(_) => None,
            })
            .collect();
        if columns.is_empty() {
            return self.change_inputs(samples);
        }
        for sample in 0..samples.len() {
            let read: Vec<f64> =
                columns.iter().map(|column| samples.readings[*column][sample]).collect();
            for (column, value) in columns.iter().zip(self.values(&read)) {
                samples.readings[*column][sample] = value;
            }
        }
        Some(())
    }

    fn change_inputs(&self, samples: &mut Samples) -> Option<()> {
        let inputs: Vec<usize> = self
            .channels
            .iter()
            .filter_map(|one| match one.source {
                Source::Input(index) => Some(index),
                Source::Reading(_) => None,
            })
            .collect();
        let tracks: Vec<Track> =
            inputs.iter().map(|index| samples.inputs[*index].clone()).collect();
        let linear = self.linear();
        let changed: Vec<Track> = match &tracks[0] {
            Track::Absent => return None,
            Track::Constant(_) => {
                let read = tracks.iter().map(|track| match track {
                    Track::Constant(value) => Some(*value),
                    _ => None,
                });
                let read: Vec<f64> = read.collect::<Option<_>>()?;
                self.values(&read).into_iter().map(Track::Constant).collect()
            }
            Track::Captured { .. } => self.captured(&tracks, linear.as_ref())?,
            Track::Logged(_) => self.logged(&tracks, linear.as_ref())?,
        };
        for (index, track) in inputs.into_iter().zip(changed) {
            samples.inputs[index] = track;
        }
        Some(())
    }

    fn captured(
        &self,
        tracks: &[Track],
        linear: Option<&(Vec<f64>, Vec<Vec<f64>>)>,
    ) -> Option<Vec<Track>> {
        let mut parts = Vec::new();
        for track in tracks {
            let Track::Captured { value, rate, acceleration } = track else { return None };
            parts.push((value, rate.as_ref(), acceleration.as_ref()));
        }
        let moves = parts.iter().any(|(_, rate, _)| rate.is_some());
        let factors = match linear {
            Some((_, factors)) => factors,
            None if moves => return None,
            None => &Vec::new(),
        };
        let count = parts[0].0.len();
        let mut values = vec![Vec::with_capacity(count); tracks.len()];
        for sample in 0..count {
            let read: Vec<f64> = parts.iter().map(|(value, ..)| value[sample]).collect();
            values
                .iter_mut()
                .zip(self.values(&read))
                .for_each(|(column, value)| column.push(value));
        }
        // Rates follow the factors alone.
        let derived = |of: &dyn Fn(usize) -> Option<Vec<f64>>, row: &[f64]| {
            let columns: Option<Vec<Vec<f64>>> = (0..parts.len()).map(of).collect();
            let columns = columns?;
            let sum = |sample: usize| {
                row.iter()
                    .zip(&columns)
                    .map(|(factor, column)| factor * column[sample])
                    .sum::<f64>()
            };
            Some((0..count).map(sum).collect::<Vec<f64>>())
        };
        let tracks = values.into_iter().enumerate().map(|(at, value)| Track::Captured {
            value,
            rate: factors.get(at).and_then(|row| derived(&|one| parts[one].1.cloned(), row)),
            acceleration: factors
                .get(at)
                .and_then(|row| derived(&|one| parts[one].2.cloned(), row)),
        });
        Some(tracks.collect())
    }

    fn logged(
        &self,
        tracks: &[Track],
        linear: Option<&(Vec<f64>, Vec<Vec<f64>>)>,
    ) -> Option<Vec<Track>> {
        let splines = tracks.iter().map(|track| match track {
            Track::Logged(spline) => Some(spline.as_ref()),
            _ => None,
        });
        let splines: Vec<&Spline> = splines.collect::<Option<_>>()?;
        if let Some((constants, factors)) = linear {
            let sums = constants.iter().zip(factors).map(|(constant, row)| {
                let terms: Vec<(f64, &Spline)> =
                    row.iter().copied().zip(splines.iter().copied()).collect();
                Some(Track::Logged(Arc::new(Spline::sum(*constant, &terms)?)))
            });
            return sums.collect();
        }
        let rows: Vec<Vec<f64>> = splines[0]
            .moments()
            .map(|moment| {
                let read: Vec<f64> = splines.iter().map(|one| one.at(moment, 0.0, 0)).collect();
                self.values(&read)
            })
            .collect();
        let column = |at: usize| {
            let values: Vec<f64> = rows.iter().map(|row| row[at]).collect();
            Some(Track::Logged(Arc::new(splines[0].through(&values)?)))
        };
        (0..tracks.len()).map(column).collect()
    }

    /// What each changed number is, as a formula of the columns as they were read, over what was
    /// changed before.
    pub(super) fn formulas(&self, before: &[(String, Expression)]) -> Vec<(String, Expression)> {
        let names = self.convention.form.components();
        let mut changed: Vec<(String, Expression)> = Vec::new();
        for channels in self.channels.chunks(names.len()) {
            let of = |component: &str| {
                let at = names.iter().position(|one| *one == component)?;
                let name = &channels[at].name;
                let known = before.iter().find(|(own, _)| own == name);
                let span = self.convention.formulas[0].root.span;
                let as_read = Expression { kind: ExpressionKind::Name(name.clone()), span };
                Some(known.map_or(as_read, |(_, formula)| formula.clone()))
            };
            let formulas = channels.iter().zip(&self.convention.formulas);
            changed.extend(formulas.map(|(channel, formula)| {
                (channel.name.clone(), crate::formula::isolate::replaced(&formula.root, &of))
            }));
        }
        let others = before.iter().filter(|(name, _)| changed.iter().all(|(own, _)| own != name));
        others.cloned().chain(changed.iter().cloned()).collect()
    }
}
