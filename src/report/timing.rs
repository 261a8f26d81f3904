//! How reference times came about, in words and for programs.

use serde_json::{Map, Value, json};

use crate::campaign::load::Campaign;
use crate::campaign::timing::chain::part;
use crate::campaign::timing::{Method, Reference, Timing};
use crate::report::figure;
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
            let value = json!({
                "replies": one.count,
                "mean": one.mean,
                "standard_deviation": one.standard_deviation,
                "smallest": one.smallest,
                "largest": one.largest,
            });
            (one.run.clone(), value)
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

/// The same in sentences; empty where there is no `[timing]`.
pub fn text(campaign: &Campaign) -> String {
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
        let time = |seconds: f64| figure::value(seconds, Some(one.standard_deviation), &second);
        text.push_str(&format!(
            "request to reply in run `{}`: {} on average, from {} to {} ({} replies)\n",
            one.run,
            time(one.mean),
            time(one.smallest),
            time(one.largest),
            one.count
        ));
    }
    text
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
