//! The verdict of `diagnose` in a sentence that can be read aloud.

use crate::diagnose::Diagnosis;
use crate::diagnose::budget::answer::{FAR_BEYOND_STATED, Remainder, Verdict};
use crate::diagnose::gap::Gap;
use crate::report::figure;
use crate::report::text::{residual_unit, unit_of};
use crate::units::decimal;

/// The sentence, and one more where held-out readings say otherwise.
pub(super) fn sentence(diagnosis: &Diagnosis) -> String {
    let is_borne_out = diagnosis.gap.as_ref().and_then(Gap::is_borne_out);
    let but =
        if is_borne_out == Some(false) { " Held-out readings do not support it." } else { "" };
    let mistaken = diagnosis.mistaken.as_ref();
    let alike = mistaken.and_then(|one| one.stated.as_ref()).map_or_else(String::new, |name| {
        format!(" A mistaken convention explains as much as a wrong stated value of `{name}`.")
    });
    format!("{}{but}{alike}", of_campaign(diagnosis))
}

fn of_campaign(diagnosis: &Diagnosis) -> String {
    let free = diagnosis.set_free.as_ref();
    let free = free.map_or_else(String::new, |name| format!("with `{name}` free, "));
    let rows = match diagnosis.rows.len() {
        1 => format!("{free}`{}` closes", diagnosis.rows[0].name),
        count => format!("{free}{count} effects close"),
    };
    let closed = closed(diagnosis);
    let still = still(diagnosis);
    match diagnosis.verdict {
        Verdict::Adequate if diagnosis.nominal.degrees_of_freedom() <= 0 => {
            "Adequate, but nothing is tested: there are no more readings than parameters."
                .to_owned()
        }
        Verdict::Adequate => match largest_scale(diagnosis) {
            Some((name, factor)) => format!(
                "Adequate: no effect and no unmodelled structure is found; `{name}` scatters {} times as much as stated.",
                decimal(factor, 2)
            ),
            None => {
                "Adequate: the residuals are consistent with noise as stated; no effect is found."
                    .to_owned()
            }
        },
        Verdict::Explained if diagnosis.rows.is_empty() => {
            let names: Vec<String> =
                diagnosis.noise.iter().map(|one| format!("`{}`", one.name)).collect();
            let is_less = !diagnosis.left_out.is_empty();
            let left_out = is_less.then(|| "readings that are left out".to_owned());
            let correlated =
                (!diagnosis.autocorrelation.is_empty()).then(|| "autocorrelated noise".to_owned());
            let of_runs = diagnosis.levels.iter().any(|one| one.run.is_some());
            let of_runs = of_runs.then(|| "noise that differs between runs".to_owned());
            let noise = names.into_iter().chain(correlated).chain(of_runs);
            let what: Vec<String> = noise.chain(left_out).collect();
            format!("Explained by {}; the residuals are consistent with that.", what.join(" and "))
        }
        Verdict::Explained => {
            format!(
                "Explained: {rows} {closed} of the gap on held-out readings{still}; the residuals are consistent with {}.",
                noise(diagnosis)
            )
        }
        Verdict::PartlyExplained => format!(
            "Partly explained: {rows} {closed} of the gap on held-out readings{still}; {}.",
            looks(&diagnosis.remainder, "the remainder")
        ),
        Verdict::Unknown if diagnosis.is_misread() => {
            "Unknown: numbers were read in another convention than they were written in.".to_owned()
        }
        Verdict::Unknown
            if diagnosis.remainder.iter().all(|one| one.place.covariate == "scatter") =>
        {
            let (name, factor) =
                largest_scale(diagnosis).unwrap_or(("a reading", FAR_BEYOND_STATED));
            format!(
                "Unknown: `{name}` scatters {} times as much as stated, which is no noise; no effect and no covariate explains it.",
                decimal(factor, 1)
            )
        }
        Verdict::Unknown => {
            let has_form = |one: &Remainder| one.place.is_effect() || nearest(one).is_some();
            format!(
                "Unknown: there is a gap{}; {}.",
                match diagnosis.remainder.iter().any(has_form) {
                    true => ", and no effect is identified",
                    false => " that no effect of the library explains",
                },
                looks(&diagnosis.remainder, "it")
            )
        }
        Verdict::Unobservable => {
            "No diagnosis: these readings do not determine the model's own parameters.".to_owned()
        }
        Verdict::NotConverged => {
            "No diagnosis: the fit of the model's own parameters did not converge.".to_owned()
        }
    }
}

