//! Which reading keeps a model from being computed: its prediction has no value, or it is too far
//! from it.

use crate::campaign::Sample;
use crate::campaign::record::BLOCK;
use crate::campaign::run::Samples;
use crate::engine::part::SampleLeaves;
use crate::engine::point::Point;
use crate::engine::problem::Problem;

/// A reading that is far from its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Farthest {
    /// Campaign, run, sample, measurand, by index.
    pub place: (usize, usize, usize, usize),
    /// How far (SI): the largest component of its residual.
    pub residual: f64,
}

impl Problem {
    /// The first reading whose prediction is undefined at a point: campaign, run, sample,
    /// measurand.
    pub fn first_undefined(&self, point: &Point) -> Option<(usize, usize, usize, usize)> {
        let (mut workspace, mut scratch) = (Vec::new(), Samples::default());
        for (p, part) in self.parts.iter().enumerate() {
            let randoms = vec![0.0; part.random_sigma.len()];
            for (r, run) in part.runs.iter().enumerate() {
                let parameters = self.parameters::<f64>(p, r, point);
                let undefined = |sample: Sample<'_>, workspace: &mut Vec<f64>| {
                    let (parameters, randoms) = (&parameters[..], &randoms[..]);
                    let columns = part.columns();
                    let leaves = SampleLeaves { parameters, randoms, columns, sample };
                    let outputs = part.evaluate(&leaves, workspace);
                    part.slots().iter().position(|slot| {
                        part.is_present(sample, slot)
                            && !part.residual(sample, slot, outputs).iter().all(|v| v.is_finite())
                    })
                };
                for range in run.record.ranges(BLOCK) {
                    for sample in run.record.stretch(range, &mut scratch).each() {
                        if let Some(m) = undefined(sample, &mut workspace) {
                            return Some((p, r, sample.number, m));
                        }
                    }
                }
            }
        }
        None
    }

    /// The reading whose residual is largest over its stated standard uncertainty at a point, of
    /// those that have a finite one.
    pub fn farthest(&self, point: &Point) -> Option<Farthest> {
        let mut farthest: Option<(f64, Farthest)> = None;
        for (p, part) in self.parts.iter().enumerate() {
            for r in 0..part.runs.len() {
                self.visit_residuals(p, r, point, &mut |sample, residuals| {
                    for (m, slot) in part.slots().iter().enumerate() {
                        let own = &residuals[slot.residual..slot.residual + slot.components];
                        let residual = own.iter().fold(0.0, |most: f64, one| most.max(one.abs()));
                        let over = residual / part.sigma_in(r, m);
                        if farthest.is_none_or(|(known, _)| over > known) {
                            let place = (p, r, sample.number, m);
                            farthest = Some((over, Farthest { place, residual }));
                        }
                    }
                });
            }
        }
        farthest.map(|(_, one)| one)
    }
}
