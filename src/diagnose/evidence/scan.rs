//! Families over a range (a frequency, a period, a width): which member explains most.
//!
//! A line is as narrow as the recordings are long: a fixed grid of members would miss it. So the grid is
//! made from the signatures themselves: neighbours are so near that their squared cosine is
//! `NEIGHBOURS`. The constant is left open in one compiled program, `TOGETHER` members at once: one pass
//! over the readings serves them all. What nominal parameters take up only raises a gain, so the
//! `BEST` members by the plain gain are looked at again with that taken off, and polished by golden
//! section; coupling between values of different runs is left aside. The best is then tested like any
//! other candidate; every member of the grid is paid for, twice for the polishing. A list of members is
//! looked through in the same way, as it stands.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidates::{Candidate, join};
use crate::effect::{Effect, Members};
use crate::engine::Problem;
use crate::engine::gram::RunGram;
use crate::engine::signatures::{Candidate as Signed, Signatures};
use crate::graph::Scope;
use crate::system::{Selected, System};
use crate::units::Unit;

use super::nominal::Nominal;
use super::sampling::Sampling;

/// Squared cosine between the signatures of neighbours.
const NEIGHBOURS: f64 = 0.4;
/// Members that are looked at again.
const BEST: usize = 40;
/// Members at most.
const MOST: usize = 2_000;
/// Member times sample at most: longer campaigns are scanned more coarsely.
const MOST_WORK: usize = 20_000_000;
/// Halvings in search of a step.
const HALVINGS: usize = 16;
/// Steps of the golden section.
const POLISH: usize = 12;
/// Members in one pass over the readings: they share everything but their own columns.
const TOGETHER: usize = 8;

/// What was found before: the family, its best member, and the number of members.
pub type Scanned = Vec<(String, Candidate, usize)>;

/// The best member of a family, if it is not among those `known`, and the number of members that it was chosen among. `None` where the
/// effect has not just one family, or its member cannot be left open.
pub fn scan(
    fitted: &Fitted,
    family: &Candidate,
    known: &mut Scanned,
) -> Option<(Candidate, usize)> {
    if let Some((_, candidate, members)) = known.iter().find(|(name, ..)| *name == family.name) {
        return Some((candidate.clone(), *members));
    }
    let effect = &family.selected.effect;
    let (name, declared) = effect.shape.first().filter(|_| effect.shape.len() == 1)?;
    let scan = Scan::new(fitted, family, name)?;
    let (grid, tried) = scan.tried(&declared.members)?;
    let plain: Vec<f64> =
        grid.chunks(TOGETHER).flat_map(|members| scan.plain_gains(members)).collect();
    let mut order: Vec<usize> = (0..grid.len()).collect();
    order.sort_by(|a, b| plain[*b].total_cmp(&plain[*a]));
    order.truncate(BEST);
    let mut gains: Vec<f64> = vec![0.0; grid.len()];
    for members in order.chunks(TOGETHER) {
        let values: Vec<f64> = members.iter().map(|member| grid[*member]).collect();
        for (member, gain) in members.iter().zip(scan.gains(&values)) {
            gains[*member] = gain;
        }
    }
    let best = order.into_iter().max_by(|a, b| gains[*a].total_cmp(&gains[*b]))?;
    let value = match declared.members {
        Members::List(_) => grid[best],
        Members::Range { .. } => {
            let low = grid[best.saturating_sub(1)];
            let high = grid[(best + 1).min(grid.len() - 1)];
            scan.polished(low, high, (grid[best], gains[best]))
        }
    };
    let candidate = with_member(fitted, family, value)?;
    known.push((family.name.clone(), candidate.clone(), tried));
    Some((candidate, tried))
}

/// A family's candidate with this member.
pub(in crate::diagnose) fn with_member(
    fitted: &Fitted,
    family: &Candidate,
    value: f64,
) -> Option<Candidate> {
    let (name, _) = family.selected.effect.shape.first()?;
    let mut selected = family.selected.clone();
    selected.member = [(name.clone(), value)].into();
    let place = family.place.as_ref().map(|place| place.at(value));
    let mut found = Vec::new();
    for (campaign, recipe) in fitted.recipes.iter().enumerate() {
        if let Ok(system) = recipe.with(std::slice::from_ref(&selected)) {
            let at = (campaign, fitted.recipes.len());
            join(&mut found, at, selected.clone(), place.clone(), system);
        }
    }
    found.pop()
}

