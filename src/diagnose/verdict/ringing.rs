//! What oscillates without being a steady wave of a run: what rings after each reversal, or where a
//! rig is shaken now and then. It passes for wild readings, or for noise that is larger than
//! stated.
//!
//! Residuals of a measurand are cut into pieces of equal duration, and their periodograms added up,
//! each over the scatter of its piece, so that noise which is larger at times is no matter. Of
//! noise without a memory each is exponentially distributed with the mean 1, and sums are gamma
//! distributed. What stands out between lower and higher frequencies rings; what falls or rises
//! from one end to the other is a memory that its model does not follow.

use std::f64::consts::TAU;

use nalgebra::Complex;

use crate::diagnose::evidence::thresholds::FALSE_ALARMS;
use crate::diagnose::library::place::Place;
use crate::diagnose::sequences::{Sequence, sequences};
use crate::diagnose::stage::Stage;
use crate::effect::Target;
use crate::engine::gauss_markov::NoiseClock;
use crate::library::Library;
use crate::statistics::ln_gamma_tail;

/// Samples in a piece: short ones for what dies away soon, long ones for what lasts.
const PIECES: [u32; 2] = [32, 128];
/// Readings that a piece has at least, and the part of its duration that they take.
const READINGS: f64 = 8.0;
const TAKEN: f64 = 0.5;
/// Part of the sampling rate up to which frequencies are looked at: near its half a wave is hardly
/// sampled.
const HIGHEST: f64 = 0.45;
/// The frequencies at either end, in parts of all.
const END: f64 = 0.125;
/// So many times the power at both ends, at least, is there where something rings.
const STANDS_OUT: f64 = 1.25;
/// Its probability by chance is at most this part of that of any false declaration.
const PART: f64 = 0.1;

/// What rings in the readings of a measurand.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) struct Ringing {
    pub(in crate::diagnose) place: Place,
    /// What it takes off the sum of squares, beyond chance.
    pub(in crate::diagnose) gain: f64,
}

/// What rings most in what a stage leaves; `None` where nothing does, and where stamps are rounded
/// or jitter: what they do may have a frequency, too.
pub(in crate::diagnose) fn ringing(stage: &Stage) -> Option<Ringing> {
    let noise = &stage.noise_found.effects;
    let mut names = noise.iter().flat_map(|one| one.aliases.iter().chain([&one.name]));
    if names.any(|name| is_of_stamps(stage, name)) {
        return None;
    }
    let problem = &stage.fitted.problem;
    let nothing = stage.evidence.together(&[]);
    let left = stage.evidence.left(problem, &stage.fitted.fit.point, &nothing, usize::MAX);
    let all = sequences(problem, &left);
    let mut best: Option<(Line, &str)> = None;
    let mut tests = 0;
    for (p, part) in problem.parts.iter().enumerate() {
        for (m, measurand) in part.system.assembly.names.measurands.iter().enumerate() {
            let own: Vec<&Sequence> =
                all.iter().filter(|one| (one.part, one.measurand) == (p, m)).collect();
            for spectrum in PIECES.into_iter().filter_map(|samples| Spectrum::of(&own, samples)) {
                tests += spectrum.powers.len() as u32;
                if let Some(line) = spectrum.line()
                    && best.as_ref().is_none_or(|(known, _)| line.ln_p < known.ln_p)
                {
                    best = Some((line, &measurand.name));
                }
            }
        }
    }
    let (Line { frequency, ln_p, gain }, measurand) = best?;
    let is_found = ln_p + f64::from(tests).ln() <= (PART * FALSE_ALARMS).ln();
    is_found.then(|| Ringing { place: Place::of_ringing(measurand, frequency), gain })
}

/// Whether an effect on the noise makes errors of stamps.
fn is_of_stamps(stage: &Stage, name: &str) -> bool {
    let libraries = stage.fitted.recipes.iter().map(|recipe| &recipe.library);
    let mut effects = libraries.flat_map(Library::effects).filter(|one| one.name == name);
    let is_of_time = |target: &Target| matches!(target, Target::AllTimes | Target::Time(_));
    effects.any(|one| one.patches.iter().any(|line| is_of_time(&line.target)))
}

