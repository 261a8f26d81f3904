//! Values beyond the range for which their effect's form holds: what to do.

use crate::estimate::linear_range::BeyondRange;
use crate::report::figure;

/// A sentence each; empty if there are none.
pub(crate) fn text(beyond: &[BeyondRange]) -> String {
    let mut text = String::new();
    for one in beyond {
        let of = one.of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
        // Values matter to a part of the range.
        let shown = |value| figure::value(value, Some(0.1 * one.range), &one.unit);
        let again = match one.simulate_at {
            Some(at) => format!("simulate again at {}", shown(at)),
            None => "simulate again with this value".to_owned(),
        };
        if let (true, Some(at)) = (one.is_of_model, one.simulate_at) {
            text.push_str(&format!(
                "`{}`{of} is {}, farther than {} from the {} at which its streams were computed: values and uncertainties do not hold. Compute them again at {}, and take the new streams.\n",
                one.parameter,
                shown(at),
                figure::size(one.range, &one.unit),
                shown(at - one.value),
                shown(at),
            ));
            continue;
        }
        text.push_str(&format!(
            "`{}`{of} is {}, beyond the {} for which its sensitivity holds: {again}, and take the new streams.\n",
            one.parameter,
            shown(one.value),
            figure::size(one.range, &one.unit),
        ));
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}
