//! How reference times came about, in words and for programs.

use serde_json::{Map, Value, json};

use crate::campaign::load::Campaign;
use crate::campaign::timing::chain::part;
use crate::campaign::timing::replies::{Over, RequestToReply};
use crate::campaign::timing::{Method, Reference, Timing};
use crate::model::Model;
use crate::report::figure;
use crate::report::table::quoted;
use crate::units::{Dimension, Unit};

/// What programs read of `[timing]`; null where there is none.
pub fn json(campaign: &Campaign) -> Value {
    let Some(timing) = &campaign.timing else { return Value::Null };
    let chain = timing.chain(campaign.entries.iter().map(|entry| &entry.timing));
    let links: Vec<Value> = chain
        .iter()
        .map(|link| {
            let part = if link.is_common { "common" } else { "random" };
            json!({ "name": link.name, "sigma": link.spread.sigma, "part": part })
        })
        .collect();
    let (common, random) = (part(&chain, true), part(&chain, false));
    let shift: Map<String, Value> = campaign
        .entries
        .iter()
        .map(|entry| (entry.name.text.clone(), json!(timing.shift(&entry.timing))))
        .collect();
    let replies: Map<String, Value> = campaign
        .request_to_reply
        .iter()
        .map(|one| {
            let mut value = over(&one.time);
            value.insert("replies".to_owned(), json!(one.count));
            let moved = one.moved.iter();
            let moved = moved.map(|(input, by)| (input.clone(), Value::Object(over(by))));
            value.insert("moved".to_owned(), Value::Object(moved.collect()));
            (one.run.clone(), Value::Object(value))
        })
        .collect();
    json!({
        "method": timing.method.word(),
        "capture_to_reference": shift,
        "links": links,
        "common_part": common,
        "random_part": random,
        "sigma": common.hypot(random),
        "lag": timing.lag().map(|lag| json!({ "value": lag.value, "sigma": lag.spread.sigma })),
        "request_to_reply": replies,
    })
}

fn over(one: &Over) -> Map<String, Value> {
    let entries = [
        ("mean", one.mean),
        ("standard_deviation", one.standard_deviation),
        ("smallest", one.smallest),
        ("largest", one.largest),
    ];
    entries.into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect()
}

/// One row a reply, the first of each run: run, row of its data file, both edges, and each captured
/// input at both. Empty without replies.
pub fn replies(campaign: &Campaign, model: &Model) -> String {
    let mut text = String::new();
    for run in &campaign.request_to_reply {
        let unit = |name: &str| {
            let declared = model.inputs.iter().find(|input| input.name == name);
            declared.map_or_else(Unit::one, |input| input.unit.clone())
        };
        let units: Vec<Unit> = run.moved.iter().map(|(name, _)| unit(name)).collect();
        if text.is_empty() {
            text.push_str("run,row,request [s],reply [s],request_to_reply [s]");
            for ((name, _), unit) in run.moved.iter().zip(&units) {
                let symbol = &unit.symbol;
                text.push_str(&format!(",{name}_at_request [{symbol}],{name}_at_reply [{symbol}]"));
            }
            text.push('\n');
        }
        for one in &run.replies {
            let (request, reply) = (one.request, one.reply);
            let name = quoted(&run.run);
            text.push_str(&format!("{name},{},{request},{reply},{:.9e}", one.row, reply - request));
            for (places, unit) in one.inputs.iter().zip(&units) {
                for place in places {
                    text.push_str(&format!(",{:.9}", unit.from_si(*place)));
                }
            }
            text.push('\n');
        }
    }
    text
}

/// The same in sentences; empty where there is no `[timing]`.
pub fn text(campaign: &Campaign, model: &Model) -> String {
    let Some(timing) = &campaign.timing else { return String::new() };
    let second = Unit::coherent(Dimension::TIME);
    let chain = timing.chain(campaign.entries.iter().map(|entry| &entry.timing));
    let known = |common: bool| match part(&chain, common) {
        0.0 => "nothing".to_owned(),
        sigma => figure::uncertainty(sigma, &second),
    };
    let mut text = format!(
        "reference times: {}\ntheir standard uncertainty: {} in common, {} from sample to sample\n",
        words(timing),
        known(true),
        known(false)
    );
    if let Some(lag) = timing.lag() {
        let lag = figure::measured(lag.value, lag.spread.sigma, &second);
        text.push_str(&format!("lag of the two gates (t4 - t3): {lag}\n"));
    }
    for one in &campaign.request_to_reply {
        let RequestToReply { run, count, time, moved, .. } = one;
        let told = |value: f64| figure::value(value, Some(time.standard_deviation), &second);
        text.push_str(&format!(
            "request to reply in run `{run}`: {} on average, from {} to {} ({count} replies)\n",
            told(time.mean),
            told(time.smallest),
            told(time.largest),
        ));
        for (input, by) in moved {
            let unit = unit_for_people(model, input);
            let unit = unit.of_differences();
            let told = |value: f64| figure::value(value, Some(by.standard_deviation), &unit);
            text.push_str(&format!(
                "  `{input}` moved by {} meanwhile, from {} to {}\n",
                told(by.mean),
                told(by.smallest),
                told(by.largest)
            ));
        }
    }
    text
}

/// The unit of an input as people read it: degrees for angles.
fn unit_for_people(model: &Model, input: &str) -> Unit {
    let declared = model.inputs.iter().find(|one| one.name == input);
    let declared = declared.map_or_else(Unit::one, |input| input.unit.clone());
    match declared.symbol.as_str() {
        "rad" => Unit::parse("deg").unwrap_or(declared),
        _ => declared,
    }
}

fn words(timing: &Timing) -> String {
    let gate = match timing.controller_gate {
        Some(_) => ", the controller's gate delay taken off",
        None => "",
    };
    match timing.method {
        Method::Trigger => format!("rising edge of an external trigger{gate}"),
        Method::Serial(line) => {
            let request = format!("{} bits at {} Bd", line.bits, line.baud);
            match line.reference {
                Reference::Complete => format!("start bit of the request + {request}{gate}"),
                Reference::StartBit => format!("start bit of the request ({request}){gate}"),
            }
        }
    }
}