/// What stands out of a spectrum.
struct Line {
    /// In Hz.
    frequency: f64,
    /// Logarithm of its probability by chance, of one frequency.
    ln_p: f64,
    gain: f64,
}

/// Mean periodograms of pieces of equal duration.
struct Spectrum {
    /// The lowest frequency (Hz), of which the others are multiples.
    first: f64,
    /// The sum of powers at each, and how many pieces it is of.
    powers: Vec<(f64, f64)>,
}

impl Spectrum {
    /// Of pieces of so many samples at the median interval; `None` where there are none.
    fn of(all: &[&Sequence], samples: u32) -> Option<Self> {
        let interval = all.first()?.interval(NoiseClock::Stamps)?;
        let mut spectrum = Self::new(samples, interval);
        for one in all {
            for (run, times) in one.runs.iter().zip(one.times(NoiseClock::Stamps)) {
                spectrum.add(run, times);
            }
        }
        spectrum.powers.iter().any(|one| one.1 > 0.0).then_some(spectrum)
    }

    /// Of nothing yet.
    fn new(samples: u32, interval: f64) -> Self {
        let first = (f64::from(samples) * interval).recip();
        Self { first, powers: vec![(0.0, 0.0); samples as usize / 2] }
    }

    /// Adds the periodograms of a run's pieces.
    fn add(&mut self, run: &[f64], times: &[f64]) {
        let duration = self.first.recip();
        let mut from = 0;
        while from < times.len() {
            let end = times[from] + duration;
            let to = from + times[from..].partition_point(|time| *time < end).max(1);
            self.add_piece(&run[from..to], &times[from..to]);
            from = to;
        }
    }

    /// Adds the periodogram of a piece, as far as its samples tell frequencies.
    fn add_piece(&mut self, values: &[f64], times: &[f64]) {
        let present = || values.iter().zip(times).filter(|(value, _)| !value.is_nan());
        let (count, squares) = present().fold((0.0, 0.0), |(count, squares), (value, _)| {
            (count + 1.0, squares + value * value)
        });
        let (Some(start), Some(end)) = (times.first(), times.last()) else { return };
        let taken = (end - start) * self.first;
        if count < READINGS || taken < TAKEN || squares <= 0.0 {
            return;
        }
        let highest = ((HIGHEST * count) as usize).min(self.powers.len());
        let mut sums = vec![Complex::new(0.0, 0.0); highest];
        for (value, time) in present() {
            let turn = Complex::cis(TAU * self.first * (time - start));
            let mut phase = turn;
            for sum in &mut sums {
                *sum += phase * *value;
                phase *= turn;
            }
        }
        for (power, sum) in self.powers.iter_mut().zip(sums) {
            power.0 += sum.norm_sqr() / squares;
            power.1 += 1.0;
        }
    }