/// The number of members that a family is scanned over, as it is paid for; `None` where it is not.
pub fn members(fitted: &Fitted, family: &Candidate) -> Option<usize> {
    let effect = &family.selected.effect;
    let (name, declared) = effect.shape.first().filter(|_| effect.shape.len() == 1)?;
    let Members::Range { .. } = declared.members else { return None };
    Some(Scan::new(fitted, family, name)?.tried(&declared.members)?.1)
}

/// Why no member of a family can be tested.
pub(in crate::diagnose) const ALL_BLIND: &str = "none of its frequencies can be told from nothing at the rates at which these runs are sampled: sample faster, or at uneven intervals";

/// The members of a family that the runs can tell from nothing.
pub(in crate::diagnose) fn told<'a>(
    problem: &Problem,
    family: &'a [Candidate],
) -> Vec<&'a Candidate> {
    let Some(first) = family.first().filter(|_| family.len() > 1) else {
        return family.iter().collect();
    };
    let shape = &first.selected.effect.shape;
    let frequencies: Vec<&String> =
        shape.iter().filter(|(_, one)| is_frequency(&one.unit)).map(|(name, _)| name).collect();
    if frequencies.is_empty() {
        return family.iter().collect();
    }
    let sampling = Sampling::of(problem);
    let is_blind = |one: &&Candidate| {
        let values = frequencies.iter().filter_map(|name| one.selected.member.get(*name));
        values.into_iter().any(|value| sampling.is_blind(*value))
    };
    family.iter().filter(|one| !is_blind(one)).collect()
}

fn is_frequency(unit: &Unit) -> bool {
    Unit::parse("Hz").is_ok_and(|hertz| unit.dimension == hertz.dimension)
}

/// A family whose constant is left open.
struct Scan<'a> {
    fitted: &'a Fitted,
    /// One program for each campaign that it fits: the columns of `TOGETHER` members alone and with the
    /// nominal ones, and those of one with them.
    alone: Vec<Signatures>,
    beside: Vec<Signatures>,
    single: Vec<Signatures>,
    nominal: Nominal,
    samples: usize,
    /// Of a family of frequencies, and the lowest of them.
    sampling: Option<(Sampling, f64)>,
}

/// The first part of the key of what holds together over a run.
const OF_RUN: usize = 2;

/// Sums of some members' columns that hold together: with themselves, with the nominal columns, with
/// what is left.
struct Group {
    key: (usize, usize),
    own: DMatrix<f64>,
    across: DMatrix<f64>,
    score: DVector<f64>,
}

type Factor = Cholesky<f64, nalgebra::Dyn>;

/// The factor of what is left of columns whose products are `own`. What others take up is nothing: the nominal
/// parameters, or another of the columns, as where all runs turn in the same sense; so is a column of zeros, as
/// where a signal stands still.
fn factor(mut left: DMatrix<f64>, own: &DMatrix<f64>) -> Option<Factor> {
    for i in 0..left.nrows() {
        if own[(i, i)] > 0.0 {
            left[(i, i)] += super::basis::RANK.powi(2) * own[(i, i)];
        } else {
            left[(i, i)] = 1.0;
        }
    }
    Cholesky::new(left)
}

