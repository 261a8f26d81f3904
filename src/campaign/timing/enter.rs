//! The timing chain as an effect of the model, so that every estimate takes account of it.
//!
//! `t = t + offset + error`: the offset is one unknown of the rig with prior knowledge, zero with
//! the chain's common uncertainty, and so a common part of every delay; the error is random, new in
//! every sample and shared by its readings through the derivatives, as an input's error is.

use crate::campaign::timing::RunTiming;
use crate::campaign::timing::Timing;
use crate::campaign::timing::chain::part;
use crate::diagnostic::Source;
use crate::model::Override;
use crate::units::{Dimension, Unit};

/// The name of the effect.
pub const EFFECT: &str = "time_referencing";

impl Timing {
    /// The effect's declaration.
    pub fn effect(&self) -> Source {
        // An error of the clock's resolution alone is rectangular.
        let shape = if self.jitter.is_none() { "uniform" } else { "normal" };
        let text = format!(
            r#"name  = "{EFFECT}"
title = "Reference times are known to the timing chain's uncertainty"
acts  = "timing"
about = "From [timing] of the campaign; the offset is absorbed by the delays and widens each."

[parameters]
offset = {{ unit = "s", typical = "100 ns", scope = "rig" }}
error  = {{ unit = "s", typical = "10 ns", scope = "sample", shape = "{shape}" }}

[patch]
t = 't + offset + error'
"#
        );
        Source::new("[timing]", text)
    }

    /// What the chain says of the effect's parameters.
    pub fn overrides<'a>(&self, runs: impl IntoIterator<Item = &'a RunTiming>) -> [Override; 2] {
        let chain = self.chain(runs);
        let said = |seconds: f64| Some(vec![(seconds, Unit::coherent(Dimension::TIME))]);
        let common = part(&chain, true);
        let offset = Override {
            name: format!("{EFFECT}.offset"),
            value: said(0.0),
            sigma: if common > 0.0 { said(common) } else { None },
            fixed: Some(common == 0.0),
            ..Override::default()
        };
        let error = Override {
            name: format!("{EFFECT}.error"),
            value: said(part(&chain, false)),
            fixed: Some(true),
            ..Override::default()
        };
        [offset, error]
    }
}
