//! What recorded trials have otherwise when they are made again, for people.

use crate::report::layout::{drawn, table};
use crate::report::trials_replay::Replayed;
use crate::trials::bound::Count;
use crate::trials::difference::Difference;
use crate::trials::paired::{LEVEL, Summary};

/// The comparison; a line for each difference, or tables of scores.
pub fn text(title: &str, replayed: &Replayed) -> String {
    match replayed {
        Replayed::Each { trials, total, changed } => {
            let mut text = format!("{title}\n\n");
            for one in changed {
                for difference in &one.differences {
                    let Difference { field, recorded, replayed } = difference;
                    let (trial, truth) = (one.trial, one.truth.trim_end_matches(": "));
                    text.push_str(&format!(
                        "trial {trial} ({truth}): {field}: {recorded} -> {replayed}\n"
                    ));
                }
            }
            let equal = trials - changed.len();
            let (of, differ) = (format!("{trials} replayed trials"), changed.len());
            text.push_str(&format!(
                "{equal} of {of} are equal, {differ} differ ({total} recorded)\n"
            ));
            text
        }
        Replayed::Summary { summary, total } => summary_text(title, summary, *total),
    }
}

fn summary_text(title: &str, summary: &Summary, total: usize) -> String {
    let mut text = format!("{title}\n\n{} trials of {total} recorded ones", summary.trials);
    if summary.other > 0 {
        text.push_str(&format!("; {} more are other ones now and left out", summary.other));
    }
    text.push_str("\n\n");
    let mut rows = table(&["rate", "recorded", "replayed", "lost", "gained", "p", "trials", ""]);
    for one in &summary.rates {
        rows.add_row([
            one.name.clone(),
            percent(one.recorded),
            percent(one.replayed),
            one.lost.to_string(),
            one.gained.to_string(),
            format!("{:.3}", one.p),
            one.recorded.trials.to_string(),
            worse(one.is_worse()),
        ]);
    }
    text.push_str(&drawn(&rows));
    if !summary.means.is_empty() {
        let mut rows = table(&["score", "recorded", "replayed", "may rise by", "trials", ""]);
        for one in &summary.means {
            rows.add_row([
                one.name.to_owned(),
                format!("{:.4}", one.recorded),
                format!("{:.4}", one.replayed),
                format!("{:.4}", one.bound),
                one.trials.to_string(),
                worse(one.is_worse()),
            ]);
        }
        text.push_str(&format!("\n{}", drawn(&rows)));
    }
    let mut rows = table(&["verdict", "recorded", "replayed"]);
    for (verdict, (recorded, replayed)) in &summary.verdicts {
        rows.add_row([verdict.clone(), recorded.to_string(), replayed.to_string()]);
    }
    text.push_str(&format!("\n{}", drawn(&rows)));
    let percent = 100.0 * LEVEL;
    text.push_str(&if summary.is_worse() {
        format!("\nworse than recorded (one-sided tests of the same trials at {percent} %)\n")
    } else {
        format!("\nno score is worse (one-sided tests of the same trials at {percent} %)\n")
    });
    text
}

fn worse(is_worse: bool) -> String {
    if is_worse { "worse".to_owned() } else { String::new() }
}

fn percent(count: Count) -> String {
    count.rate().map_or_else(String::new, |rate| format!("{:.1} %", 100.0 * rate))
}
