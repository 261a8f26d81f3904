//! Starts that a search found: they stay with a campaign's data, so that every model of these starts
//! there, whatever effects are put in or held.

use crate::engine::layout::Layout;

/// Where a parameter starts.
#[derive(Clone, Debug)]
pub struct FoundStart {
    /// The parameter's full name.
    pub name: String,
    /// The setup or run it holds for, as in [`crate::engine::layout::Instance::of`].
    pub of: Option<String>,
    /// Its components (SI).
    pub components: Vec<f64>,
}

impl Layout {
    /// Lets parameters that are estimated start where a search found them.
    pub(super) fn begin_at_found<'f>(&mut self, all: impl Iterator<Item = &'f FoundStart>) {
        for found in all {
            for index in 0..self.instances.len() {
                let is_free = self.is_free(index);
                let one = &mut self.instances[index];
                if one.name == found.name && one.of == found.of && is_free {
                    if !one.start_found {
                        one.stated_start = one.setting.start_of(0);
                    }
                    one.setting.begin_at(found.components.clone());
                    one.start_found = true;
                }
            }
        }
    }
}
