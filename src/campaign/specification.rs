//! What the maker of an instrument promises to follow: `[specification]` of a campaign.
//!
//! Nothing is estimated from it; `deviations` holds what was asked of the instrument against it.
//!
//! ```toml
//! [specification]
//! source        = "PCMM System Specifications 2008"
//! lateral_speed = "4 m/s"                       # of the target, across the line of sight
//! rates         = { horizontal = "180 deg/s" }  # of the head's angles
//! ```
//! `target_speed` is the target's whole speed, `radial_speed` that along the line of sight.

use crate::document::entries::{Entry, Named, Quantity, Reader, get};
use crate::units::{Dimension, Unit};

/// The keys of the target's speeds.
pub const SPEEDS: [&str; 3] = ["target_speed", "lateral_speed", "radial_speed"];

/// Largest speeds and rates that an instrument is said to follow.
#[derive(Clone, Debug, Default)]
pub struct Specification {
    /// Where it is said.
    pub source: Option<String>,
    /// Speeds of the target, in the order of [`SPEEDS`].
    pub speeds: [Option<Quantity>; 3],
    /// Rate of each angle measurand named.
    pub rates: Vec<(Named, Quantity)>,
}

impl Specification {
    /// Reads `[specification]`.
    pub(crate) fn read(reader: &mut Reader, entries: &[Entry]) -> Self {
        let known: Vec<&str> = ["source", "rates"].into_iter().chain(SPEEDS).collect();
        reader.only(entries, &known);
        let speed = Unit::coherent(Dimension::LENGTH / Dimension::TIME);
        let rate =
            Unit { symbol: "rad/s".into(), ..Unit::coherent(Dimension::NONE / Dimension::TIME) };
        let source = get(entries, "source").and_then(|item| reader.text(item, "source = \"...\""));
        let speeds = SPEEDS.map(|key| {
            let item = get(entries, key)?;
            reader.positive_of(item, key, &speed)?;
            reader.quantity(item)
        });
        let rates = match get(entries, "rates") {
            Some(item) => reader.table(item, "rates = { horizontal = \"180 deg/s\" }"),
            None => &[],
        };
        let rates = rates
            .iter()
            .filter_map(|entry| {
                reader.positive_of(&entry.item, "a rate", &rate)?;
                let (text, place) = (entry.key.clone(), reader.place(entry.span));
                let name = Named { text, span: entry.span, place };
                Some((name, reader.quantity(&entry.item)?))
            })
            .collect();
        Self { source, speeds, rates }
    }

    /// The largest rate (rad/s) that is promised for a measurand.
    pub fn rate(&self, measurand: &str) -> Option<f64> {
        let found = self.rates.iter().find(|(name, _)| name.text == measurand);
        found.map(|(_, quantity)| quantity.value)
    }

    /// Its lines in campaign.toml; none if nothing is said.
    pub(crate) fn lines(&self, quoted: impl Fn(&str) -> String) -> Vec<String> {
        let mut lines: Vec<String> =
            self.source.iter().map(|source| format!("source = {}", quoted(source))).collect();
        for (key, quantity) in SPEEDS.iter().zip(&self.speeds) {
            lines.extend(quantity.iter().map(|one| format!("{key} = {}", quoted(&one.text))));
        }
        if !self.rates.is_empty() {
            let word = |(name, one): &(Named, Quantity)| {
                format!("{} = {}", quoted(&name.text), quoted(&one.text))
            };
            let words: Vec<String> = self.rates.iter().map(word).collect();
            lines.push(format!("rates = {{ {} }}", words.join(", ")));
        }
        if !lines.is_empty() {
            lines.insert(0, "\n[specification]".to_owned());
        }
        lines
    }
}
