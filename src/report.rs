//! Results for people and programs.
//!
//! | file | answers |
//! |---|---|
//! | [`figure`] | a value with its standard uncertainty as people write it |
//! | [`json`] | the keys that programs rely on, `docs/formats.md` section 6 |
//! | [`text`] | tables and sentences for the terminal |
//! | [`diagnosis`], `diagnosis_text` | why simulation and reality differ, for programs and for people |
//! | [`table`] | results reading by reading, as CSV |

pub mod diagnosis;
#[cfg(feature = "cli")]
pub mod diagnosis_text;
pub mod figure;
pub mod json;
pub mod table;
#[cfg(feature = "cli")]
pub mod text;
