//! The thresholds of evidence, with their meaning and unit; docs/diagnosis.md has the measurements
//! that chose them. Limits of effort (rounds, bins) stand with what they limit.

/// Log Bayes factor from which a term enters, and below which it leaves. Clean campaigns: 0 of 148
/// had a term.
pub const ENTER: f64 = 5.0;
/// Log Bayes factor within which two terms are aliases.
pub const TIE: f64 = 3.0;
/// Log evidence by which effects beside a block that was taken out must be better than the block.
pub const SWAP: f64 = 1.0;
/// Rise of twice the log predictive density of held-out readings that a row must bring: twice
/// [`ENTER`].
pub const HELD_OUT: f64 = 2.0 * ENTER;
/// Gain of any row (noncentrality 8): an imitator of less leaves nothing that would show.
pub const ROW: f64 = 64.0;
/// Gain of a row beside a remainder (noncentrality 12): the remainder says that the library lacks
/// something.
pub const ROW_BESIDE_REMAINDER: f64 = 144.0;
/// Share of the remainder's gain that a row must have: basis blocks leave so much to imitators.
pub const SHARE_OF_REMAINDER: f64 = 0.03;
/// Share of the squared length of the form of a user's own effect that a block leaves, below which it
/// contains that form.
pub const OWN_SHARE: f64 = 0.12;
/// Chi squared of the value of a row beside whole blocks, below which it is consistent with zero; of
/// several values that of the same probability.
pub const ZERO: f64 = 9.0;
/// The same of an effect of the user's own, which blocks of its form do not replace.
pub const ZERO_OF_OWN: f64 = 25.0;
/// Log Bayes factor of separate values of a row by setup, angle, rate or sense, from which it is not one
/// cause.
pub const APART: f64 = 2.5;
/// ... and the share of the row's gain that they must gain: linear forms are good to so much.
pub const APART_SHARE: f64 = 0.01;
/// ... and their share of all that the model explains.
pub const APART_OF_ALL: f64 = 1e-3;
/// Log evidence by which blocks in the place of a small row must be worse.
pub const MARGIN: f64 = 8.0;
/// Share of the remainder's gain below which a row is small.
pub const SMALL_ROW: f64 = 0.1;
/// Share of the only row's gain that a remainder has from which the two may be one unmodelled cause...
pub const LONE_SHARE: f64 = 0.2;
/// ... unless fewer terms without the row are worse by so much log evidence. Withheld effects: 3 to 37.
pub const LONE_MARGIN: f64 = 40.0;
/// Blocks that may stand in the place of a row.
pub const BLOCKS_FOR_A_ROW: usize = 3;
/// Gain from which a change point is fitted: where the model is linear to 5 %, less than five standard
/// deviations are left of a smaller one.
pub const LARGE_CHANGE: f64 = 1e4;
/// Rows at most.
pub const MOST_ROWS: usize = 12;
/// Robust standard deviations from which a reading is an outlier, and standard scores from which
/// jitter and autocorrelation are found.
pub const NOISE: f64 = 5.0;
/// Standard uncertainties by which a reading must vary to be a covariate.
pub const STILL: f64 = 30.0;
/// Standard score from which residuals of neighbouring inputs are alike.
pub const NEIGHBOURS: f64 = 6.0;
/// Factor between the robust scatter of a run and of the others from which its noise is its own.
pub const NOISE_OF_A_RUN: f64 = 1.3;
/// Part of what the noise of smoothed streams adds to a score within which that is known: it follows
/// from one draw of noise as large as the scatter of the raw values. With 0 an eighth to a quarter of
/// the false remainders of clean gyroscopes stayed.
pub const STREAM_NOISE: f64 = 0.5;
/// Correlation of two terms from which they are confounded and reported as a group.
pub const CONFOUNDED: f64 = 0.95;
/// Squared cosine of the form of an effect outside the fit with a row's, from which it is a near
/// alias: the row's uncertainty allows for it.
pub const NEAR_ALIAS: f64 = 0.8;
/// The same of an effect that is there more probably than not, though it has no place in the model.
pub const IN_PART: f64 = 0.25;
/// Standard score from which a noise scale factor is not as stated...
pub const SCALE: f64 = 4.0;
/// ... and its least difference from 1.
pub const SCALE_DIFFERENCE: f64 = 0.02;
/// Fewer outliers are those of a normal distribution...
pub const OUTLIERS: usize = 3;
/// ... unless they are beyond so many robust standard deviations (1e-15 of a normal distribution).
pub const LONE_OUTLIER: f64 = 8.0;
/// Probability of lost samples that are none, over a campaign.
pub const LOST: f64 = 1.0 / 300.0;
/// Largest rate error of a clock (1) and delay or time constant of a servo (s) that effects of the
/// library may have: larger values are refused.
pub const LARGEST_RATE: f64 = 0.1;
/// See [`LARGEST_RATE`].
pub const LARGEST_DELAY: f64 = 1.0;
/// The same of other dimensionless values whose typical size is below [`LARGEST_RATE`]: scales beyond
/// it are another unit, or a mirrored frame.
pub const LARGEST_SCALE: f64 = 0.5;
/// How many times as probable as one of the library an effect of the user's own is: whoever writes a
/// file for it suspects it.
pub const OWN_EFFECT: f64 = 20.0;
/// Log prior odds against a relaxed form of an effect: one in twenty.
pub const RELAXED: f64 = 3.0;
/// Log evidence by which blocks in the place of a row with values of setups must be worse.
/// Withheld effects: 0 to 44.
pub const RELAXED_MARGIN: f64 = 80.0;
/// Gain that an effect may have without entering a budget, about.
pub const BELOW_ENTRY: f64 = 25.0;
/// Noise scale factor beyond which residuals are no noise: something is there, whatever form it
/// has.
pub const FAR_BEYOND_STATED: f64 = 5.0;
