//! Values beyond the range for which their effect's form holds: what to do.

use crate::estimate::linear_range::BeyondRange;
use crate::report::figure;

/// A sentence each; empty if there are none.
pub(crate) fn text(beyond: &[BeyondRange]) -> String {
    let mut text = String::new();
    for one in beyond {
        let of = one.of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
        let size = |size| figure::size(size, &one.unit);
        let again = match one.simulate_at {
            Some(at) => format!("simulate again at {}", size(at)),
            None => "simulate again with this value".to_owned(),
        };
        text.push_str(&format!(
            "`{}`{of} is {}, beyond the {} for which its sensitivity holds: {again}, and take the new streams.\n",
            one.parameter,
            size(one.value),
            size(one.range),
        ));
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}
