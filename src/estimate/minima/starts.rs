//! From which offsets of the clock and in which attitudes to start.

use std::f64::consts::FRAC_PI_2;

use crate::campaign::delay_range::DelayRange;
use crate::campaign::signal::Track;
use crate::campaign::spline::Spline;
use crate::engine::layout::Layout;
use crate::engine::{Point, Problem};
use crate::estimate::minima::clocks::Clock;
use crate::graph::Kind;

/// Most offsets to either side.
const MOST_OFFSETS: usize = 400;
/// Most starts: offsets to both sides by attitudes.
const MOST_STARTS: usize = 6_000;
/// Most attitudes.
const MOST_ATTITUDES: usize = 24;
/// Moments at which it is asked how fast streams change.
const MOMENTS: usize = 256;
/// The shortest step between offsets (s).
const SHORTEST: f64 = 1e-3;

/// Offsets of the clock.
pub(in crate::estimate) struct Offsets {
    /// The delays that follow the clock.
    pub(in crate::estimate) delays: Vec<usize>,
    /// Between two offsets (s): about a sixth of the period of the fastest stream.
    pub(in crate::estimate) step: f64,
    /// All of them, the middle first: zero, unless a range to one side is stated.
    pub(in crate::estimate) all: Vec<f64>,
    /// Whether a range is stated.
    pub(in crate::estimate) is_stated: bool,
}

impl Offsets {
    /// Those of a clock, so that there are not too many starts with so many attitudes; zero alone
    /// where nothing is logged, or where what is known of a delay says where to look.
    pub(in crate::estimate) fn of(problem: &Problem, clock: &Clock, attitudes: usize) -> Self {
        let layout = &problem.layout;
        let delays = clock.delays.clone();
        let is_known = delays.iter().any(|index| !is_open(layout, *index));
        let step = step(problem);
        let none = Self { delays: Vec::new(), step: 0.0, all: vec![0.0], is_stated: false };
        let Some(step) = step.filter(|_| !is_known && !delays.is_empty()) else { return none };
        // A range that is stated is where to look; else the whole log.
        let parts = problem.parts.iter().enumerate();
        let parts = parts.filter(|(p, _)| clock.runs.iter().any(|(own, _)| own == p));
        let stated = parts.map(|(_, part)| &part.delay_range);
        let stated = stated.filter(|range| range.is_stated()).map(DelayRange::hull);
        let [low, high] = stated.fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], range| {
            [low.max(range[0]), high.min(range[1])]
        });
        let middle = 0.5 * (low + high);
        let (middle, width) =
            if middle.is_finite() { (middle, high - middle) } else { (0.0, high) };
        let most = (MOST_STARTS / (2 * attitudes.max(1))).clamp(MOST_OFFSETS / 4, MOST_OFFSETS);
        // A range that is stated is searched as a whole, if that can be done at all.
        let most = if width.is_finite() { (8 * most).min(MOST_STARTS) } else { most };
        let count = ((width / step).floor() as usize).min(most);
        let sides = (1..=count).flat_map(|n| [n as f64 * step, -(n as f64) * step]);
        let all = std::iter::once(0.0).chain(sides).map(|offset| middle + offset).collect();
        Self { delays, step, all, is_stated: width.is_finite() }
    }

    /// The least and the greatest offset (s).
    pub(in crate::estimate) fn span(&self) -> [f64; 2] {
        let fold = |f: fn(f64, f64) -> f64| self.all.iter().copied().reduce(f).unwrap_or(0.0);
        [fold(f64::min), fold(f64::max)]
    }

    /// Whether an offset lies within their range (s).
    pub(super) fn holds(&self, offset: f64) -> bool {
        let [low, high] = self.span();
        (low - self.step..=high + self.step).contains(&offset)
    }

    /// The mean delay at a point (s).
    pub(in crate::estimate) fn mean(&self, point: &Point) -> f64 {
        let sum: f64 = self.delays.iter().map(|index| point.values[*index][0]).sum();
        sum / self.delays.len().max(1) as f64
    }

    /// Puts an offset into the delays.
    pub(in crate::estimate) fn delay(&self, point: &mut Point, offset: f64) {
        self.delays.iter().for_each(|index| point.values[*index][0] += offset);
    }
}

/// How far apart offsets may be (s): the shortest time in which a stream changes as much as it does
/// at all, by rms; `None` where nothing is logged.
fn step(problem: &Problem) -> Option<f64> {
    let runs = problem.parts.iter().flat_map(|part| &part.runs);
    shortest_time(runs.flat_map(|run| run.record.inputs()))
}

