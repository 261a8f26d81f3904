//! Runs whose samples lie outside their streams. It is judged when all runs are read: the stream that
//! belongs to a run may be that of another one.

use crate::campaign::declared::RunEntry;
use crate::campaign::delay_range::DelayRange;
use crate::campaign::signal::Track;
use crate::campaign::spline::{Spline, mean_spacing};
use crate::campaign::time_units::{
    Stamps, counted_in, covered_in_parts, other_unit, other_unit_since_1970,
};
use crate::diagnostic::{Diagnostic, Span, decimals};
use crate::model::InputDeclaration;
use crate::units::decimal;

/// Inputs of which a message says where their streams lie.
const MOST_HELD: usize = 3;

/// Where the samples and the streams of a run lie. Times are in seconds, as the files have them.
pub(crate) struct Streamed {
    run: String,
    /// Where the campaign names its first stream.
    pub(crate) span: Span,
    files: Vec<String>,
    /// Samples outside the streams, and all of them.
    pub(crate) counts: (usize, usize),
    samples: (f64, f64),
    /// What all streams cover; `None` without streams.
    streams: Option<(f64, f64)>,
    held: Vec<String>,
    /// The longest mean time (s) between values of a stream.
    spacing: f64,
    has_gaps: bool,
    /// The stamps of its files.
    pub(crate) stamps: Vec<Stamps>,
}

impl Streamed {
    /// What is known of a run; nothing of it is outside yet. Times in it count from `zero`.
    pub(crate) fn new(
        entry: &RunEntry,
        (inputs, declared): (&[Track], &[InputDeclaration]),
        samples: Option<(f64, f64)>,
        zero: f64,
    ) -> Self {
        let logged = inputs.iter().zip(declared).filter_map(|(track, input)| match track {
            Track::Logged(spline) => Some((input.name.as_str(), spline.as_ref())),
            _ => None,
        });
        let spans = logged.clone().map(|(_, spline)| spline.span());
        let shifted = |(from, to): (f64, f64)| (from + zero, to + zero);
        Self {
            run: entry.name.text.clone(),
            span: entry.signals.first().map_or(entry.name.span, |stream| stream.name.span),
            files: entry.signals.iter().map(|stream| stream.name.text.clone()).collect(),
            counts: (0, 0),
            samples: shifted(samples.unwrap_or_default()),
            streams: spans.reduce(|a, b| (a.0.max(b.0), a.1.min(b.1))).map(shifted),
            spacing: logged
                .clone()
                .map(|(_, spline)| mean_spacing(&spline.knots))
                .fold(0.0, f64::max),
            has_gaps: logged.clone().any(|(_, spline)| spline.gaps().0 > 0),
            held: logged.take(MOST_HELD).map(|(name, spline)| held(name, spline, zero)).collect(),
            stamps: Vec::new(),
        }
    }

    /// Whether most samples lie outside the streams.
    pub(crate) fn is_outside(&self) -> bool {
        2 * self.counts.0 > self.counts.1
    }

    /// The warning of streams that cover the samples only because their times are in a smaller unit than
    /// stated: in that they would last as long, and begin and end with the samples, and as stated their
    /// values are farther apart than the samples.
    pub(crate) fn in_smaller_unit(&self) -> Option<Diagnostic> {
        let (streams, (first, last)) = (self.streams?, self.samples);
        let times = (last - first) / (streams.1 - streams.0);
        let of_samples = (last - first) / self.counts.1 as f64;
        let is_doubtful = times > 0.0
            && times < 1.0
            && self.spacing > of_samples
            && covered_in_parts(self.samples, streams) > MOSTLY;
        let (doubt, remedy) = other_unit(&self.stamps, times).filter(|_| is_doubtful)?;
        Some(Diagnostic::warning(format!("run `{}`: {doubt}", self.run)).help(remedy))
    }

    /// The fault of such a run: what is wrong, and what to do. `all` are all runs.
    pub(crate) fn words(&self, all: &[Self], delay_range: &DelayRange) -> (String, String) {
        let (outside, count) = self.counts;
        let message = format!(
            "{outside} of {count} samples of run `{}` lie outside its streams, or in gaps of them",
            self.run
        );
        let even = match self.has_gaps {
            true => {
                "; a stream that is logged only when its value changes has gaps: log it at an even rate"
            }
            false => "",
        };
        let help = format!(
            "the samples go from {} s to {} s, the streams hold {}; a margin of delay_range = {} is kept{even}{}",
            decimals(self.samples.0, 3),
            decimals(self.samples.1, 3),
            self.held.join(", "),
            delay_range.written(|text| format!("\"{text}\"")),
            self.proposed(all)
        );
        (message, help)
    }

    /// Whether its streams cover these samples.
    fn covers(&self, (first, last): (f64, f64)) -> bool {
        self.streams.is_some_and(|(from, to)| from <= first && last <= to)
    }