impl<'a> Scan<'a> {
    fn new(fitted: &'a Fitted, family: &Candidate, name: &str) -> Option<Self> {
        let problem = &fitted.problem;
        let declared = family.selected.effect.shape.get(name)?;
        let lowest = match &declared.members {
            Members::List(list) => list.iter().copied().fold(f64::INFINITY, f64::min),
            Members::Range { from, .. } => *from,
        };
        let sampling = is_frequency(&declared.unit).then(|| (Sampling::of(problem), lowest));
        let selected = Selected {
            effect: opened(&family.selected.effect, name)?.into(),
            member: Default::default(),
            head: family.selected.head.clone(),
        };
        let (mut alone, mut beside, mut single) = (Vec::new(), Vec::new(), Vec::new());
        let numbers: Vec<String> = (0..TOGETHER).map(|number| number.to_string()).collect();
        for (part, recipe) in fitted.recipes.iter().enumerate() {
            let Ok(system) = recipe.with(std::slice::from_ref(&selected)) else { continue };
            let system: &System = &system;
            let all: Vec<Signed<'_>> = numbers.iter().map(|name| Signed { name, system }).collect();
            alone.push(Signatures::open(problem, part, &all, name, false));
            beside.push(Signatures::open(problem, part, &all, name, true));
            single.push(Signatures::open(problem, part, &all[..1], name, true));
        }
        let nominal = Nominal::of(&fitted.fit.normal)?;
        let runs = problem.parts.iter().flat_map(|part| &part.runs);
        let samples = runs.map(|run| run.record.len()).sum();
        Some(Self { fitted, alone, beside, single, nominal, samples, sampling })
    }

    /// Whether a member is a frequency that the runs cannot tell from nothing.
    fn is_blind(&self, member: f64) -> bool {
        self.sampling.as_ref().is_some_and(|(sampling, _)| sampling.is_blind(member))
    }

    /// Whether what values of a run's own say for a member says as much for a wave slower than all of the family.
    fn is_slow_in(&self, key: (usize, usize), member: f64) -> bool {
        let of_run = |(sampling, lowest): &(Sampling, f64)| {
            key.0 == OF_RUN && sampling.is_slow_in(key.1, member, *lowest)
        };
        self.sampling.as_ref().is_some_and(of_run)
    }

    /// Sums over runs of columns that hold together: over a campaign, a setup or a run; `across` members,
    /// too, if that is wanted.
    fn groups(&self, signatures: &Signatures, members: &[f64], across: bool) -> Vec<Group> {
        let problem = &self.fitted.problem;
        let part = signatures.part();
        let n = self.nominal.length.len();
        let mut groups: Vec<Group> = Vec::new();
        let grams = problem.gram_at(signatures, &self.fitted.fit.point, members, across);
        for (run, RunGram { gram, .. }) in grams.iter().enumerate() {
            let touched = problem.layout.columns.touched_by(problem.run_index(part, run));
            let k = gram.nrows() - 1 - touched.len();
            let key = match signatures.columns.first().map(|one| one.scope) {
                Some(Scope::Run) => (OF_RUN, problem.run_index(part, run)),
                Some(Scope::Setup) => (1, problem.parts[part].runs[run].setup),
                _ => (0, 0),
            };
            let at = groups.iter().position(|group| group.key == key).unwrap_or_else(|| {
                let own = DMatrix::zeros(k, k);
                groups.push(Group {
                    key,
                    own,
                    across: DMatrix::zeros(n, k),
                    score: DVector::zeros(k),
                });
                groups.len() - 1
            });
            let group = &mut groups[at];
            let first = touched.len();
            for j in 0..k {
                group.score[j] += gram[(gram.nrows() - 1, first + j)];
                for i in 0..k {
                    group.own[(i, j)] += gram[(first + i, first + j)];
                }
                for (place, column) in touched.iter().enumerate() {
                    group.across[(*column, j)] += gram[(place, first + j)];
                }
            }
        }
        groups
    }

    /// What each of at most `TOGETHER` members takes off the sum of squares while nominal parameters stand
    /// still.
    fn plain_gains(&self, members: &[f64]) -> Vec<f64> {
        let gain = |own: DMatrix<f64>, _: DMatrix<f64>, score: DVector<f64>| {
            factor(own.clone(), &own).map_or(0.0, |factor| score.dot(&factor.solve(&score)))
        };
        self.added(&self.alone, &filled(members), gain)[..members.len()].to_vec()
    }

    /// What each of at most `TOGETHER` members takes off the sum of squares.
    fn gains(&self, members: &[f64]) -> Vec<f64> {
        let gain = |own, across, score| self.gain_beyond(&own, &across, score);
        self.added(&self.beside, &filled(members), gain)[..members.len()].to_vec()
    }

    /// What a member takes off the sum of squares.
    fn gain(&self, member: f64) -> f64 {
        let gain = |own, across, score| self.gain_beyond(&own, &across, score);
        self.added(&self.single, &[member], gain)[0]
    }

