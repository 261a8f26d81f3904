//! Delays that differ between the runs for which they have one value: recorders that are started anew.
//!
//! Each run's own value follows from its sums with all other unknowns where they are, so what such
//! values take off chi squared is a lower bound. It is asked of delays alone, each by itself.

use crate::estimate::calibrate::Calibration;

/// Part of what chi squared has beyond its degrees of freedom that values of runs take off.
const SHARE: f64 = 0.5;
/// Mean square of differences, in squared standard uncertainties, from which delays differ.
const DIFFER: f64 = 25.0;

/// A delay that differs between runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Differing {
    /// The delay.
    pub name: String,
    /// The setup or campaign for which it has this value; `None` for all.
    pub of: Option<String>,
    /// In how many runs it acts.
    pub runs: usize,
    /// The least and the greatest difference of a run's own value from the common one (s).
    pub ends: [f64; 2],
    /// Standard deviation of the runs' values (s).
    pub scatter: f64,
}

/// The delays of a fit that differ between runs by more than noise, where that is most of what the fit
/// leaves.
pub fn delays_that_differ(fit: &Calibration) -> Vec<Differing> {
    let normal = &fit.fit.normal;
    let excess = fit.fit.cost - fit.degrees_of_freedom() as f64;
    if !fit.is_sound() || excess <= 0.0 {
        return Vec::new();
    }
    let layout = &fit.problem.layout;
    let delays = layout.instances.iter().enumerate().filter(|(_, one)| one.is_delay());
    let found = delays.filter_map(|(index, one)| {
        let (_, column) = layout.own_columns(index).next()?;
        let mut differences = Vec::new();
        let mut gain = 0.0;
        for (run, sums) in normal.runs.iter().enumerate() {
            let touched = normal.columns.touched_by(run);
            let Ok(at) = touched.binary_search(&column) else { continue };
            let [own, score] = [sums.gram[(at, at)], sums.gram[(at, touched.len())]];
            if own > 0.0 {
                gain += score * score / own;
                differences.push(score / own);
            }
        }
        let runs = differences.len();
        let free = runs.checked_sub(1).filter(|free| *free > 0)? as f64;
        let differs = gain >= SHARE * excess && gain >= DIFFER * free;
        let squares: f64 = differences.iter().map(|one| one * one).sum();
        differs.then(|| Differing {
            name: one.name.clone(),
            of: one.of.clone(),
            runs,
            ends: differences
                .iter()
                .fold([0.0, 0.0], |[low, high], one| [f64::min(low, *one), f64::max(high, *one)]),
            scatter: (squares / free).sqrt(),
        })
    });
    found.collect()
}
