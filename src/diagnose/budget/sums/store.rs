//! The products of columns in the readings of one measurand: those of wide columns once, those of
//! narrow ones by run.
//!
//! Most columns change the readings of one measurand alone; a store has places for those that change
//! its own. Which columns there are, and where they act, is not its business.

use nalgebra::DMatrix;

use crate::diagnose::evidence::columns::shared;
use crate::engine::Problem;
use crate::engine::gram::PartGram;
use crate::engine::signatures::Signatures;

/// Number of the residual among wide columns.
pub(super) const RESIDUAL: usize = 0;

/// Where a column stands.
#[derive(Clone, Debug)]
pub(super) enum Placed {
    /// Its number.
    Wide(usize),
    /// Its number, and its number among the narrow columns of which runs.
    Narrow(usize, Vec<(usize, usize)>),
}

/// Places of some of many numbers, in the order in which they come.
#[derive(Clone, Debug, Default)]
pub struct Index {
    places: Vec<Option<u32>>,
    numbers: Vec<usize>,
}

impl Index {
    /// The place of a number that has one.
    #[inline]
    pub fn get(&self, number: usize) -> Option<usize> {
        self.places.get(number).copied().flatten().map(|place| place as usize)
    }

    /// The place of a number, the next one if it has none.
    pub fn place(&mut self, number: usize) -> usize {
        if self.places.len() <= number {
            self.places.resize(number + 1, None);
        }
        if self.places[number].is_none() {
            self.numbers.push(number);
        }
        *self.places[number].get_or_insert(self.numbers.len() as u32 - 1) as usize
    }

    /// The numbers that have a place, in their order.
    pub fn numbers(&self) -> &[usize] {
        &self.numbers
    }
}

/// Sums of products.
#[derive(Clone, Debug)]
pub(super) struct Store {
    /// Wide columns and the residual.
    wide_at: Index,
    wide: DMatrix<f64>,
    narrow_at: Index,
    /// Of narrow columns (one a column) with the wide ones and the residual.
    strips: DMatrix<f64>,
    /// Of the narrow columns of each run.
    runs: Vec<(Index, DMatrix<f64>)>,
}

impl Store {
    /// Of so many runs.
    pub(super) fn empty(runs: usize) -> Self {
        let none = || DMatrix::zeros(0, 0);
        let (wide_at, narrow_at) = (Index::default(), Index::default());
        let runs = (0..runs).map(|_| (Index::default(), none())).collect();
        let mut store = Self { wide_at, wide: none(), narrow_at, strips: none(), runs };
        store.wide_at.place(RESIDUAL);
        store.grow();
        store
    }

    /// Makes room for all columns that have a place.
    fn grow(&mut self) {
        let (wide, narrow) = (self.wide_at.numbers.len(), self.narrow_at.numbers.len());
        if self.wide.nrows() < wide {
            self.wide.resize_mut(wide, wide, 0.0);
        }
        if self.strips.shape() != (wide, narrow) {
            self.strips.resize_mut(wide, narrow, 0.0);
        }
    }

    /// Adds the Gram matrix of a run; `columns` has the column in each place of it, the residual
    /// last.
    pub(super) fn add_run(
        &mut self,
        gram: &PartGram,
        run: usize,
        columns: &[usize],
        place: &[Placed],
    ) {
        let (mut wide, mut narrow) = (Vec::new(), Vec::new());
        for (here, at) in gram.places.iter().enumerate() {
            let Some(column) = columns.get(*at) else {
                wide.push((here, self.wide_at.place(RESIDUAL)));
                continue;
            };
            match place.get(*column) {
                Some(Placed::Wide(number)) => wide.push((here, self.wide_at.place(*number))),
                Some(Placed::Narrow(number, runs)) => {
                    if let Ok(found) = runs.binary_search_by_key(&run, |(run, _)| *run) {
                        let own = self.runs[run].0.place(runs[found].1);
                        narrow.push((here, self.narrow_at.place(*number), own));
                    }
                }
                None => {}
            }
        }
        self.grow();
        let (at, own) = &mut self.runs[run];
        if own.nrows() < at.numbers.len() {
            own.resize_mut(at.numbers.len(), at.numbers.len(), 0.0);
        }
        for (here, at) in &wide {
            let from = gram.gram.column(*here);
            let mut to = self.wide.column_mut(*at);
            wide.iter().for_each(|(other, there)| to[*there] += from[*other]);
        }
        for (here, number, at) in &narrow {
            let from = gram.gram.column(*here);
            let mut to = self.strips.column_mut(*number);
            wide.iter().for_each(|(other, there)| to[*there] += from[*other]);
            let mut to = own.column_mut(*at);
            narrow.iter().for_each(|(other, _, there)| to[*there] += from[*other]);
        }
    }

