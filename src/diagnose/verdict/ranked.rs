//! Every effect that can be tested, best first, with the share that it explains.

use crate::diagnose::evidence::score::Score;
use crate::diagnose::found::Ranked;
use crate::diagnose::stage::Stage;

/// All testable effects, best first; one that may be there instead of a walk as it is without that.
/// `probability` is that of each candidate.
pub fn ranked(stage: &Stage, probability: &[f64]) -> Vec<Ranked> {
    let blocks = stage.blocks_found();
    let share = |number: usize, score: &Score| {
        let own = score.lambda().powi(2);
        let entry = stage.entry(number);
        let left = blocks.iter().map(|block| {
            let (gain, degrees) = stage.evidence.beyond(entry, stage.entry(*block));
            gain - degrees as f64
        });
        let left = left.fold(0.0, f64::max);
        if own > 0.0 { own / (own + left) } else { 0.0 }
    };
    let mut all: Vec<(usize, Ranked)> = (0..stage.effects)
        .filter(|n| stage.entry(*n).degrees() > 0)
        .map(|n| {
            let name = stage.candidates[n].name.clone();
            let instead = stage.noise_found.instead().find(|one| one.effect == name);
            let score = instead.map_or(stage.scores[n], |one| one.score);
            let member = stage.candidates[n].selected.member.clone();
            let (share, probability) = (share(n, &score), probability[n]);
            (n, Ranked { name, member, score, share, probability })
        })
        .collect();
    all.sort_by(|a, b| a.1.score.ln_p.total_cmp(&b.1.score.ln_p).then(a.0.cmp(&b.0)));
    all.into_iter().map(|(_, one)| one).collect()
}