    /// What each member gains, added up over everything that holds together; without the runs in which its wave is as
    /// much one slower than all of the family, where these say most of it.
    fn added(
        &self,
        programs: &[Signatures],
        members: &[f64],
        each: impl Fn(DMatrix<f64>, DMatrix<f64>, DVector<f64>) -> f64,
    ) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); members.len()];
        for Group { key, own, across, score } in
            programs.iter().flat_map(|one| self.groups(one, members, false))
        {
            let k = score.len() / members.len();
            for (member, (told, slow)) in sums.iter_mut().enumerate() {
                let is_slow = self.is_slow_in(key, members[member]);
                *(if is_slow { slow } else { told }) += each(
                    own.view((member * k, member * k), (k, k)).into_owned(),
                    across.columns(member * k, k).into_owned(),
                    score.rows(member * k, k).into_owned(),
                );
            }
        }
        // What does most where it is slow is something slow.
        sums.into_iter().map(|(told, slow)| if told < slow { told } else { told + slow }).collect()
    }

    /// What columns take off the sum of squares beyond the nominal parameters.
    fn gain_beyond(&self, own: &DMatrix<f64>, across: &DMatrix<f64>, score: DVector<f64>) -> f64 {
        let coupling = self.nominal.solve(across);
        let left = own - across.tr_mul(&coupling);
        let score = score - coupling.tr_mul(&self.nominal.score);
        factor(left, own).map_or(0.0, |factor| score.dot(&factor.solve(&score)))
    }

    /// Mean squared cosine between two members.
    fn alike(&self, a: f64, b: f64) -> f64 {
        let (mut sum, mut all) = (0.0, 0.0);
        for group in self.alone.iter().flat_map(|one| self.groups(one, &filled(&[a, b]), true)) {
            let k = group.own.nrows() / TOGETHER;
            let block = |i, j| group.own.view((i, j), (k, k)).into_owned();
            let (own, other) = (block(0, 0), block(k, k));
            let (Some(left), Some(right)) =
                (factor(own.clone(), &own), factor(other.clone(), &other))
            else {
                continue;
            };
            let cosines = |right: &Factor, products: DMatrix<f64>| {
                let half = left.l().solve_lower_triangular(&products)?;
                Some(right.l().solve_lower_triangular(&half.transpose())?.norm_squared())
            };
            // With itself it has as many cosines of one as directions.
            let (Some(between), Some(directions)) =
                (cosines(&right, block(0, k)), cosines(&left, own))
            else {
                continue;
            };
            sum += between;
            all += directions;
        }
        if all > 0.0 { sum / all } else { 1.0 }
    }

    /// The distance from a member to a neighbour, looked for up to `range` in a direction (1 or -1).
    fn step(&self, at: f64, direction: f64, range: f64) -> f64 {
        let (mut near, mut far) = (0.0, range);
        for _ in 0..HALVINGS {
            let middle = if near == 0.0 { 0.25 * far } else { (near * far).sqrt() };
            if self.alike(at, at + direction * middle) < NEIGHBOURS {
                far = middle;
            } else {
                near = middle;
            }
            if near > 0.0 && far / near < 1.2 {
                break;
            }
        }
        if near > 0.0 { near } else { far }
    }

    /// The members that are tried, and for how many they are paid for.
    fn tried(&self, members: &Members) -> Option<(Vec<f64>, usize)> {
        match members {
            Members::List(list) => Some((list.clone(), list.len())),
            Members::Range { from, to } => {
                let grid = self.grid(*from, *to)?;
                let paid = 2 * grid.len();
                Some((grid, paid))
            }
        }
    }

    /// The members of a range that are tried: steps are a power of the member between both ends.
    fn grid(&self, from: f64, to: f64) -> Option<Vec<f64>> {
        let range = to - from;
        let (first, last) = (self.step(from, 1.0, 0.5 * range), self.step(to, -1.0, 0.5 * range));
        let power = if from > 0.0 { (last / first).ln() / (to / from).ln() } else { 0.0 };
        let step = |value: f64| {
            if from > 0.0 { first * (value / from).powf(power) } else { first.min(last) }
        };
        let most = MOST.min(MOST_WORK / self.samples.max(1)).max(25);
        if !step(from).is_finite() || step(from) <= 0.0 {
            return None;
        }
        let mut coarse = 1.0;
        loop {
            let step = |value: f64| coarse * step(value);
            if let Some(grid) = spaced((from, to), most, step, |value| self.is_blind(value)) {
                return (!grid.is_empty()).then_some(grid);
            }
            coarse *= 1.5;
        }
    }

    /// The best value between two members about the best one.
    fn polished(&self, mut low: f64, mut high: f64, best: (f64, f64)) -> f64 {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let mut best = best;
        let mut try_at = |value: f64| {
            let gain = if self.is_blind(value) { 0.0 } else { self.gain(value) };
            if gain > best.1 {
                best = (value, gain);
            }
            gain
        };
        let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_a, mut at_b) = (try_at(a), try_at(b));
        for _ in 0..POLISH {
            if at_a > at_b {
                (high, b, at_b) = (b, a, at_a);
                a = high - golden * (high - low);
                at_a = try_at(a);
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = low + golden * (high - low);
                at_b = try_at(b);
            }
        }
        best.0
    }
}