    /// What stands out most between both ends.
    fn line(&self) -> Option<Line> {
        let counted: Vec<(usize, f64, f64)> = (1..)
            .zip(&self.powers)
            .filter(|(_, one)| one.1 > 0.0)
            .map(|(multiple, (power, pieces))| (multiple, *power, *pieces))
            .collect();
        let end = (END * counted.len() as f64).ceil() as usize;
        if counted.len() <= 2 * end {
            return None;
        }
        let mean = |some: &[(usize, f64, f64)]| {
            let (power, pieces) =
                some.iter().fold((0.0, 0.0), |sums, one| (sums.0 + one.1, sums.1 + one.2));
            power / pieces
        };
        let (low, high) = (&counted[..end], &counted[counted.len() - end..]);
        let ends = mean(low).max(mean(high)).max(1.0);
        let ln_p = |one: &(usize, f64, f64)| ln_gamma_tail(one.2, one.1 / ends);
        let between = &counted[end..counted.len() - end];
        let at =
            (0..between.len()).min_by(|a, b| ln_p(&between[*a]).total_cmp(&ln_p(&between[*b])))?;
        let (multiple, power, pieces) = between[at];
        if power < STANDS_OUT * ends * pieces {
            return None;
        }
        // Its neighbours belong to it as far as they stand out.
        let beyond = |one: &&(usize, f64, f64)| one.1 - ends * one.2;
        let is_out = |one: &&(usize, f64, f64)| beyond(one) > (one.2).sqrt() * ends;
        let below = between[..at].iter().rev().take_while(is_out);
        let line = between[at..].iter().take_while(is_out).chain(below);
        // A cosine and a sine each.
        let gain = 2.0 * line.map(|one| beyond(&one)).sum::<f64>();
        let frequency = multiple as f64 * self.first;
        Some(Line { frequency, ln_p: ln_p(&between[at]), gain })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    /// The likeliest line of either spectrum of twenty runs of 40 s, every 0.1 s or so.
    fn heard(seed: u64, mut value: impl FnMut(&mut Stream, f64) -> f64) -> Option<Line> {
        let mut noise = Stream(seed);
        let mut both = PIECES.map(|samples| Spectrum::new(samples, 0.1));
        for _ in 0..20 {
            let times: Vec<f64> =
                (0..400).map(|n| 0.1 * f64::from(n) + 0.02 * noise.uniform()).collect();
            let run: Vec<f64> = times.iter().map(|time| value(&mut noise, *time)).collect();
            both.iter_mut().for_each(|one| one.add(&run, &times));
        }
        let tests: usize = both.iter().map(|one| one.powers.len()).sum();
        let lines = both.iter().filter_map(Spectrum::line);
        let best = lines.min_by(|a, b| a.ln_p.total_cmp(&b.ln_p));
        best.filter(|one| one.ln_p + (tests as f64).ln() <= (PART * FALSE_ALARMS).ln())
    }

    #[test]
    fn noise_of_any_kind_does_not_ring() {
        for seed in 0..60 {
            assert!(heard(seed, |noise, _| noise.normal()).is_none(), "{seed}");
            // Larger at times.
            let larger = |noise: &mut Stream, time: f64| noise.normal() * (0.3 * time).sin().exp();
            assert!(heard(seed, larger).is_none(), "{seed}");
            let wild = |noise: &mut Stream, _| {
                if noise.uniform() < 0.02 { 20.0 } else { noise.normal() }
            };
            assert!(heard(seed, wild).is_none(), "{seed}");
            // Like what was there before, and unlike it.
            for memory in [0.7, 0.97, -0.5] {
                let mut last = 0.0;
                let remembers = |noise: &mut Stream, _| {
                    last = memory * last + noise.normal();
                    last
                };
                assert!(heard(seed, remembers).is_none(), "{seed} {memory}");
            }
            let holey = |noise: &mut Stream, _| {
                if noise.uniform() < 0.4 { f64::NAN } else { noise.normal() }
            };
            assert!(heard(seed, holey).is_none(), "{seed}");
        }
    }

    #[test]
    fn what_rings_after_each_push_has_its_frequency() {
        for seed in 0..10 {
            let (mut next, mut pushed) = (0.0, 0.0);
            let rings = |noise: &mut Stream, time: f64| {
                if time < pushed {
                    (next, pushed) = (0.0, 0.0);
                }
                if time > next {
                    (pushed, next) = (time, time + 2.0 + 4.0 * noise.uniform());
                }
                let since = time - pushed;
                noise.normal() + 3.0 * (-since / 0.7).exp() * (TAU * 1.9 * since).sin()
            };
            let line = heard(seed, rings);
            let line = line.as_ref().map(|one| (one.frequency, one.gain.sqrt()));
            // Its length is that of 3 exp(-t / 0.7) sin() over some 2000 pushes of twenty runs.
            assert!(
                line.is_some_and(
                    |(at, long)| (at - 1.9).abs() < 0.2 && (25.0..80.0).contains(&long)
                ),
                "{seed} {line:?}"
            );
        }
    }

    #[test]
    fn of_few_readings_nothing_is_said() {
        let mut spectrum = Spectrum::new(32, 0.1);
        spectrum.add(&[], &[]);
        spectrum.add(&[1.0; 7], &[0.0, 0.4, 0.8, 1.2, 1.6, 2.0, 2.4]);
        spectrum.add(&[0.0; 32], &[0.1; 32]);
        spectrum.add(&[f64::NAN; 40], &std::array::from_fn::<f64, 40, _>(|n| 0.1 * n as f64));
        assert!(spectrum.line().is_none() && spectrum.powers.iter().all(|one| one.1 == 0.0));
    }
}
