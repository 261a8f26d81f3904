//! `delay_range`: between which delays a reading may lie, and so which part of a stream it needs.

use crate::diagnostic::decimals;
use crate::document::entries::{Item, Named, Reader, Value};
use crate::model::Model;
use crate::units::Unit;

/// The range of delays (s) unless stated.
pub const USUAL: [f64; 2] = [-0.5, 0.5];

/// Ranges of delays (s): the least and the greatest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DelayRange {
    /// That of all delays that are not named; `None` where none is stated.
    usual: Option<[f64; 2]>,
    /// Those of delays by their names.
    named: Vec<(Named, [f64; 2])>,
}

const EXAMPLE: &str = "delay_range = \"2 s\", or [\"-8 s\", \"-4 s\"], or { camera = \"2 s\" }";

impl DelayRange {
    /// As far to either side.
    pub fn even(width: f64) -> Self {
        Self { usual: Some([-width, width]), named: Vec::new() }
    }

    /// Whether one is stated, whatever its value.
    pub fn is_stated(&self) -> bool {
        self.usual.is_some() || !self.named.is_empty()
    }

    /// The range that is stated of a delay, by its name.
    pub fn stated(&self, delay: &str) -> Option<[f64; 2]> {
        let own = self.named.iter().find(|(name, _)| bare(&name.text) == bare(delay));
        own.map(|(_, range)| *range).or(self.usual)
    }

    /// The range of a delay, by its name: the default where none is stated.
    pub fn of_delay(&self, delay: &str) -> [f64; 2] {
        self.stated(delay).unwrap_or(USUAL)
    }

    /// Reads it: a width, a pair, or a table of them by the names of delays.
    pub(crate) fn read(reader: &mut Reader, item: &Item) -> Option<Self> {
        let Value::Table(entries) = &item.value else {
            return range(reader, item).map(|usual| Self { usual: Some(usual), named: Vec::new() });
        };
        let mut found = Self::default();
        for entry in entries {
            let name = Named {
                text: entry.key.clone(),
                span: entry.span,
                place: reader.place(entry.span),
            };
            found.named.push((name, range(reader, &entry.item)?));
        }
        Some(found)
    }

    /// The range of the delay of each measurand of a model; faults names that are no delays.
    pub(crate) fn of(&self, model: &Model, reader: &mut Reader) -> Vec<[f64; 2]> {
        let delay = |measurand: &str| {
            let group = model.delays.iter().find(|group| group.of.iter().any(|of| of == measurand));
            group.map_or(measurand.to_owned(), |group| group.name.clone())
        };
        let delays: Vec<String> = model.measurands.iter().map(|one| delay(&one.name)).collect();
        for (name, _) in &self.named {
            if !delays.iter().any(|delay| delay == bare(&name.text)) {
                let mut known: Vec<&str> = delays.iter().map(String::as_str).collect();
                known.dedup();
                reader.unknown(name.span, "delay", &name.text, &known);
            }
        }
        delays.iter().map(|delay| self.of_delay(delay)).collect()
    }

    /// What holds all ranges.
    pub fn hull(&self) -> [f64; 2] {
        self.named.iter().fold(self.usual.unwrap_or(USUAL), |[low, high], (_, range)| {
            [low.min(range[0]), high.max(range[1])]
        })
    }

    /// As it stands in a campaign; `quoted` writes a text.
    pub(crate) fn written(&self, quoted: fn(&str) -> String) -> String {
        let range = |[low, high]: &[f64; 2]| match -low == *high {
            true => quoted(&format!("{high:?} s")),
            false => {
                format!("[{}, {}]", quoted(&format!("{low:?} s")), quoted(&format!("{high:?} s")))
            }
        };
        if self.named.is_empty() {
            return range(&self.usual.unwrap_or(USUAL));
        }
        let named = self.named.iter();
        let words: Vec<String> =
            named.map(|(name, own)| format!("{} = {}", quoted(&name.text), range(own))).collect();
        format!("{{ {} }}", words.join(", "))
    }
}

/// The name of a delay without its ending.
fn bare(name: &str) -> &str {
    name.trim_end_matches(".delay")
}

/// A range in words, as that within which a stream must be there.
pub(crate) fn words([low, high]: [f64; 2]) -> String {
    match -low == high {
        true => format!("within {high} s of the end of a stream or of a gap in it, or outside it"),
        false => format!(
            "the streams are not there from {} s to {} s of them (`delay_range`)",
            decimals(low, 3),
            decimals(high, 3)
        ),
    }
}

/// A width, or a pair of the least and the greatest.
fn range(reader: &mut Reader, item: &Item) -> Option<[f64; 2]> {
    let second = Unit::second();
    let Value::List(items) = &item.value else {
        return reader.positive_of(item, "delay_range", &second).map(|width| [-width, width]);
    };
    let [low, high] = items.as_slice() else {
        reader.fault(item.span, "a range has two ends", format!("as in {EXAMPLE}"));
        return None;
    };
    let low = reader.quantity_of(low, "delay_range", &second);
    let high = reader.quantity_of(high, "delay_range", &second);
    let range = [low?, high?];
    if range[0] >= range[1] {
        let help = "write the least delay first: [\"-8 s\", \"-4 s\"]";
        reader.fault(item.span, "the ends of the range are not in order", help);
        return None;
    }
    Some(range)
}
