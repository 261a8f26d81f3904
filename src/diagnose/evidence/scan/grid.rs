//! Which members of a family are tried: a list as it stands, or a range so finely that none is
//! missed.

use crate::effect::Members;

use super::{Scan, TOGETHER};

/// Squared cosine between the signatures of neighbours.
pub(super) const NEIGHBOURS: f64 = 0.4;
/// Members at most.
const MOST: usize = 2_000;
/// Members of a list that are always tried.
const SHORT_LIST: usize = 50;
/// Member times sample at most: longer campaigns are scanned more coarsely, lists not to their end.
const MOST_WORK: usize = 20_000_000;
/// Passes in search of the size of a step, and how much shorter each distance is that is tried.
const STEPS: i32 = 3;
const SHORTER: f64 = 0.25;

/// Which members are tried.
pub(super) struct Tried {
    pub(super) members: Vec<f64>,
    /// For how many they are paid for.
    pub(super) paid: usize,
    /// Whether a grid that misses none has more.
    pub(super) is_coarse: bool,
}

impl Scan<'_> {
    /// The distance from a member to a neighbour, looked for up to `range` in a direction (1 or
    /// -1).
    fn step(&self, at: f64, direction: f64, range: f64) -> f64 {
        let is_near = |distances: &[f64]| -> Vec<bool> {
            let others: Vec<f64> = distances.iter().map(|far| at + direction * far).collect();
            self.alike(at, &others).into_iter().map(|alike| alike >= NEIGHBOURS).collect()
        };
        let tried = TOGETHER as i32 - 1;
        let mut near = range * SHORTER.powi(STEPS * tried);
        for pass in 0..STEPS {
            let ladder: Vec<f64> =
                (1..=tried).map(|rung| range * SHORTER.powi(pass * tried + rung)).collect();
            if let Some(first) = is_near(&ladder).iter().position(|near| *near) {
                near = ladder[first];
                break;
            }
        }
        let part = SHORTER.powf(-1.0 / f64::from(tried + 1));
        let between: Vec<f64> = (1..=tried).map(|rung| near * part.powi(rung)).collect();
        let nearer = is_near(&between).into_iter().take_while(|near| *near).count();
        if nearer > 0 { between[nearer - 1] } else { near }
    }

    /// The members that are tried.
    pub(super) fn tried(&self) -> Option<Tried> {
        match self.members {
            Members::List(list) => {
                let most = self.most().max(SHORT_LIST).min(list.len());
                Some(Tried { members: list[..most].to_vec(), paid: most, is_coarse: false })
            }
            Members::Range { from, to } => self.grid(*from, *to),
        }
    }

    /// How many members may be tried.
    fn most(&self) -> usize {
        MOST.min(MOST_WORK / self.samples.max(1))
    }

    /// The members of a range that are tried: steps are a power of the member between both ends.
    pub(super) fn grid(&self, from: f64, to: f64) -> Option<Tried> {
        let range = to - from;
        let (first, last) = (self.step(from, 1.0, 0.5 * range), self.step(to, -1.0, 0.5 * range));
        let power = if from > 0.0 { (last / first).ln() / (to / from).ln() } else { 0.0 };
        let step = |value: f64| {
            if from > 0.0 { first * (value / from).powf(power) } else { first.min(last) }
        };
        let most = self.most().max(25);
        if !step(from).is_finite() || step(from) <= 0.0 {
            return None;
        }
        let mut by = 1.0;
        loop {
            let step = |value: f64| by * step(value);
            if let Some(members) = spaced((from, to), most, step, |value| self.is_blind(value)) {
                // Each is paid for two times: the best is polished.
                let paid = 2 * (by * members.len() as f64) as usize;
                let is_coarse = by > 1.0;
                return (!members.is_empty()).then_some(Tried { members, paid, is_coarse });
            }
            by *= 1.5;
        }
    }

    /// As many members from the low end of a range on as may be tried, so near to each other that none
    /// between them is missed.
    pub(super) fn first_of(&self, from: f64, to: f64) -> Vec<f64> {
        let step = self.step(from, 1.0, 0.5 * (to - from));
        if step <= 0.0 || !step.is_finite() {
            return Vec::new();
        }
        let all = (0..self.most()).map(|number| from + number as f64 * step);
        all.take_while(|value| *value <= to).filter(|value| !self.is_blind(*value)).collect()
    }
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