fn closed(diagnosis: &Diagnosis) -> String {
    let closed = diagnosis.gap.as_ref().map(|gap| gap.closed);
    closed.map_or_else(|| "a part".to_owned(), |part| format!("{:.0} %", 100.0 * part))
}

/// The rms of residuals is still large where it exceeds that of noise so many times.
const STILL: f64 = 2.0;

/// That the rms of a measurand is still large: the part of the gap that is closed is one of held-out readings.
fn still(diagnosis: &Diagnosis) -> String {
    let Some(gap) = &diagnosis.gap else { return String::new() };
    let times = gap.after.iter().filter_map(|(name, after)| {
        let (_, floor) = gap.floor.iter().find(|(other, _)| other == name)?;
        Some((name, *after, after / floor))
    });
    let largest = times.filter(|one| one.2.is_finite()).max_by(|a, b| a.2.total_cmp(&b.2));
    largest.filter(|one| one.2 > STILL).map_or_else(String::new, |(name, after, times)| {
        let unit = residual_unit(after, &unit_of(&diagnosis.nominal, name));
        format!(
            ", but the rms of `{name}` is still {}, {} times that of noise",
            figure::size(after, &unit),
            decimal(times, 1)
        )
    })
}

/// So many parts of the remainder, of which the largest is no larger a part, are of one cause that has
/// no simple form, or of many.
const MANY: usize = 6;
const SMALL: f64 = 0.3;

/// What the remainder is.
fn looks(remainder: &[Remainder], what: &str) -> String {
    let all: f64 = remainder.iter().map(|one| one.share).sum();
    let most = remainder.first().map_or(0.0, |one| one.share);
    let first = first(remainder);
    if remainder.len() >= MANY && most < SMALL * all {
        format!("{what} has no simple form, its largest part looks like {first}")
    } else {
        format!("{what} looks like {first}")
    }
}

fn first(remainder: &[Remainder]) -> String {
    let Some(first) = remainder.first() else { return "nothing that has a location".to_owned() };
    let words = &first.place.words;
    nearest(first).map_or_else(
        || words.clone(),
        |(name, share)| format!("{words} (nearest: `{name}`, {:.0} %)", 100.0 * share),
    )
}

/// Share of the gain of a part of the remainder from which its nearest effect has its form.
const SAME_FORM: f64 = 0.9;

/// The effect that has the form of a part of the remainder.
fn nearest(part: &Remainder) -> Option<(&str, f64)> {
    let (name, share) = part.nearest.as_ref()?;
    (*share >= SAME_FORM).then_some((name, *share))
}

/// A noise scale factor from which the sentence has it.
const LARGER: f64 = 1.2;

/// The noise beside the rows, where it is not as stated.
fn noise(diagnosis: &Diagnosis) -> String {
    let is_correlated = !diagnosis.autocorrelation.is_empty();
    let noise = if is_correlated { "autocorrelated noise" } else { "noise" };
    let larger = largest_scale(diagnosis).filter(|(_, factor)| *factor >= LARGER);
    larger.map_or_else(
        || noise.to_owned(),
        |(name, factor)| {
            format!("{noise} that is {} times as large in `{name}` as stated", decimal(factor, 2))
        },
    )
}

/// The largest noise scale factor above one.
fn largest_scale(diagnosis: &Diagnosis) -> Option<(&str, f64)> {
    let above = diagnosis.levels.iter().filter(|one| one.factor > 1.0);
    let most = above.max_by(|a, b| a.factor.total_cmp(&b.factor))?;
    Some((&most.measurand, most.factor))
}
