//! The same readings and weights with a model that grows by one row after the other:
//! what each of them contributes.

use crate::diagnose::fitted::Fitted;
use crate::estimate::batch::{FitError, Options};
use crate::system::Selected;

/// Models from the nominal one to the one with every row.
#[derive(Clone, Debug)]
pub struct Steps {
    /// Without the effects.
    pub nominal: Fitted,
    /// Each effect with the model that has it and those before it.
    pub with: Vec<(String, Fitted)>,
}

impl Steps {
    /// Those of a model in which some effects are rows, in this order.
    ///
    /// # Errors
    /// [`FitError`] where a model cannot be fitted at all.
    pub fn of(whole: &Fitted, effects: &[Selected], options: &Options) -> Result<Self, FitError> {
        let selected: Vec<&Selected> = effects.iter().collect();
        let upto = |count: usize| match &selected[count..] {
            [] => Ok(whole.clone()),
            later => whole.without(later, options),
        };
        let with =
            effects.iter().enumerate().map(|(number, one)| Ok((one.name(), upto(number + 1)?)));
        Ok(Self { nominal: upto(0)?, with: with.collect::<Result<_, FitError>>()? })
    }

    /// With every effect.
    pub fn last(&self) -> &Fitted {
        self.with.last().map_or(&self.nominal, |(_, fitted)| fitted)
    }
}