    /// Adds products of a wide column with itself and others.
    pub(super) fn add_wide<'a>(
        &mut self,
        number: usize,
        square: f64,
        others: impl Iterator<Item = (Option<&'a Placed>, f64)>,
    ) {
        let at = self.wide_at.place(number);
        self.grow();
        self.wide[(at, at)] += square;
        for (other, product) in others.filter(|(_, product)| *product != 0.0) {
            let number = match other {
                None => RESIDUAL,
                Some(Placed::Wide(number)) => *number,
                Some(Placed::Narrow(number, _)) => {
                    let place = self.narrow_at.place(*number);
                    self.grow();
                    self.strips[(at, place)] += product;
                    continue;
                }
            };
            let place = self.wide_at.place(number);
            self.grow();
            self.wide[(at, place)] += product;
            self.wide[(place, at)] += product;
        }
    }

    /// Whether a column changes readings of this measurand.
    pub(super) fn has(&self, column: &Placed) -> bool {
        let place = match column {
            Placed::Wide(number) => self.wide_at.get(*number),
            Placed::Narrow(number, _) => self.narrow_at.get(*number),
        };
        place.is_some()
    }

    /// The product of two columns; none is the residual.
    #[inline]
    pub(super) fn product(&self, a: Option<&Placed>, b: Option<&Placed>) -> f64 {
        let wide = |one: Option<&Placed>| match one {
            None => Some(RESIDUAL),
            Some(Placed::Wide(number)) => Some(*number),
            Some(Placed::Narrow(..)) => None,
        };
        let found = match (a, b) {
            (Some(Placed::Narrow(_, a)), Some(Placed::Narrow(_, b))) => {
                return self.product_in_runs(a, b);
            }
            (Some(Placed::Narrow(narrow, _)), other) | (other, Some(Placed::Narrow(narrow, _))) => {
                let row = wide(other).and_then(|number| self.wide_at.get(number));
                row.zip(self.narrow_at.get(*narrow)).and_then(|at| self.strips.get(at))
            }
            _ => {
                let at = |one| wide(one).and_then(|number| self.wide_at.get(number));
                at(a).zip(at(b)).and_then(|at| self.wide.get(at))
            }
        };
        found.copied().unwrap_or(0.0)
    }

    /// The product of two narrow columns, over the runs in which both act.
    fn product_in_runs(&self, a: &[(usize, usize)], b: &[(usize, usize)]) -> f64 {
        let product = |(run, i, j): (usize, usize, usize)| {
            let (at, own) = &self.runs[run];
            Some(own[(at.get(i)?, at.get(j)?)])
        };
        shared(a, b).filter_map(product).sum()
    }
}

/// The columns that each run's Gram matrix has, the residual's place left out.
pub(super) fn columns_of_runs(
    problem: &Problem,
    signed: &[Signatures],
    at: &[Vec<(usize, usize)>],
) -> Vec<Vec<usize>> {
    let nominal = problem.layout.columns.len();
    let (mut all, mut first): (Vec<Vec<usize>>, Vec<usize>) = (Vec::new(), Vec::new());
    for (part, signatures) in signed.iter().enumerate() {
        for run in 0..problem.parts[part].runs.len() {
            let mut columns = problem.layout.columns.touched_by(problem.run_index(part, run));
            first.push(columns.len());
            columns.resize(columns.len() + signatures.columns.len(), usize::MAX);
            all.push(columns);
        }
    }
    for (number, at) in at.iter().enumerate() {
        for (run, index) in at {
            all[*run][first[*run] + index] = nominal + number;
        }
    }
    all
}

/// Wide and narrow columns, and which the narrow ones are in each run; the number of wide ones and
/// the residual.
pub(super) fn placed(
    problem: &Problem,
    at: &[Vec<(usize, usize)>],
    runs: usize,
) -> (Vec<Placed>, usize) {
    let nominal = problem.layout.columns.len();
    let mut acts: Vec<Vec<usize>> = vec![Vec::new(); nominal];
    for run in 0..runs {
        for column in problem.layout.columns.touched_by(run) {
            acts[column].push(run);
        }
    }
    acts.extend(at.iter().map(|at| at.iter().map(|(run, _)| *run).collect()));
    let (mut wide, mut narrow) = (RESIDUAL + 1, 0);
    let mut next = vec![0; runs];
    let place = |runs_of: &Vec<usize>| {
        if runs_of.len() * 2 > runs {
            wide += 1;
            return Placed::Wide(wide - 1);
        }
        narrow += 1;
        let mut own = Vec::with_capacity(runs_of.len());
        for run in runs_of {
            own.push((*run, next[*run]));
            next[*run] += 1;
        }
        own.sort_unstable();
        Placed::Narrow(narrow - 1, own)
    };
    let placed = acts.iter().map(place).collect();
    (placed, wide)
}
