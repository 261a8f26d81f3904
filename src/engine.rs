//! Evaluation: predictions, residuals, derivatives, Gram sums, simulated readings.
//!
//! | file | answers |
//! |---|---|
//! | [`pointwise`] | the graph at one sample, over any number: the referee |
//! | [`lanes`] | the graph over chunks of samples: the same, in bulk |
//! | [`found_starts`] | starts that a search found |
//! | [`layout`] | which unknowns there are, and their columns |
//! | `shared` | one parameter from what several campaigns state of it |
//! | [`point`] | the unknowns' values; how a step moves them; prior rows |
//! | [`moving`] | rates of what the graph holds, while time runs on from a sample |
//! | [`part`] | one campaign with its model; predictions and residuals of one sample |
//! | [`problem`] | campaigns put together, with their unknowns |
//! | [`noise`] | the covariance of the readings of one sample, and its whitening |
//! | `noise_of_problem` | the same for one sample after the other, and the rms of it; levels of random quantities |
//! | [`smoothed`] | what errors of smoothed streams add to readings |
//! | `stated_sigma` | standard uncertainties that are stated as formulas |
//! | [`gauss_markov`] | rows whitened along time, where noise is autocorrelated |
//! | [`linearise`] | whitened residuals and Jacobians, summed by run: the only maker of Jacobians |
//! | `negligible` | columns of angles that are nothing but rounding |
//! | [`gram`] | the form of those sums, and what an estimator asks of a problem |
//! | [`open`] | from what a user names to a problem |
//! | [`lanes`] | the same graph over chunks of samples, vectorised |
//! | [`switched_off`] | whether an effect is absent where its parameters are zero |
//! | [`passes`] | sums for the same signatures again and again, with other constants |
//! | [`undefined`] | which reading keeps a model from being computed |
//! | [`stretches`] | what a step leaves of the readings, and its scores stretch by stretch |
//! | [`whitened_rows`] | whitened rows one after the other |
//! | [`simulate`] | readings drawn from a model |

pub(crate) mod blocks;
pub mod found_starts;
pub mod gauss_markov;
pub mod gram;
pub(crate) mod kept;
pub mod lanes;
pub mod layout;
pub mod linearise;
pub mod mixing;
pub mod moving;
mod negligible;
pub mod noise;
mod noise_of_problem;
pub mod open;
pub mod part;
pub mod passes;
pub mod point;
pub mod pointwise;
pub mod problem;
pub mod programs;
pub mod referee;
pub mod rows;
mod runs;
mod shared;
pub mod signatures;
pub mod simulate;
pub mod smoothed;
mod stated_sigma;
pub mod stretches;
pub mod switched_off;
pub mod undefined;
pub mod visits;
pub mod whitened_rows;
pub mod whitening;
mod without_runs;

pub use layout::Layout;
pub use part::Part;
pub use point::Point;
pub use problem::Problem;
