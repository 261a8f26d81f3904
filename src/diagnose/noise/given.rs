//! What campaigns give before their noise is judged, to which it is put back.

use crate::campaign::Run;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{LeftOut, Lost, Noise};
use crate::diagnose::stage::Stage;
use crate::engine::Problem;
use crate::estimate::batch::{FitError, Options};
use crate::system::Selected;

/// What the campaigns give.
#[derive(Clone, Debug)]
pub struct Given {
    /// Their runs with every reading.
    pub whole: Vec<Vec<Run>>,
    /// The uncertainties that they state.
    pub stated: Vec<Vec<f64>>,
    /// Stretches of lost samples, left out already.
    pub lost: Vec<Lost>,
    /// What is gross, left out already.
    pub gross: LeftOut,
}

impl Given {
    /// What a problem's campaigns give.
    pub fn of(problem: &Problem) -> Self {
        Self {
            whole: problem.parts.iter().map(|part| part.runs.clone()).collect(),
            stated: problem.parts.iter().map(|part| part.sigma.clone()).collect(),
            lost: Vec::new(),
            gross: LeftOut::default(),
        }
    }

    /// Noise of which nothing is known but what was left out already.
    pub(super) fn noise(&self) -> Noise {
        Noise { left_out: self.gross.clone(), ..Noise::default() }
    }

    /// What is given, with one more selected effect in the place of the noise that was found
    /// without it.
    pub(super) fn anew(
        &self,
        stage: &Stage,
        noise: &Noise,
        selected: &Selected,
        options: &Options,
    ) -> Result<Option<Fitted>, FitError> {
        let mut fitted = stage.fitted.clone();
        self.put_into(&mut fitted.problem);
        fitted.without(&noise.selected(), options)?.with(selected, &[], options)
    }

    /// Puts the runs with every reading and the stated uncertainties back.
    pub(in crate::diagnose) fn put_into(&self, problem: &mut Problem) {
        for (part, (runs, stated)) in
            problem.parts.iter_mut().zip(self.whole.iter().zip(&self.stated))
        {
            part.runs.clone_from(runs);
            part.sigma.clone_from(stated);
            part.gauss_markov.fill(None);
            part.run_levels.clear();
        }
    }
}
