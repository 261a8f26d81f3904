//! `[output]` of a campaign: the units in which people read results.

use crate::document::entries::{Entry, Reader};
use crate::units::display::KINDS;
use crate::units::{DisplayUnits, Unit};

/// Reads it. A name that no parameter bears is ignored: it may be that of an effect.
pub(super) fn read(reader: &mut Reader, entries: &[Entry]) -> DisplayUnits {
    let mut units = DisplayUnits::default();
    reader.only(entries, &["units"]);
    let example = "units = { angle = \"arcsec\", length = \"mm\" }";
    for entry in entries.iter().filter(|entry| entry.key == "units") {
        for entry in reader.table(&entry.item, example).to_vec() {
            let Some(text) = reader.text(&entry.item, example) else { continue };
            let unit = match Unit::parse(&text) {
                Ok(unit) => unit,
                Err(error) => {
                    reader.fault(entry.item.span, error.message, error.help.unwrap_or_default());
                    continue;
                }
            };
            let kind = KINDS.iter().find(|(kind, _)| *kind == entry.key);
            let like = kind.and_then(|(_, symbol)| Unit::parse(symbol).ok());
            if let Some(like) = like.filter(|like| !like.accepts(&unit)) {
                let message = format!("`{text}` is not a unit of `{}`", entry.key);
                let help = format!("state one such as `{}`", like.symbol);
                reader.fault(entry.item.span, message, help);
                continue;
            }
            units.add(&entry.key, unit);
        }
    }
    units
}
