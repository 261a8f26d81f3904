//! What of a recorded trial a replay has otherwise, field by field.
//!
//! Only fields that both have are compared. Words and names must be the same; probabilities may
//! differ by [`TOLERANCE`], sizes by that part of the larger of value and standard uncertainty.

use super::outcome::Outcome;
use super::outcome::findings::{EffectSize, Excluded, Location, Value};

/// Largest difference of equal numbers.
pub const TOLERANCE: f64 = 1e-6;

/// A field that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Its name in the file of trials.
    pub field: &'static str,
    /// As recorded.
    pub recorded: String,
    /// As replayed.
    pub replayed: String,
}

impl Difference {
    fn new(field: &'static str, recorded: String, replayed: String) -> Self {
        Self { field, recorded, replayed }
    }
}

/// All fields that differ: those of the truth first, for nothing else counts where these do.
pub fn differences(recorded: &Outcome, replayed: &Outcome) -> Vec<Difference> {
    let truth = truth(recorded, replayed);
    if !truth.is_empty() {
        return truth;
    }
    let text = |field, of: fn(&Outcome) -> Option<String>| {
        let (a, b) = (of(recorded)?, of(replayed)?);
        (a != b).then(|| Difference::new(field, a, b))
    };
    let number = |field, of: fn(&Outcome) -> Option<f64>| {
        let (a, b) = (of(recorded), of(replayed));
        let is_same = match (a, b) {
            (Some(a), Some(b)) => is_close(a, b, 1.0),
            (a, b) => a.is_none() && b.is_none(),
        };
        let show = |one: Option<f64>| one.map_or_else(|| "none".to_owned(), |one| one.to_string());
        (!is_same).then(|| Difference::new(field, show(a), show(b)))
    };
    let sizes = recorded.sizes.as_ref().zip(replayed.sizes.as_ref());
    let sizes = sizes.filter(|(a, b)| !are_close(a, b));
    let fields = [
        text("verdict", |one| Some(one.verdict.clone())),
        text("named", |one| Some(list(&one.named))),
        text("noise", |one| Some(list(&one.noise))),
        number("confidence", |one| one.confidence),
        number("brier", |one| one.brier),
        text("failed", |one| Some(one.failed.clone().unwrap_or_else(|| "no".to_owned()))),
        text("reason", |one| one.reason.clone()),
        text("location", |one| Some(locations(one.location.as_ref()?))),
        sizes.map(|(a, b)| Difference::new("sizes", shown(a), shown(b))),
        text("excluded", |one| Some(counts(one.excluded.as_ref()?))),
    ];
    fields.into_iter().flatten().collect()
}

/// What was put in is not what was recorded: the trial is another one.
pub fn truth(recorded: &Outcome, replayed: &Outcome) -> Vec<Difference> {
    let of = |one: &Outcome| format!("{}: {}", one.kind, one.truth());
    let what = [
        ("seed", recorded.seed.to_string(), replayed.seed.to_string()),
        ("effects", of(recorded), of(replayed)),
    ];
    let differs = what.into_iter().filter(|(_, a, b)| a != b);
    differs.map(|(field, a, b)| Difference::new(field, a, b)).collect()
}

fn is_close(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= TOLERANCE * scale || (a.is_nan() && b.is_nan())
}

fn are_close(recorded: &[EffectSize], replayed: &[EffectSize]) -> bool {
    let is_value = |(a, b): (&Value, &Value)| {
        let known = [a.value, a.u, b.value, b.u];
        let scale = known.into_iter().flatten().fold(0.0, |most, one| f64::max(most, one.abs()));
        let is_same = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => is_close(a, b, scale),
            (a, b) => a.is_none() && b.is_none(),
        };
        a.parameter == b.parameter && a.of == b.of && is_same(a.value, b.value) && is_same(a.u, b.u)
    };
    let is_effect = |(a, b): (&EffectSize, &EffectSize)| {
        a.effect == b.effect
            && a.role == b.role
            && a.values.len() == b.values.len()
            && a.values.iter().zip(&b.values).all(is_value)
    };
    recorded.len() == replayed.len() && recorded.iter().zip(replayed).all(is_effect)
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Where things sit; shares are in the order.
fn locations(all: &[Location]) -> String {
    let each = all.iter().map(|one| {
        let rows = one.rows.map_or_else(String::new, |(first, last)| {
            format!(" rows {first}-{}", last.map_or_else(String::new, |last| last.to_string()))
        });
        let run = one.run.as_ref().map_or_else(String::new, |run| format!(" in {run}"));
        format!("{} over {}{run}{rows}", one.of, one.covariate)
    });
    list(&each.collect::<Vec<_>>())
}

