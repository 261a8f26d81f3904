//! A block that acts from a sample of a run on, as an effect that can be fitted: a clock that was set by
//! seconds, a large knock. The change point itself is linear (`budget::changes`).

use std::ops::Range;
use std::sync::Arc;

use crate::diagnostic::Source;
use crate::effect::{Effect, Target};
use crate::formula::isolate::replaced;
use crate::formula::parser::parse;
use crate::formula::show::text;
use crate::system::Selected;

/// Its values, and the constants of each run between which it acts: first sample, and one after the last.
pub(in crate::diagnose) const SIZES: [&str; 6] =
    ["change", "change_2", "change_3", "change_4", "change_5", "change_6"];
pub(in crate::diagnose) const FROM: &str = "change_from";
pub(in crate::diagnose) const UNTIL: &str = "change_until";
/// Of a run in which it does not act.
pub(in crate::diagnose) const NEVER: f64 = 1e12;

/// Some values of a block between samples of each run, one or those of a pose, as an effect by a name; `None` if it
/// does not have them.
pub(in crate::diagnose) fn windowed(
    block: &Effect,
    values: Range<usize>,
    name: &str,
) -> Option<Selected> {
    let own = block.parameters.get(values.clone())?;
    let window = format!("0.5 * (sign(index + 0.5 - {FROM}) - sign(index + 0.5 - {UNTIL}))");
    let sizes = SIZES.get(..own.len())?.iter();
    let sizes: Option<Vec<_>> =
        sizes.map(|size| parse(&format!("{size} * {window}")).ok()).collect();
    let (sizes, nothing) = (sizes?, parse("0").ok()?);
    let of = |local: &str| {
        let at = block.parameters.iter().position(|one| one.name == local)?;
        let size = at.checked_sub(values.start).and_then(|at| sizes.get(at));
        Some(size.unwrap_or(&nothing).clone())
    };
    let mut file =
        format!("name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n", block.title);
    for (size, own) in SIZES.iter().zip(own) {
        let unit = own.unit.si_symbol();
        file.push_str(&format!(
            "{size} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"rig\" }}\n"
        ));
    }
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
