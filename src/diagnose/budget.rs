//! The gap as a budget: which terms explain it, largest first, and what remains.
//!
//! | file | answers |
//! |---|---|
//! | [`sums`] | one pass over the readings: Gram sums by measurand |
//! | [`terms`] | columns with a price: effects, basis blocks |
//! | [`selection`] | terms beside a model, under noise that follows from the model |
//! | [`search`] | the model that the sums bear out |
//! | [`pieces`], [`held_out`], [`labels`] | sums by run, held-out evidence, groups of runs |
//! | [`rows`] | whitened rows one after the other |
//! | [`changes`] | change points as terms |
//! | `stated` | stated values that are wrong, as terms |
//! | `size`, `values` | how large an effect is, and may be; values of terms by parameter |
//! | `still`, [`stamp_jumps`] | readings that hardly vary; where stamps jump |
//! | [`judge`] | when a row stands |
//! | [`linear`], [`in_fit`] | a fitted model with everything that may be added to it; rows that are in it |
//! | [`families`] | which member of a family stands for it |
//! | [`noise_or_blocks`], [`memory`], [`noise_of_runs`] | noise that is autocorrelated or differs between runs, against blocks |
//! | [`noise`] | outliers, jitter, autocorrelation in the residuals |
//! | [`neighbours`] | residuals that several inputs decide together |
//! | [`noise_scale`] | noise scale factors that are not as stated |
//! | [`verdict`], [`answer`], `assemble` | the verdict as a pure function, and the answer as data |
//! | [`solved`] | values of rows, beside a remainder whose values have a prior |
//! | [`absorbed`], [`member`] | effects that show in no reading; uncertainty of family members |
//! | [`confounded`] | effects that the readings do not separate from a row |
//! | [`driver`] | refit, relinearise, search again |

pub mod absorbed;
pub mod answer;
mod assemble;
pub mod changes;
pub mod confounded;
pub mod driver;
pub mod families;
pub mod held_out;
pub mod in_fit;
pub mod judge;
pub mod labels;
pub mod linear;
pub mod member;
pub mod memory;
pub mod neighbours;
pub mod noise;
pub mod noise_of_runs;
pub mod noise_or_blocks;
pub mod noise_scale;
pub mod pieces;
pub mod rows;
pub mod search;
pub mod selection;
mod size;
pub mod solved;
pub mod stamp_jumps;
mod stated;
mod still;
pub mod sums;
pub mod terms;
mod values;
pub mod verdict;
