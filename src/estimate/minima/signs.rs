//! Scalars that are stated to start with one sign and end with the other: of two minima that fit
//! alike, a scale of 1 with a frame or of -1 with the frame turned by half a turn, a start says which
//! one is meant. It tries other attitudes; what the readings alone decide stays. Of an estimate that
//! keeps the signs no minimum is another one that does not.

use rayon::prelude::*;

use crate::engine::{Point, Problem};
use crate::estimate::minima::starts::Attitudes;
use crate::estimate::minima::thinned::{Thinned, Tried};
use crate::estimate::start::start;
use crate::graph::Kind;

use super::{EXCLUDED, ITERATIONS, SAMPLES};

/// The start from which scalars keep the signs with which they are stated to start, where they do not
/// from the stated one and the fit is as good.
pub(super) fn start_that_keeps_signs(problem: &Problem, stated: &[(usize, f64)]) -> Option<Point> {
    let attitudes = Attitudes::of(problem);
    if stated.is_empty() || attitudes.count() < 2 {
        return None;
    }
    let some = Thinned::of(problem, SAMPLES[1]);
    let look = |attitude: usize| {
        let problem = some.late_by(0.0, &[])?;
        let mut point = start(&problem).0;
        attitudes.apply(attitude, &mut point);
        Tried::fit(problem, point, 0.0, ITERATIONS[2])
    };
    let lost = |fit: &Tried| lost_signs(stated, &fit.point).len();
    let own = look(0)?;
    let lost_before = lost(&own);
    if lost_before == 0 {
        return None;
    }
    let limit = own.chi_squared + EXCLUDED * own.variance_factor.max(1.0) / some.times;
    let others = (1..attitudes.count()).into_par_iter().filter_map(look);
    let mut alike: Vec<Tried> = others.filter(|fit| fit.chi_squared < limit).collect();
    alike.sort_by(|a, b| lost(a).cmp(&lost(b)).then(a.chi_squared.total_cmp(&b.chi_squared)));
    alike.into_iter().next().filter(|best| lost(best) < lost_before).map(|best| best.point)
}

/// The scalars that have another sign than the one with which they are stated to start.
pub(super) fn lost_signs(stated: &[(usize, f64)], point: &Point) -> Vec<usize> {
    let is_lost = |(index, start): &&(usize, f64)| point.values[*index][0] * start.signum() < 0.0;
    stated.iter().filter(is_lost).map(|one| one.0).collect()
}

/// Free scalars whose start is stated and not zero, with it, whether or not a search found another.
pub(super) fn stated_signs(problem: &Problem) -> Vec<(usize, f64)> {
    let layout = &problem.layout;
    let of = |index: usize| {
        let one = &layout.instances[index];
        let is_angle_or_delay = one.unit.is_angle() || one.is_delay();
        let is_tried = one.kind == Kind::Scalar && !is_angle_or_delay;
        let start = if one.start_found { one.stated_start } else { one.setting.start_of(0) };
        let start = start.filter(|start| *start != 0.0)?;
        (is_tried && layout.is_free(index)).then_some((index, start))
    };
    (0..layout.instances.len()).filter_map(of).collect()
}
