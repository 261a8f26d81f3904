//! Lays what a campaign says of a parameter over what its declaration says.

use crate::model::{Override, Setting};
use crate::units::Unit;

impl Override {
    /// Changes a setting where this says something. Units are not looked at: see [`Self::check`].
    ///
    /// A stated `sigma` makes a fixed parameter free with prior knowledge, and `fixed = true` drops
    /// prior knowledge, unless this says both, which reading refuses.
    pub fn apply(&self, setting: &mut Setting) {
        let set = |place: &mut Option<Vec<f64>>, said: &Option<Vec<(f64, Unit)>>| {
            if let Some(said) = said {
                *place = Some(said.iter().map(|(value, _)| *value).collect());
            }
        };
        setting.forget_components(self);
        if self.free {
            (setting.value, setting.sigma, setting.fixed) = (None, None, false);
        }
        set(&mut setting.value, &self.value);
        set(&mut setting.sigma, &self.sigma);
        if self.sigma.is_some() {
            setting.degrees_of_freedom = self.degrees_of_freedom;
        }
        set(&mut setting.lower, &self.lower);
        set(&mut setting.upper, &self.upper);
        if self.value.is_some() {
            // What is known now says better where to start than what was assumed before.
            setting.start = None;
        }
        set(&mut setting.start, &self.start);
        if let Some((plausible, _)) = &self.plausible {
            setting.plausible = Some(*plausible);
        }
        let one = |said: &Option<(f64, Unit)>| said.as_ref().map(|(value, _)| *value);
        setting.linear_range = one(&self.linear_range).or(setting.linear_range);
        setting.simulated_at = one(&self.simulated_at).or(setting.simulated_at);
        match self.fixed {
            Some(true) => setting.sigma = None,
            None if self.sigma.is_some() => setting.fixed = false,
            _ => {}
        }
        setting.fixed = self.fixed.unwrap_or(setting.fixed);
        setting.scope = self.scope.unwrap_or(setting.scope);
        setting.sum_zero = self.sum_zero.unwrap_or(setting.sum_zero);
    }

    /// The keys of a setting that this states.
    pub fn keys(&self) -> impl Iterator<Item = &'static str> {
        let keys = [
            ("value", self.value.is_some()),
            ("sigma", self.sigma.is_some()),
            ("lower", self.lower.is_some()),
            ("upper", self.upper.is_some()),
            ("start", self.start.is_some()),
            ("plausible", self.plausible.is_some()),
            ("linear_range", self.linear_range.is_some()),
            ("simulated_at", self.simulated_at.is_some()),
            ("fixed", self.fixed.is_some()),
            ("scope", self.scope.is_some()),
            ("sum", self.sum_zero.is_some()),
        ];
        keys.into_iter().filter(|(_, is_stated)| *is_stated).map(|(key, _)| key)
    }

    /// What is wrong with this for a parameter of `count` components and unit `unit`: message,
    /// help.
    pub fn check(&self, count: usize, unit: &Unit) -> Option<(String, String)> {
        let lists = [
            ("value", &self.value, false),
            ("sigma", &self.sigma, true),
            ("lower", &self.lower, false),
            ("upper", &self.upper, false),
            ("start", &self.start, false),
        ];
        let name = &self.name;
        for (key, said, width) in lists {
            let Some(said) = said else { continue };
            if said.len() != count {
                let expected = if count == 1 { "one quantity" } else { "a list of three" };
                let message = format!("`{key}` of `{name}` must be {expected}");
                return Some((message, format!("write {}", self.example(key, count, unit))));
            }
            if let Some(fault) = said.iter().find_map(|said| self.check_one(key, said, unit, width))
            {
                return Some(fault);
            }
        }
        let single = [
            ("plausible", &self.plausible, true),
            ("linear_range", &self.linear_range, true),
            ("simulated_at", &self.simulated_at, false),
        ];
        single.into_iter().find_map(|(key, said, width)| {
            let said = said.as_ref()?;
            if count > 1 && key != "plausible" {
                let message =
                    format!("`{key}` of `{name}`: only a scalar is a simulator's parameter");
                return Some((message, "leave it out".to_owned()));
            }
            self.check_one(key, said, unit, width)
        })
    }

    /// How a key is written: in a file, or on the command line, where lists have no brackets.
    fn example(&self, key: &str, count: usize, unit: &Unit) -> String {
        let each = format!("1 {}", unit.symbol).trim_end_matches(" 1").to_owned();
        let each = vec![each; count];
        if self.place.is_none() {
            let option = if key == "start" { "--start" } else { "--set" };
            return format!("{option} {}=\"{}\"", self.name, each.join(","));
        }
        let quoted: Vec<String> = each.iter().map(|one| format!("\"{one}\"")).collect();
        match count {
            1 => format!("{key} = {}", quoted.concat()),
            _ => format!("{key} = [{}]", quoted.join(", ")),
        }
    }

    fn check_one(
        &self,
        key: &str,
        (value, found): &(f64, Unit),
        unit: &Unit,
        width: bool,
    ) -> Option<(String, String)> {
        let name = &self.name;
        if found.symbol == "1" && !unit.accepts(found) {
            let message = format!("`{key}` of `{name}` has no unit");
            return Some((message, format!("write its unit, such as `{}`", unit.symbol)));
        }
        if unit.misses(found) {
            let message =
                format!("`{key}` of `{name}` has the unit `{}`, without an angle", found.symbol);
            return Some((message, format!("write its unit, such as `{}`", unit.symbol)));
        }
        if found.dimension != unit.dimension {
            let (expected, help) = if unit.symbol == "1" {
                ("a plain number".to_owned(), "write it without a unit, or in `ppm`".to_owned())
            } else {
                (
                    format!("a quantity like `{}`", unit.symbol),
                    format!("write it in {}", unit.symbol),
                )
            };
            let symbol = &found.symbol;
            let message =
                format!("`{key}` of `{name}` must be {expected}, found the unit `{symbol}`");
            return Some((message, help));
        }
        if width && found.offset != 0.0 {
            let message = format!("`{key}` of `{name}` is a difference of temperatures");
            return Some((message, "write it in K".to_owned()));
        }
        if !value.is_finite() || (width && *value <= 0.0) {
            return Some((format!("`{key}` of `{name}` must be greater than zero"), String::new()));
        }
        None
    }
}
