//! A measurement campaign: runs of an instrument on a rig, with units settled and signals ready.
//!
//! | file | answers |
//! |---|---|
//! | [`statement`] | how well a value is known, as a certificate states it |
//! | [`specification`] | what the maker of the instrument promises to follow |
//! | [`overrides`] | what a campaign states of parameters |
//! | [`plan`] | how a run will be measured |
//! | [`timing`] | when a reading was asked for: captures made into reference times |
//! | [`declared`], [`mod@file`] | inputs, measurands, runs as declared; what campaign.toml says, with the place of everything |
//! | `origin`, `described` | where a table's cells are from, for messages; what they say of a table |
//! | `encodings` | texts that are not UTF-8 |
//! | `lines`, [`dialect`], [`form`], `preamble`, `recognise` | a file's lines; how they fall into cells and numbers; what is stated of it; what is recognised, and where its header is |
//! | [`formats`], `roles` | formats of logs by name; which names of a model have a role in them |
//! | [`header`], `row`, `repeats` | what a file's columns are; a line of it as numbers; what is wrong with rows, each cause once |
//! | `words`, `table_entry`, `endings` | what a campaign calls columns; how it names a file; units at the end of a name |
//! | [`stamps`] | stamps as exact numbers since a moment that all files share |
//! | `calendar`, [`mod@date`], `date_order` | dates and times of day; a date; in which order a column has day and month |
//! | `clock` | whether the clock of a file was set forward |
//! | `repeated_rows` | rows that repeat another one, left out |
//! | `wraps`, `order`, `sorted`, `reordered` | stamps that begin anew; in which order rows are whose time goes back; a file read anew and sorted; its rows |
//! | [`table`] | a CSV file (plain or .gz) or a Parquet file as columns in SI, with the place of every cell |
//! | `points`, `smoothing`, [`spline`] | a stream gathered into knots; how much to smooth it; the curve |
//! | `steps`, `counters` | streams that go in steps, which no curve follows; that begin anew |
//! | [`signal`] | a moving input: local Taylor series or smoothing spline |
//! | `columns`, `captured` | the columns of a model's runs; an input recorded with each sample |
//! | [`samples`] | the samples of a run or a stretch of it: times, inputs, readings |
//! | `glitches`, `stream_rows` | single values of streams far off their neighbours, left out; rows left out of a stream |
//! | `held`, `held_streams` | readings that are logged more often than they are read; gaps of streams that were filled with the last value |
//! | `uniform`, `jumps` | when samples were taken if sampling is uniform; where stamps jump |
//! | `sigmas` | standard uncertainties as formulas and columns |
//! | `spill`, `spilled` | numbers in a temporary file; them as samples |
//! | [`record`] | all samples of a run, however long: held in memory or spilled to a temporary file |
//! | [`recorder`] | samples taken in their order and kept as a record, within a budget of memory |
//! | [`run`] | one run |
//! | [`calibration`] | what is known of an input's values, and corrections of them |
//! | `computed`, `computed_columns`, [`mod@delay_range`] | a column computed from others of its file; those of a table; between which delays readings may lie |
//! | [`loaded`] | a campaign that is read, and how to read it |
//! | `loader` | what the readers of runs share |
//! | `certificate`, `readings`, `logged` | an input's certificate; the readings of a run; a logged stream made into a signal |
//! | `attitude` | streams that are the components of one quaternion made continuous |
//! | `expected` | which columns the files of a run may have |
//! | `measured`, `planned` | one measured run; one planned run |
//! | `overlap` | runs of one setup that seem to be recorded at the same time |
//! | [`load`] | a campaign file read against its model |
//! | [`mod@begin`] | a campaign to begin with, from logs alone |
//! | [`whole`] | a file that is whole or not there |
//! | [`mod@write`], [`write_run`] | a campaign of the same form |
//!
//! No files import each other in a circle.

mod attitude;
mod axes;
pub mod begin;
mod calendar;
pub mod calibration;
mod captured;
mod certificate;
mod clock;
mod column_units;
mod columns;
mod computed;
mod computed_columns;
mod counters;
pub mod date;
mod date_order;
pub mod declared;
pub mod delay_range;
mod described;
pub mod dialect;
mod encodings;
mod endings;
mod expected;
pub mod file;
mod foreign;
pub mod form;
pub mod formats;
mod glitches;
pub mod header;
mod held;
mod held_streams;
mod jumps;
pub(crate) mod lines;
pub mod load;
pub mod loaded;
mod loader;
mod logged;
mod measured;
mod order;
mod origin;
mod output;
mod overlap;
pub mod overrides;
#[cfg(feature = "parquet")]
mod parquet;
pub mod plan;
mod planned;
mod points;
mod preamble;
mod readings;
mod recognise;
pub mod record;
pub mod recorder;
mod reordered;
mod repeated_rows;
mod repeats;
mod roles;
mod row;
pub mod run;
pub mod samples;
mod sexagesimal;
mod sigmas;
pub mod signal;
mod smoothing;
mod sorted;
pub mod specification;
mod spill;
mod spilled;
pub mod spline;
mod stamp_columns;
pub mod stamps;
pub mod statement;
mod steps;
mod stream_rows;
mod streamed;
pub mod table;
mod table_entry;
mod time_units;
pub mod timing;
mod tracks;
mod uniform;
pub mod wanted;
pub mod whole;
mod words;
mod wraps;
pub mod write;
pub mod write_run;

pub(crate) use attitude::quaternions;
pub use record::{Record, Sample, Stretch};
pub use run::{Role, Run};
pub use samples::Samples;
pub use signal::Track;
