//! `[timing]` and a run's `timing`: what they say, every fault at its place.

use crate::campaign::statement::{self, Spread};
use crate::campaign::timing::{Gate, Line, Method, Reference, Reply, RunTiming, Timing};
use crate::document::entries::{Entry, Item, Named, Reader, Value, get};
use crate::units::{Dimension, Unit};

const COMMON: [&str; 6] =
    ["method", "edge", "resolution", "jitter", "controller_gate", "instrument_gate"];
const SERIAL: [&str; 5] = ["baud", "baud_tolerance", "bits", "reference", "reply"];
/// Edges, gates, resolution and jitter (s) are shorter.
const LONGEST_LINK: f64 = 0.1;
/// A request (s) is not longer.
const LONGEST: f64 = 10.0;
/// A line whose rate is off by more reads the tenth bit in the place of another.
const MOST_TOLERANCE: f64 = 0.05;
const GATE: [&str; 6] = ["at_most", "value", "sigma", "U", "k", "degrees_of_freedom"];

/// Reads `[timing]`; `None` after a fault that leaves nothing to go on with.
pub(crate) fn timing(reader: &mut Reader, item: &Item) -> Option<Timing> {
    let entries = reader.table(item, "[timing]");
    if entries.is_empty() {
        if matches!(item.value, Value::Table(_)) {
            let help = "write method = \"trigger\" or method = \"serial\"";
            reader.fault(item.span, "[timing] does not say its method", help);
        }
        return None;
    }
    let method = method(reader, item, entries)?;
    let known: Vec<&str> = match method {
        Method::Trigger => COMMON.to_vec(),
        Method::Serial(_) => [&COMMON[..], &SERIAL[..]].concat(),
    };
    for entry in entries {
        let key = entry.key.as_str();
        if SERIAL.contains(&key) && method == Method::Trigger {
            let message = format!("`{key}` belongs to a serial interface");
            reader.fault(entry.span, message, "write method = \"serial\", or leave it out");
        } else if !known.contains(&key) {
            reader.unknown(entry.span, "key", key, &known);
        }
    }
    let mut width = |key: &str| get(entries, key).and_then(|item| short(reader, item, key));
    let (edge, resolution, jitter) = (width("edge"), width("resolution"), width("jitter"));
    if let (Method::Serial(line), Some(step), Some(item)) =
        (method, resolution, get(entries, "resolution"))
        && step >= 2.0 / line.baud
    {
        let message = "the captures are too coarse to tell one falling edge from the next";
        let help = format!(
            "falling edges of the start bit may follow each other after two bits, {:.2} µs at this rate",
            2e6 / line.baud
        );
        reader.fault(item.span, message, help);
    }
    let mut gate = |key: &str| get(entries, key).and_then(|item| gate(reader, item, key));
    let (controller_gate, instrument_gate) = (gate("controller_gate"), gate("instrument_gate"));
    let reply = get(entries, "reply").and_then(|item| reply(reader, item, method));
    let written = item.to_json();
    let place = reader.place(item.span);
    Some(Timing {
        method,
        edge,
        resolution,
        jitter,
        controller_gate,
        instrument_gate,
        reply,
        written,
        place,
    })
}

fn method(reader: &mut Reader, item: &Item, entries: &[Entry]) -> Option<Method> {
    let Some(said) = get(entries, "method") else {
        let help = "write method = \"trigger\" or method = \"serial\"";
        reader.fault(item.span, "[timing] does not say its method", help);
        return None;
    };
    match reader.text(said, "method = \"trigger\"")?.as_str() {
        "trigger" => Some(Method::Trigger),
        "serial" => line(reader, item, entries).map(Method::Serial),
        other => {
            reader.unknown(said.span, "method", other, &["trigger", "serial"]);
            None
        }
    }
}

fn line(reader: &mut Reader, item: &Item, entries: &[Entry]) -> Option<Line> {
    let mut need = |key: &str, example: &str| {
        let found = get(entries, key);
        if found.is_none() {
            let message = format!("a serial interface needs `{key}`");
            reader.fault(item.span, message, format!("write {example}"));
        }
        found
    };
    let (rate, count) = (need("baud", "baud = \"19200 Bd\""), need("bits", "bits = 80"));
    let mut baud = rate.and_then(|item| {
        if let Value::Bare(number) = &item.value {
            let help = format!("write baud = \"{number} Bd\"");
            reader.fault(item.span, format!("`{number}` has no unit"), help);
            return None;
        }
        reader.positive_of(item, "baud", &Unit::coherent(Dimension::NONE / Dimension::TIME))
    });
    let bits = count.and_then(|item| bits(reader, item));
    if let (Some(rate), Some(count), Some(item)) = (baud, bits, count)
        && count / rate > LONGEST
    {
        let message =
            format!("a request of {count:e} bits at {rate:e} Bd takes {:.3e} s", count / rate);
        let help = format!("it is read to take {LONGEST} s at most: check `baud` and `bits`");
        reader.fault(item.span, message, help);
        baud = None;
    }
    let tolerance = get(entries, "baud_tolerance").and_then(|item| {
        let found = reader.positive_of(item, "baud_tolerance", &Unit::one())?;
        if found >= MOST_TOLERANCE {
            let message = format!("a baud rate off by {:.3} % loses bits", 100.0 * found);
            let help = "the last of ten bits is then read half a bit off; such a line does not work, and crystals keep 100 ppm";
            reader.fault(item.span, message, help);
            return None;
        }
        Some(found)
    });
    let reference = get(entries, "reference").and_then(|item| {
        let text = reader.text(item, "reference = \"complete\"")?;
        match text.as_str() {
            "complete" => Some(Reference::Complete),
            "start_bit" => Some(Reference::StartBit),
            other => {
                reader.unknown(item.span, "reference", other, &["complete", "start_bit"]);
                None
            }
        }
    });
    Some(Line {
        baud: baud?,
        baud_tolerance: tolerance.unwrap_or(0.0),
        bits: bits?,
        reference: reference.unwrap_or(Reference::Complete),
    })
}

