//! Stated values that are wrong, as terms: a column that acts in the equations of a parameter's prior
//! alone, so that the readings decide the value.
//!
//! What is stated and fixed has no equation: it is not tried here.

use super::linear::Linear;
use super::sums::Appended;
use super::terms::Term;
use crate::diagnose::library::place::Place;

impl Linear {
    /// Adds for each parameter with stated values the term that they are wrong.
    pub(super) fn with_stated_values(&mut self) {
        let layout = &self.fitted.problem.layout;
        let mut of_priors: Vec<(usize, Vec<usize>)> = Vec::new();
        for (row, prior) in self.sums.priors.iter().enumerate() {
            let acts = |column: usize| prior.coefficients.iter().any(|(own, _)| *own == column);
            let own = (0..layout.instances.len()).find(|instance| {
                let mut columns = layout.own_columns(*instance);
                columns.any(|(_, column)| acts(column))
            });
            let Some(instance) = own else { continue };
            match of_priors.iter_mut().find(|(known, _)| *known == instance) {
                Some((_, rows)) => rows.push(row),
                None => of_priors.push((instance, vec![row])),
            }
        }
        for (instance, rows) in of_priors {
            let one = &self.fitted.problem.layout.instances[instance];
            let place = Place::of_stated(&one.name, one.whose());
            let (name, mut columns) = (place.words.clone(), Vec::new());
            for row in rows {
                let column = self.sums.append(&Appended::default());
                self.sums.priors[row].coefficients.push((column, 1.0));
                columns.push(vec![(column, 1.0)]);
            }
            self.terms.push(Term::new(name, Some(place), columns));
        }
    }
}
