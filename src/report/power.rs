//! The result of `power` for programs: the keys of `docs/formats.md`, section 6.

use serde_json::{Map, Value, json};

use crate::diagnose::power::sight::CAUGHT;
use crate::diagnose::power::{Power, Row};
use crate::diagnose::thresholds::{ENTER, ROW};
use crate::report::json::{number, unobservable};

/// The result of `power`.
pub fn json(power: &Power) -> Value {
    let delays: Map<String, Value> =
        power.delays.iter().map(|one| (one.measurand.clone(), number(one.sigma))).collect();
    json!({
        "ln_bayes_factor": ENTER,
        "least_gain": ROW,
        "caught": CAUGHT,
        "effects": power.rows.iter().map(row).collect::<Vec<_>>(),
        "delays": delays,
        "unobservable": unobservable(&power.nominal.unobservable),
    })
}

/// One row an effect; sizes in SI, empty if never.
pub fn table(power: &Power) -> String {
    let mut text = String::from("name,state,typical,detectable,identifiable,unit,with\n");
    let size = |size: Option<f64>| size.map_or_else(String::new, |size| format!("{size:e}"));
    for row in &power.rows {
        text.push_str(&format!(
            "{},{},{},{},{},{},{}\n",
            row.name,
            row.state.word(),
            size(row.typical),
            size(row.detectable),
            size(row.identifiable),
            row.unit.si_symbol(),
            row.with.join(" ")
        ));
    }
    text
}

fn row(row: &Row) -> Value {
    let shifts: Map<String, Value> =
        row.shifts.iter().map(|(delay, shift)| (delay.clone(), number(Some(*shift)))).collect();
    let members: Vec<Value> = row
        .members
        .iter()
        .map(|(member, size)| json!({ "member": member, "detectable": number(Some(*size)) }))
        .collect();
    json!({
        "name": row.name,
        "state": row.state.word(),
        "detectable": number(row.detectable),
        "identifiable": number(row.identifiable),
        "typical": number(row.typical),
        "unit": row.unit.si_symbol(),
        "with": row.with,
        "members": members,
        "delay_shifts": shifts,
        "words": row.words,
    })
}
