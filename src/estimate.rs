//! Numbers with uncertainties.
//!
//! | file | answers |
//! |---|---|
//! | [`absorbed`] | members of effects that the model absorbs |
//! | [`align`] | Horn's closed form: the transformation between two sets of points |
//! | [`eigen`] | eigenvalues and singular values, for numbers of any size |
//! | [`circle`] | the circle in space nearest to some points |
//! | [`start`] | where a joint estimate begins |
//! | [`checks`] | whether the set-up can be as stated |
//! | [`arrow`] | the normal equations solved by their blocks |
//! | [`mod@autocorrelation`] | whether residuals are correlated from reading to reading |
//! | [`minima`] | other starts, and other minima that fit as well |
//! | [`batch`] | Levenberg-Marquardt over all unknowns |
//! | [`conic`] | a step within bounds |
//! | [`covariance`] | what the estimate's uncertainty is |
//! | [`correlations`] | how the estimates hang together |
//! | [`farthest`] | where the readings stand that are the farthest from a bad fit |
//! | [`global`] | whether chi squared agrees with what is stated |
//! | [`redundancy`] | how far each reading is controlled by the others |
//! | [`refit`] | fits of nearly the same readings |
//! | [`observability`] | which combinations the data do not determine |
//! | [`withheld`] | which components are withheld for it |
//! | [`combination`] | which combinations are determined in spite of it |
//! | [`planned`] | campaigns some of whose runs are only planned |
//! | [`remedies`] | what would determine them, tried on the sums of the fit |
//! | `stationary` | parameters that act only by their square about their start |
//! | [`words`] | them in words |
//! | [`variance`] | levels of noise |
//! | `levels` | fits with levels estimated beside |
//! | [`calibrate`] | all of these together |
//! | `calibration` | what they say, as data |
//! | [`nested`] | a fit with effects against the one without |
//! | [`noise`] | for which noise uncertainties hold |
//! | [`noise_model`] | uncertainties where noise is not as stated |
//! | [`newton`] | each reading's own delay |
//! | [`delays`] | their means |
//! | `nearby` | the samples of readings, wherever they are |
//! | [`median`] | the median of numbers however many |
//! | [`transformation`] | where delays take their transformation from |
//! | [`deviations`] | planar, radial and tangential deviations of each run |
//! | [`head`] | what the instrument's head must follow: rates, speeds, reversals |
//! | [`between_runs`] | delays that differ between the runs for which they have one value |
//! | [`bias`] | what the paper's transformation does to delays |
//! | [`conventions`] | conventions that were mistaken, where the model fits badly |
//! | [`conditions`] | self-calibration: delays under changed conditions |
//! | `repeats` | readings that repeat the one before them bit for bit |
//! | [`mod@contradicted`] | which stated values the readings contradict |
//! | [`repeatability`] | whether several campaigns agree |
//! | `residuals` | residuals in the order of time, and readings that are far out |
//! | `sample_squares` | squared residuals of whole samples |
//! | `trimmed` | a fit that outliers do not bend |
//! | [`stream_bias`] | by how much the noise of streams biases estimates |
//! | [`systematic`] | what the inputs' calibration leaves open in them |
//! | [`blind`] | arm angles at which a measurand does not show its delay |
//! | [`budget`] | what the uncertainty of a delay is made of |
//! | [`coverage`] | coverage factors from degrees of freedom |
//! | [`differences`] | the seed's own way to the uncertainty of a delay, by differences over 1 ms |
//! | [`compare`] | both ways side by side |
//! | [`mod@unit_factors`] | scales that absorbed a wrong unit |
//! | [`mod@unrecorded`] | which accelerations the readings miss |

pub mod absorbed;
pub mod align;
pub mod arrow;
pub mod autocorrelation;
pub mod batch;
pub mod between_runs;
pub mod bias;
pub mod blind;
pub mod budget;
pub mod calibrate;
mod calibration;
pub mod checks;
mod cholesky;
pub mod circle;
pub mod combination;
pub mod compare;
pub mod conditions;
pub mod conic;
pub mod contradicted;
pub mod conventions;
pub mod correlations;
pub mod covariance;
pub mod coverage;
pub mod delays;
pub mod deviations;
pub mod differences;
pub mod eigen;
pub mod farthest;
pub mod global;
pub mod head;
pub mod intersection;
pub(crate) mod inverse_factor;
pub mod jumps;
pub(crate) mod levels;
pub mod linear_range;
pub mod median;
pub mod minima;
mod nearby;
pub mod nested;
pub mod newton;
pub mod noise;
pub mod noise_model;
pub mod observability;
pub mod overstated;
pub mod planned;
pub mod redundancy;
pub mod refit;
pub mod refused;
pub mod remedies;
pub mod repeatability;
pub(crate) mod repeats;
pub(crate) mod residuals;
mod sample_squares;
pub mod start;
mod stationary;
pub mod stream_bias;
pub mod systematic;
pub mod transformation;
pub(crate) mod trimmed;
pub mod unit_factors;
pub mod unrecorded;
pub mod variance;
pub mod withheld;
pub mod words;