/// The shortest time (s) in which one of these streams changes as much as it does at all, by rms.
pub(in crate::estimate) fn shortest_time<'t>(
    tracks: impl Iterator<Item = &'t Track>,
) -> Option<f64> {
    let times = tracks.filter_map(|track| match track {
        Track::Logged(spline) => time_scale(spline),
        _ => None,
    });
    times.min_by(f64::total_cmp).map(|time| time.max(SHORTEST))
}

/// Standard deviation of a stream over the rms of its rate (s); `None` where it stands still.
fn time_scale(spline: &Spline) -> Option<f64> {
    let (from, to) = spline.span();
    let moment = |n: usize| from + (to - from) * (n as f64 + 0.5) / MOMENTS as f64;
    let at = |order: u8| (0..MOMENTS).map(move |n| spline.at(moment(n), 0.0, order));
    let mean = at(0).sum::<f64>() / MOMENTS as f64;
    let spread = at(0).map(|value| (value - mean).powi(2)).sum::<f64>();
    let rate = at(1).map(|value| value.powi(2)).sum::<f64>();
    let time = (spread / rate).sqrt();
    (time.is_finite() && time > 0.0).then_some(time)
}

/// Attitudes of rotations, and of angles, from which nothing else says where to start.
pub(in crate::estimate) struct Attitudes {
    /// For each start, which instances have which value; the first is as stated.
    all: Vec<Vec<(usize, [f64; 4])>>,
    /// How many more there are, which nobody tries.
    pub(super) left_out: usize,
}

impl Attitudes {
    /// Those of the parameters that act in runs of a problem that have samples.
    pub(in crate::estimate) fn of(problem: &Problem) -> Self {
        let layout = &problem.layout;
        let acts = |index: &usize| {
            let runs = problem.parts.iter().zip(&layout.used);
            let mut runs = runs.flat_map(|(part, used)| part.runs.iter().zip(used));
            runs.any(|(run, used)| !run.record.is_empty() && used.contains(index))
        };
        let mut all = vec![Vec::new()];
        let open = (0..layout.instances.len()).filter(|index| is_open(layout, *index));
        for index in open.filter(acts) {
            let one = &layout.instances[index];
            let values = match one.kind {
                Kind::Rotation => rotations(),
                Kind::Scalar if one.unit.is_angle() => {
                    let angle = |n: i32| [f64::from(n) * FRAC_PI_2, 0.0, 0.0, 0.0];
                    [1, 2, -1].map(angle).to_vec()
                }
                _ => continue,
            };
            if all.len() * (values.len() + 1) > MOST_ATTITUDES {
                // Too many to combine: this one by itself.
                all.extend(values.into_iter().map(|value| vec![(index, value)]));
                continue;
            }
            let with = |start: &Vec<(usize, [f64; 4])>| {
                let start = start.clone();
                values
                    .clone()
                    .into_iter()
                    .map(move |value| [start.clone(), vec![(index, value)]].concat())
            };
            let more: Vec<_> = all.iter().flat_map(with).collect();
            all.extend(more);
        }
        let left_out = all.len().saturating_sub(4 * MOST_ATTITUDES);
        all.truncate(4 * MOST_ATTITUDES);
        Self { all, left_out }
    }

    pub(in crate::estimate) fn count(&self) -> usize {
        self.all.len()
    }

    pub(in crate::estimate) fn apply(&self, number: usize, point: &mut Point) {
        for (index, value) in &self.all[number] {
            point.values[*index] = *value;
        }
    }
}

/// The turns of a tetrahedron but for none at all: every rotation is within 90° of one of them or of
/// none.
fn rotations() -> Vec<[f64; 4]> {
    let half = [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let signs = [1.0, -1.0];
    let thirds = signs.iter().flat_map(|x| {
        signs.iter().flat_map(move |y| signs.map(move |z| [0.5, 0.5 * x, 0.5 * y, 0.5 * z]))
    });
    half.into_iter().chain(thirds).collect()
}

/// Whether an instance is estimated from nothing but readings: free, and without a value, a start or
/// a bound of the user's.
pub(super) fn is_open(layout: &Layout, index: usize) -> bool {
    let one = &layout.instances[index];
    let setting = &one.setting;
    let start = if one.start_found { &None } else { &setting.start };
    let said = [&setting.value, start, &setting.lower, &setting.upper];
    layout.is_free(index) && said.iter().all(|one| one.is_none()) && setting.components.is_none()
}