/// A time of the chain: more than zero, and short beside what it is part of.
fn short(reader: &mut Reader, item: &Item, what: &str) -> Option<f64> {
    let found = reader.positive_of(item, what, &Unit::second())?;
    if found >= LONGEST_LINK {
        let message = format!("{what} of {found:e} s is no property of an electronic circuit");
        let help = format!("times of the chain are shorter than {LONGEST_LINK} s: check the unit");
        reader.fault(item.span, message, help);
        return None;
    }
    Some(found)
}

fn bits(reader: &mut Reader, item: &Item) -> Option<f64> {
    let found = reader.number(item, "bits")?;
    if found < 1.0 || found.fract() != 0.0 {
        let help = "count start, data, parity and stop bits of all its characters";
        reader.fault(item.span, "bits must be a whole number, one or more", help);
        return None;
    }
    Some(found)
}

fn reply(reader: &mut Reader, item: &Item, method: Method) -> Option<Reply> {
    let Method::Serial(line) = method else { return None };
    let entries = reader.table(item, "reply = { after = \"14 ms\", scatter = \"0.2 ms\" }");
    reader.only(entries, &["after", "scatter"]);
    let mut time = |key: &str| {
        get(entries, key).and_then(|item| reader.positive_of(item, key, &Unit::second()))
    };
    let (after, scatter) = (time("after"), time("scatter"));
    if get(entries, "after").is_none() && !entries.is_empty() {
        let help = "write reply = { after = \"14 ms\" }";
        reader.fault(item.span, "`reply` does not say after what time it begins", help);
    }
    let after = after?;
    let length = line.bits / line.baud;
    if after < length {
        let message =
            format!("the reply begins before its request of {:.2} ms is complete", 1e3 * length);
        reader.fault(item.span, message, "count from start bit to start bit");
        return None;
    }
    Some(Reply { after, scatter: scatter.unwrap_or(0.0) })
}

fn gate(reader: &mut Reader, item: &Item, what: &str) -> Option<Gate> {
    let example = format!("{what} = {{ at_most = \"100 ns\" }}");
    let entries = reader.table(item, &example);
    reader.only(entries, &GATE);
    let spread = statement::spread(reader, entries, what, &Unit::second());
    match (get(entries, "at_most"), get(entries, "value")) {
        (Some(item), None) if spread.is_none() => {
            // Anything from nothing to this much is as likely: rectangular.
            let most = short(reader, item, what)?;
            let sigma = most / 12.0_f64.sqrt();
            Some(Gate { value: 0.5 * most, spread: Spread { sigma, ..Spread::default() } })
        }
        (None, Some(item)) => {
            let value = reader.quantity_of(item, what, &Unit::second())?;
            if value < 0.0 {
                reader.fault(item.span, format!("{what} is a delay and cannot be negative"), "");
            } else if value >= LONGEST_LINK {
                let message =
                    format!("{what} of {value:e} s is no property of an electronic circuit");
                reader.fault(item.span, message, "check the unit");
            } else if spread.is_none() {
                let message = format!("the uncertainty of {what} is not stated");
                reader.fault(item.span, message, "state `sigma`, or `U` with its `k`");
            }
            Some(Gate { value, spread: spread? })
        }
        _ => {
            let message = format!("{what} is known to be at most so long, or by a value");
            let help = format!("{example}, or {{ value = \"60 ns\", U = \"10 ns\", k = 2 }}");
            reader.fault(item.span, message, help);
            None
        }
    }
}

/// Reads `timing = { ... }` of a run.
pub(crate) fn run(reader: &mut Reader, item: &Item) -> RunTiming {
    let entries = reader.table(item, "timing = { captures = \"slow_latch.csv\" }");
    reader.only(entries, &["captures", "bits"]);
    let captures = get(entries, "captures").and_then(|item| {
        let text = reader.text(item, "captures = \"slow_latch.csv\"")?;
        Some(Named { text, span: item.span, place: reader.place(item.span) })
    });
    RunTiming { captures, bits: get(entries, "bits").and_then(|item| bits(reader, item)) }
}
