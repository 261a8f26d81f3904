//! Which components of parameters are withheld, because they take part in what is not determined.
//!
//! A component keeps its value and uncertainty where no open direction moves it, and where the
//! direction moves it by less than the component's own plausible size.

use nalgebra::DMatrix;

use crate::engine::layout::Layout;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::batch::Fit;
use crate::estimate::covariance::of_combination;
use crate::estimate::observability::{Direction, Examined, Kind as Exactness, Limit, NEGLIGIBLE};
use crate::graph::Kind;

/// Shares of an exact direction below this are rounding.
pub const TRACE: f64 = 1e-5;
/// A parameter known to this part of its size is determined, whatever its plausible size; a delay to
/// this part of the largest in the range that is stated of delays.
const RELATIVE: f64 = 0.01;

/// A variance factor below which the stated uncertainties are of another unit, from so many degrees of
/// freedom on: what is plausible is then judged with the noise that is found.
const OF_ANOTHER_UNIT: f64 = 1e-4;
const DEGREES: usize = 10;

/// By how much the standard uncertainties of a fit are too large.
fn overstated(problem: &Problem, fit: &Fit<Point>) -> f64 {
    let readings = problem.component_count() + fit.normal.priors.len();
    let degrees = readings.saturating_sub(problem.layout.columns.len());
    let factor = fit.cost / degrees.max(1) as f64;
    let is_other = degrees >= DEGREES && factor > 0.0 && factor < OF_ANOTHER_UNIT;
    if is_other { 1.0 / factor.sqrt() } else { 1.0 }
}

/// The limit of every column. What is stated with a standard uncertainty has none of its own.
pub fn limits(problem: &Problem, fit: &Fit<Point>) -> Vec<Limit> {
    let overstated = overstated(problem, fit);
    let mut limits = vec![Limit::Unlimited; problem.layout.columns.len()];
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        for component in 0..instance.dimension() {
            for (column, _) in problem.layout.columns_of(index, component) {
                limits[column] = limit(problem, &fit.point, (index, component), overstated);
            }
        }
    }
    limits
}

/// The limit of one component of a parameter.
fn limit(
    problem: &Problem,
    point: &Point,
    (index, component): (usize, usize),
    overstated: f64,
) -> Limit {
    let layout = &problem.layout;
    let instance = &layout.instances[index];
    let setting = &instance.setting;
    match setting.plausible {
        _ if setting.sigma_of(component).is_some() => Limit::Stated,
        None => Limit::Unlimited,
        Some(plausible) if instance.kind == Kind::Rotation => Limit::Size(overstated * plausible),
        Some(plausible) => {
            let square: f64 =
                point.components(layout, index).iter().map(|value| value * value).sum();
            let ranges =
                problem.parts.iter().flat_map(|part| part.delay_range.hull()).map(f64::abs);
            let most = if instance.is_delay() { ranges.fold(0.0, f64::max) } else { 0.0 };
            // A size that cannot be computed sets no limit.
            Limit::Size(overstated * plausible.max(RELATIVE * square.sqrt().max(most)))
        }
    }
}

/// How each component of a parameter moves with the columns.
pub fn sensitivities(layout: &Layout, point: &Point, index: usize) -> Vec<Vec<(usize, f64)>> {
    let of_row = |row: Vec<f64>| {
        let acts = |(_, derivative): &(usize, f64)| *derivative != 0.0;
        let moved = row.into_iter().enumerate().filter(acts).flat_map(|(component, derivative)| {
            let columns = layout.columns_of(index, component).into_iter();
            columns.map(move |(column, coefficient)| (column, derivative * coefficient))
        });
        moved.collect()
    };
    point.component_jacobian(layout, index).into_iter().map(of_row).collect()
}

/// How far a component moves along a direction: in its own unit, and of columns of unit length.
pub fn along(direction: &Direction, sensitivity: &[(usize, f64)]) -> (f64, f64) {
    let (mut moved, mut share) = (0.0, 0.0);
    for (at, (column, weight)) in direction.weights.iter().enumerate() {
        for (_, factor) in sensitivity.iter().filter(|(own, _)| own == column) {
            moved += factor * weight;
            share += factor * direction.shares[at];
        }
    }
    (moved, share)
}

/// For each instance and component whether it is withheld.
pub fn withheld(
    problem: &Problem,
    fit: &Fit<Point>,
    examined: Option<&Examined>,
) -> Vec<Vec<bool>> {
    let (point, overstated) = (&fit.point, overstated(problem, fit));
    let layout = &problem.layout;
    let of_instance = |index: usize| {
        let rows = sensitivities(layout, point, index);
        let is_open = |(component, row): (usize, Vec<(usize, f64)>)| {
            let limit = limit(problem, point, (index, component), overstated);
            examined.is_some_and(|found| {
                let directions = &found.directions;
                directions.iter().any(|one| is_moved(one, &found.judged, &row, limit))
            })
        };
        let open: Vec<bool> = rows.into_iter().enumerate().map(is_open).collect();
        // The components of a rotation vector follow a large turn in curves: they stay together.
        match layout.instances[index].kind {
            Kind::Rotation => vec![open.contains(&true); open.len()],
            Kind::Scalar | Kind::Vector => open,
        }
    };
    (0..layout.instances.len()).map(of_instance).collect()
}

/// Whether a direction moves a component too far.
fn is_moved(
    direction: &Direction,
    judged: &DMatrix<f64>,
    sensitivity: &[(usize, f64)],
    limit: Limit,
) -> bool {
    let (_, share) = along(direction, sensitivity);
    match (direction.kind, limit) {
        _ if share.abs() <= TRACE => false,
        (Exactness::Exact, _) => true,
        (Exactness::UpToNoise, Limit::Stated) => false,
        (Exactness::UpToNoise, Limit::Size(size)) => {
            of_combination(judged, sensitivity).max(0.0).sqrt() > size
        }
        (Exactness::UpToNoise, Limit::Unlimited) => {
            !direction.is_implausible && share.abs() >= NEGLIGIBLE
        }
    }
}
