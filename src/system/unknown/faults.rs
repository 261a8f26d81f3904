//! What is wrong with an unknown, now that everything is stated of it.

use super::{Origin, Unknown};
use crate::diagnostic::Diagnostic;
use crate::graph::{Kind, Scope};
use crate::model::Component;
use crate::model::component::AXES;
use crate::system::needs::is_random;

impl Unknown {
    /// What is wrong with it, or with what is said of it in single setups, now that everything is
    /// said.
    pub(in crate::system) fn fault(&self) -> Option<Diagnostic> {
        let is_constant = self.setting.fixed && self.declared.effect.is_some();
        if let Some((_, own)) = self.of_setups.first().filter(|_| is_constant) {
            let message =
                format!("`{}` is a constant of an effect, the same in all setups", self.name);
            let error = Diagnostic::error(message).help("state it in [parameters]");
            return Some(error.at_maybe(own.place.as_ref()));
        }
        if let Some((_, own)) = self.of_setups.first().filter(|_| self.setting.sum_zero) {
            let message = format!("the values of `{}` sum to zero over the setups", self.name);
            let help = "none of them can be stated alone";
            return Some(Diagnostic::error(message).help(help).at_maybe(own.place.as_ref()));
        }
        if let (Some((_, own)), false) =
            (self.of_setups.first(), self.setting.scope == Scope::Setup)
        {
            let message = format!("`{}` has no value of its own in each setup", self.name);
            let help = "state it in [parameters]; there scope = \"setup\" gives it one in each";
            return Some(Diagnostic::error(message).help(help).at_maybe(own.place.as_ref()));
        }
        self.fault_here().or_else(|| self.of_setups.iter().find_map(|(_, own)| own.fault_here()))
    }

    fn fault_here(&self) -> Option<Diagnostic> {
        let (name, setting) = (&self.name, &self.setting);
        let error = |message: String, help: &str| {
            let error = Diagnostic::error(message);
            let error = if help.is_empty() { error } else { error.help(help) };
            Some(error.at_maybe(self.place.as_ref()))
        };
        if setting.linear_range.or(setting.simulated_at).is_some()
            && (self.origin != Origin::Declared || self.kind != Kind::Scalar)
        {
            return error(
                format!(
                    "`{name}` has `linear_range` or `simulated_at` and is no scalar that is declared"
                ),
                "they belong to parameters of which streams were computed, such as a simulator's",
            );
        }
        if is_random(setting.scope) {
            if self.kind != Kind::Scalar {
                return error(
                    format!("`{name}` is random (scope = \"sample\") and not a scalar"),
                    "only scalars can be random",
                );
            }
            if setting.sum_zero {
                return error(
                    format!("`{name}` is random: its mean is zero anyway"),
                    "leave out `sum`",
                );
            }
            if self.origin != Origin::InputError
                && setting.value.is_some()
                && setting.sigma.is_some()
            {
                return error(
                    format!(
                        "`{name}` is random and has one standard deviation, not `value` and `sigma`"
                    ),
                    "give its standard deviation as `value`",
                );
            }
            if self.standard_deviation().is_some_and(|sigma| sigma < 0.0) {
                return error(format!("`{name}`: a standard deviation cannot be negative"), "");
            }
            return None;
        }
        if let Some(fault) = self.fault_of_components() {
            return Some(fault.at_maybe(self.place.as_ref()));
        }
        if setting.fixed && setting.value.is_none() {
            let unit = if self.unit.symbol == "1" { "" } else { self.unit.symbol.as_str() };
            let quantity = |number: u8| format!("\"{}\"", format!("{number} {unit}").trim_end());
            let example = match self.kind {
                Kind::Scalar => quantity(1),
                _ => format!("[{0}, {0}, {0}]", quantity(0)),
            };
            let help = format!("\"{name}\" = {{ value = {example}, fixed = true }}");
            return error(format!("`{name}` is fixed, but at no stated value"), &help);
        }
        if setting.sigma.is_some() && setting.value.is_none() {
            return error(
                format!("`{name}` has a standard uncertainty, but no value"),
                "`sigma` is the standard uncertainty of `value`",
            );
        }
        if let (Some(lower), Some(upper)) = (&setting.lower, &setting.upper)
            && lower.iter().zip(upper).any(|(lower, upper)| lower >= upper)
        {
            return error(format!("`{name}`: `lower` must be below `upper`"), "");
        }
        None
    }

    /// What is wrong with what is said of single components.
    fn fault_of_components(&self) -> Option<Diagnostic> {
        let setting = &self.setting;
        let all = setting.components.as_ref()?;
        if setting.sum_zero {
            let message = format!("the values of `{}` sum to zero over their scope", self.name);
            return Some(Diagnostic::error(message).help("no component can be stated by itself"));
        }
        let fault = |(component, own): (usize, &Component)| {
            let name = format!("{}.{}", self.name, AXES[component]);
            let (lower, upper) = setting.bounds_of(component);
            if own.fixed == Some(true) && setting.value_of(component).is_none() {
                let help = format!(
                    "\"{name}\" = {{ value = \"{}\", fixed = true }}",
                    format!("0 {}", self.unit.symbol).trim_end_matches(" 1")
                );
                let message = format!("`{name}` is fixed, but at no stated value");
                Some(Diagnostic::error(message).help(help))
            } else if own.sigma.is_some() && setting.value_of(component).is_none() {
                let message = format!("`{name}` has a standard uncertainty, but no value");
                Some(
                    Diagnostic::error(message)
                        .help("`sigma` is the standard uncertainty of `value`"),
                )
            } else if lower >= upper {
                Some(Diagnostic::error(format!("`{name}`: `lower` must be below `upper`")))
            } else {
                None
            }
        };
        all.iter().enumerate().find_map(fault)
    }
}