/// As many members as one pass takes, the last repeated.
fn filled(members: &[f64]) -> Vec<f64> {
    let last = members.last().copied().unwrap_or(1.0);
    (0..TOGETHER).map(|number| members.get(number).copied().unwrap_or(last)).collect()
}

/// The effect with its family as a constant whose value can be given.
fn opened(effect: &Effect, family: &str) -> Option<Effect> {
    let mut effect = effect.clone();
    let declared = effect.shape.shift_remove(family)?;
    let mut constant = effect.parameters.first()?.clone();
    constant.name = family.to_owned();
    constant.unit = declared.unit;
    constant.per_measurand = false;
    constant.setting = crate::model::Setting::new(Scope::Instrument);
    constant.setting.fixed = true;
    constant.setting.value = Some(vec![declared.members.default_member()]);
    effect.parameters.push(constant);
    Some(effect)
}

/// The members of a range so far apart that are not blind; `None` where there are more than `most`.
fn spaced(
    (from, to): (f64, f64),
    most: usize,
    step: impl Fn(f64) -> f64,
    is_blind: impl Fn(f64) -> bool,
) -> Option<Vec<f64>> {
    let (mut value, mut grid) = (from, Vec::new());
    while value < to {
        if !is_blind(value) {
            grid.push(value);
        }
        if grid.len() >= most {
            return None;
        }
        value += step(value);
    }
    grid.extend((!is_blind(to)).then_some(to));
    Some(grid)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A signal that stands still has a column of zeros, and one that always turns in one sense two that are the
    /// same; what the others do is seen all the same.
    #[test]
    fn columns_of_zeros_and_the_same_ones_take_nothing() {
        let own = DMatrix::from_row_slice(3, 3, &[4.0, 4.0, 0.0, 4.0, 4.0, 0.0, 0.0, 0.0, 0.0]);
        let score = DVector::from_row_slice(&[6.0, 6.0, 0.0]);
        let gain = factor(own.clone(), &own).map(|factor| score.dot(&factor.solve(&score)));
        assert!(gain.is_some_and(|gain| (gain - 9.0).abs() < 1e-3), "{gain:?}");
    }

    /// Blind members do not make a scan that stops short look whole.
    #[test]
    fn a_range_is_scanned_to_its_end_or_more_coarsely() {
        let blind = |value: f64| value < 5.0;
        assert_eq!(
            spaced((0.0, 10.0), 8, |_| 1.0, blind),
            Some(vec![5.0, 6.0, 7.0, 8.0, 9.0, 10.0])
        );
        assert_eq!(spaced((0.0, 10.0), 5, |_| 1.0, blind), None);
        assert_eq!(spaced((0.0, 10.0), 8, |_| 1.0, |_| false), None);
        assert_eq!(
            spaced((0.0, 10.0), 8, |_| 2.5, |_| false),
            Some(vec![0.0, 2.5, 5.0, 7.5, 10.0])
        );
    }
}
