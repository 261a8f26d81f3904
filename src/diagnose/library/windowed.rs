//! A block that acts from a sample of a run on, as an effect that can be fitted: a clock that was set by
//! seconds, a large knock. The change point itself is linear (`budget::changes`).

use std::sync::Arc;

use crate::diagnostic::Source;
use crate::effect::{Effect, Target};
use crate::formula::isolate::replaced;
use crate::formula::parser::parse;
use crate::formula::show::text;
use crate::system::Selected;

/// Its value, and the constants of each run between which it acts: first sample, and one after the last.
pub(in crate::diagnose) const SIZE: &str = "change";
pub(in crate::diagnose) const FROM: &str = "change_from";
pub(in crate::diagnose) const UNTIL: &str = "change_until";
/// Of a run in which it does not act.
pub(in crate::diagnose) const NEVER: f64 = 1e12;

/// One value of a block between samples of each run, as an effect by a name; `None` if it has none.
pub(in crate::diagnose) fn windowed(block: &Effect, value: usize, name: &str) -> Option<Selected> {
    let own = block.parameters.get(value)?;
    let window = format!("0.5 * (sign(index + 0.5 - {FROM}) - sign(index + 0.5 - {UNTIL}))");
    let (size, nothing) = (parse(&format!("{SIZE} * {window}")).ok()?, parse("0").ok()?);
    let of = |local: &str| match local {
        _ if local == own.name => Some(size.clone()),
        _ if block.parameters.iter().any(|one| one.name == local) => Some(nothing.clone()),
        _ => None,
    };
    let unit = own.unit.si_symbol();
    let mut file = format!(
        "name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n{SIZE} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"rig\" }}\n",
        block.title
    );
    for constant in [FROM, UNTIL] {
        file.push_str(&format!(
            "{constant} = {{ unit = \"1\", value = \"{NEVER}\", fixed = true, scope = \"run\" }}\n"
        ));
    }
    file.push_str("[patch]\n");
    for patch in &block.patches {
        let target = match &patch.target {
            Target::Time(measurand) => format!("\"{measurand}.t\""),
            Target::Name(name) => name.clone(),
            _ => return None,
        };
        let formula = text(&replaced(&patch.formula.root, &of));
        file.push_str(&format!("{target} = '{formula}'\n"));
    }
    let effect = Effect::parse(Source::new(name.to_owned(), file)).ok()?;
    Some(Selected { effect: Arc::new(effect), head: None, member: Default::default() })
}