fn counts(all: &[Excluded]) -> String {
    let each = all.iter().map(|one| format!("{} {}", one.count, one.reason));
    list(&each.collect::<Vec<_>>())
}

fn shown(all: &[EffectSize]) -> String {
    let number = |one: Option<f64>| one.map_or_else(|| "none".to_owned(), |one| format!("{one:e}"));
    let each = all.iter().map(|one| {
        let values = one.values.iter().map(|one| {
            let of = one.of.as_ref().map_or_else(String::new, |of| format!("@{of}"));
            format!("{}{of} = {} u {}", one.parameter, number(one.value), number(one.u))
        });
        format!("{}: {}", one.effect, values.collect::<Vec<_>>().join(", "))
    });
    list(&each.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(more: &str) -> Outcome {
        let text = format!(
            r#"{{"trial":3,"seed":1,"kind":"one","own_form":false,"effects":["collimation"],
            "lambda":8.0,"spread":false,"mixed":true,"verdict":"explained","named":["collimation"],
            "noise":[],"best":[],"rank":1,"declared":true,"exact":true,"brier":0.5,"confidence":0.5,
            "sure":true,"closed":0.9,"closed_in_truth":1.0,"failed":null{more}}}"#
        );
        serde_json::from_str(&text).unwrap_or_else(|_| unreachable!())
    }

    fn fields(a: &Outcome, b: &Outcome) -> Vec<&'static str> {
        differences(a, b).into_iter().map(|one| one.field).collect()
    }

    #[test]
    fn each_field_that_differs_is_listed() {
        let whole = outcome(
            r#","reason":"","location":[],"sizes":[{"effect":"collimation","role":"named","values":
            [{"parameter":"collimation.offset","of":null,"value":1e-5,"u":1e-7}]}],"excluded":[]"#,
        );
        assert_eq!(fields(&whole, &whole), [""; 0]);
        let change = |by: &dyn Fn(&mut Outcome)| {
            let mut other = whole.clone();
            by(&mut other);
            other
        };
        let cases: [(&str, Outcome); 10] = [
            ("verdict", change(&|one| one.verdict = "a_new_word".to_owned())),
            ("named", change(&|one| one.named.clear())),
            ("noise", change(&|one| one.noise.push("outliers".to_owned()))),
            ("confidence", change(&|one| one.confidence = Some(0.5 + 2e-6))),
            ("brier", change(&|one| one.brier = None)),
            ("reason", change(&|one| one.reason = Some("displaced".to_owned()))),
            (
                "excluded",
                change(&|one| {
                    one.excluded = Some(vec![Excluded { reason: "outlier".to_owned(), count: 2 }]);
                }),
            ),
            (
                "sizes",
                change(&|one| {
                    one.sizes
                        .iter_mut()
                        .flatten()
                        .for_each(|one| one.values[0].value = Some(1.1e-5));
                }),
            ),
            ("effects", change(&|one| one.effects.clear())),
            ("seed", change(&|one| one.seed = 2)),
        ];
        for (field, other) in cases {
            assert_eq!(fields(&whole, &other), [field]);
        }
    }

    #[test]
    fn equal_numbers_and_fields_that_one_lacks_are_no_difference() {
        let old = outcome("");
        let new = outcome(r#","reason":"displaced","excluded":[{"reason":"outlier","count":1}]"#);
        assert_eq!(fields(&old, &new), [""; 0]);
        let mut near = old.clone();
        near.confidence = Some(0.5 + 0.5e-6);
        assert_eq!(fields(&old, &near), [""; 0]);
    }
}