    /// What to write where samples and streams last so differently that their times are in different
    /// units, where the streams are those of another run, where clocks are so far apart that no sample
    /// lies within the streams, and where the margin is larger than that of some that do.
    fn proposed(&self, others: &[Self]) -> String {
        let ((first, last), Some((from, to))) = (self.samples, self.streams) else {
            return String::new();
        };
        let are_apart = last < from || first > to;
        if let Some(words) = other_unit_since_1970(&self.stamps).filter(|_| are_apart) {
            return format!("; {words}");
        }
        let times = (last - first) / (to - from);
        if let Some((doubt, remedy)) = other_unit(&self.stamps, times).filter(|_| times > 0.0) {
            return format!("; {doubt} {remedy}");
        }
        let spacing = (last - first) / self.counts.1 as f64;
        let of_streams = ((from, to), self.spacing);
        if let Some(words) = counted_in(&self.stamps, (self.samples, spacing), of_streams) {
            let apart =
                if are_apart { far_clocks((first, last), (from, to)) } else { String::new() };
            return format!("; {words}{apart}");
        }
        // Most of the samples would be within the streams.
        if 2.0 * (last.min(to) - first.max(from)) > last - first {
            return "; a smaller delay_range keeps a smaller margin, and a pair for clocks that differ to one side, as in [\"0 s\", \"2 s\"], one at one end".to_owned();
        }
        let are_all_outside = self.counts.0 == self.counts.1;
        if !are_all_outside || !are_apart {
            return String::new();
        }
        if let Some(words) = self.of_another_run(others) {
            return format!("; {words}");
        }
        far_clocks((first, last), (from, to))
    }

    /// Whether another run has a stream that covers these samples, or the same stream for samples
    /// that it does cover.
    fn of_another_run(&self, others: &[Self]) -> Option<String> {
        let mut all = others.iter().filter(|other| other.run != self.run);
        let is_other = |other: &Self| !other.files.iter().any(|file| self.files.contains(file));
        if let Some(other) = all.clone().find(|other| other.covers(self.samples) && is_other(other))
        {
            return Some(format!(
                "`{}` of run `{}` covers these samples: are the files of the two runs exchanged?",
                other.files.join("`, `"),
                other.run
            ));
        }
        let other = all.find(|other| other.files == self.files && other.covers(other.samples))?;
        Some(format!(
            "`{}` is given for run `{}`, too, and covers its samples: is there another file for run `{}`?",
            self.files.join("`, `"),
            other.run,
            self.run
        ))
    }
}

/// The part of samples that streams in another unit would cover, at least.
const MOSTLY: f64 = 0.5;
/// Half the range of delays (s) that is proposed where clocks are far apart, at least, or this part of
/// how long the samples last.
const LEAST_APART: f64 = 5.0;
const PART_APART: f64 = 0.125;
/// Time zones are halves of an hour (s) apart, so many at most; recordings of one motion begin within
/// so much (s) of each other.
const HALF_AN_HOUR: f64 = 1800.0;
const MOST_HALVES: f64 = 28.0;
const ALIKE: f64 = 60.0;

/// The range of delays that is proposed where no sample lies within the streams.
fn far_clocks((first, last): (f64, f64), (from, to): (f64, f64)) -> String {
    let (low, high) = ((from - first).min(to - last), (from - first).max(to - last));
    let middle = 0.5 * (low + high);
    let least = LEAST_APART.min(PART_APART * (last - first));
    let half = (0.5 * (high - low)).max(least);
    let places = if half >= 1.0 { 0 } else { 2 };
    let [low, high] = [middle - half, middle + half].map(|at| decimal(at, places));
    let halves = (middle / HALF_AN_HOUR).round();
    let zone = (middle - halves * HALF_AN_HOUR).abs() <= half.max(ALIKE)
        && halves != 0.0
        && halves.abs() <= MOST_HALVES;
    let zone = match zone {
        true => format!(" ({} h: a time zone?)", 0.5 * halves.abs()),
        false => String::new(),
    };
    format!("; if their clocks are apart{zone}, write delay_range = [\"{low} s\", \"{high} s\"]")
}

/// What a stream holds of an input, in words.
fn held(name: &str, spline: &Spline, zero: f64) -> String {
    let ((from, to), (gaps, longest)) = (spline.span(), spline.gaps());
    let (from, to) = (from + zero, to + zero);
    let [from, to, longest] = [from, to, longest].map(|time| decimals(time, 3));
    let gaps = match gaps {
        0 => String::new(),
        1 => format!(" with a gap of {longest} s"),
        _ => format!(" with {gaps} gaps of up to {longest} s"),
    };
    format!("`{name}` from {from} s to {to} s{gaps}")
}
