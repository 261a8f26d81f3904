//! What several campaigns state of one parameter that they share: their order never matters, every
//! statement counts, and statements that do not fit together are errors.

use std::path::PathBuf;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Estimate, calibrate};

use crate::scale::{SCALE, Scales};

/// Every order of some campaigns.
fn orders(campaigns: &[PathBuf]) -> Vec<Vec<PathBuf>> {
    if campaigns.len() < 2 {
        return vec![campaigns.to_vec()];
    }
    let mut all = Vec::new();
    for first in 0..campaigns.len() {
        let mut rest = campaigns.to_vec();
        let first = rest.remove(first);
        let more = orders(&rest);
        all.extend(more.into_iter().map(|rest| [vec![first.clone()], rest].concat()));
    }
    all
}

/// What comes of campaigns: each parameter with its owner and the bits of value and uncertainty, or
/// what is said against them.
fn answer(campaigns: &[PathBuf]) -> Result<Vec<Estimate>, String> {
    let opened = open(&Request::new(campaigns)).map_err(|faults| faults.to_string())?;
    let fit = calibrate(opened.problem, &Options::default()).map_err(|error| error.to_string())?;
    assert!(fit.is_sound(), "{} {:?}", fit.fit.outcome, fit.unobservable);
    Ok(fit.estimates())
}

type Bits = (String, Option<String>, Option<u64>, Option<u64>);

fn bits(answer: Result<Vec<Estimate>, String>) -> Result<Vec<Bits>, String> {
    let own = |one: Estimate| {
        (one.name, one.of, one.value.map(f64::to_bits), one.sigma.map(f64::to_bits))
    };
    let mut all: Vec<Bits> = answer?.into_iter().map(own).collect();
    all.sort();
    Ok(all)
}

/// The answer, the same bits in every order.
fn in_any_order(campaigns: &[PathBuf]) -> Result<Vec<Estimate>, String> {
    let known = answer(campaigns);
    for order in orders(campaigns) {
        assert_eq!(bits(answer(&order)), bits(known.clone()), "{order:?}");
    }
    known
}

fn estimate(answer: &[Estimate]) -> &Estimate {
    let mut own = answer.iter().filter(|one| one.name == "a");
    let one = own.next().unwrap();
    assert!(own.next().is_none(), "it is shared");
    one
}

/// Value and standard uncertainty of `a` of campaigns with two readings each; their own scatter is
/// 1 m.
fn shared(parameters: &[&str], readings: &[[f64; 2]]) -> Result<(f64, f64), String> {
    let scales = Scales::new();
    let each = parameters.iter().zip(readings).enumerate();
    let campaigns: Vec<PathBuf> = each
        .map(|(number, (said, read))| scales.campaign(&format!("c{number}"), said, read))
        .collect();
    let answer = in_any_order(&campaigns)?;
    let one = estimate(&answer);
    Ok((one.value.unwrap(), one.sigma.unwrap()))
}

/// How far from its minimum a fit may stop (m): 1e-5 of the standard uncertainties here.
const CONVERGED: f64 = 3e-6;

const READ: [[f64; 2]; 3] = [[4.0, 6.0], [5.0, 5.5], [4.5, 5.0]];

#[test]
fn a_stated_value_counts_in_whichever_campaign_it_stands() {
    let stated = r#"a = { value = "1 m", sigma = "0.5 m" }"#;
    let (value, sigma) = shared(&["", stated], &READ[..2]).unwrap();
    // Four readings of variance 1 and a value of variance 1/4.
    assert!((value - (20.5 + 4.0) / 8.0).abs() < CONVERGED, "{value}");
    assert!((sigma - (1.0_f64 / 8.0).sqrt()).abs() < 1e-12, "{sigma}");
    assert_eq!(shared(&["", "", stated], &READ), shared(&["", stated, ""], &READ));
}

#[test]
fn the_same_statement_in_several_campaigns_is_one() {
    let one = r#"a = { value = "1 m", sigma = "0.5 m" }"#;
    let other = r#"a = { value = "1000 mm", sigma = "500 mm" }"#;
    let (_, sigma) = shared(&[one, other], &READ[..2]).unwrap();
    assert!((sigma - (1.0_f64 / 8.0).sqrt()).abs() < 1e-12, "{sigma}");
    assert_eq!(shared(&[one, other, ""], &READ), shared(&[one, "", ""], &READ));
}

#[test]
fn a_campaign_that_states_nothing_leaves_the_model_to_it() {
    // What a campaign states counts over what the model declares, in every campaign.
    let scales = Scales::new();
    let declared = SCALE
        .replace("unit = \"m\", scope", "unit = \"m\", value = \"9 m\", sigma = \"0.1 m\", scope");
    let stated = r#"a = { value = "1 m", sigma = "0.5 m" }"#;
    let made = |name: &str, said: &str, number: usize| {
        let (head, sigma) = ("instrument = \"S\"\n", "x = { sigma = \"1 m\" }");
        scales.written(name, &declared, head, said, sigma, "m", &READ[number])
    };
    let answer = in_any_order(&[made("a", "", 0), made("b", stated, 1)]).unwrap();
    assert!((estimate(&answer).value.unwrap() - 24.5 / 8.0).abs() < CONVERGED);
}

#[test]
fn bounds_of_all_campaigns_hold_together() {
    let (value, _) =
        shared(&[r#"a = { lower = "0 m" }"#, r#"a = { upper = "20 m" }"#], &READ[..2]).unwrap();
    assert!((value - 20.5 / 4.0).abs() < 1e-9, "{value}");
    let scales = Scales::new();
    let low = scales.campaign("low", r#"a = { lower = "0 m", upper = "30 m" }"#, &READ[0]);
    let high = scales.campaign("high", r#"a = { upper = "2 m" }"#, &READ[1]);
    let answer = in_any_order(&[low, high]).unwrap();
    let one = estimate(&answer);
    assert_eq!((one.value, one.sigma), (Some(2.0), None));
}

#[test]
fn a_fixed_value_is_fixed_for_all_that_share_it() {
    let fixed = r#"a = { value = "3 m", fixed = true }"#;
    assert_eq!(shared(&[fixed, fixed], &READ[..2]), Ok((3.0, 0.0)));
}

#[test]
fn statements_that_differ_are_an_error_that_names_both() {
    let prior = r#"a = { value = "1 m", sigma = "0.5 m" }"#;
    for (one, other, said) in [
        (prior, r#"a = { value = "2 m", sigma = "0.5 m" }"#, "2 m with sigma 0.5 m"),
        (prior, r#"a = { value = "1 m", sigma = "0.1 m" }"#, "1 m with sigma 0.1 m"),
        (
            prior,
            r#"a = { value = "1 m", U = "1 m", k = 2, degrees_of_freedom = 4 }"#,
            "4 degrees of freedom",
        ),
        (prior, r#"a = { value = "1 m", fixed = true }"#, "fixed at 1 m"),
        ("", r#"a = { value = "1 m", fixed = true }"#, "fixed at 1 m"),
        (
            r#"a = { value = "2 m", fixed = true }"#,
            r#"a = { value = "1 m", fixed = true }"#,
            "fixed at 2 m",
        ),
        (r#"a = { lower = "7 m" }"#, r#"a = { upper = "6 m" }"#, "above 7 m"),
        (prior, r#"a = { lower = "7 m" }"#, "above 7 m"),
        (prior, r#"a = { upper = "-1 m" }"#, "below -1 m"),
    ] {
        let why = shared(&[one, other], &READ[..2]).unwrap_err();
        for needed in ["`a` of instrument `S`", "`c0`", "`c1`", said, "campaign.toml:"] {
            assert!(why.contains(needed), "{one} {other}: no {needed} in: {why}");
        }
        // A third campaign that states nothing changes nothing.
        let third = if one.is_empty() { one } else { "" };
        if !said.starts_with("fixed") {
            assert!(shared(&[one, other, third], &READ).unwrap_err().contains(said));
        }
    }
}

#[test]
fn parameters_of_one_name_must_be_the_same_quantity() {
    let scales = Scales::new();
    let made = |name: &str, declared: &str, value: &str, unit: &str| {
        let model = SCALE.replace(r#"a = { unit = "m","#, &format!("a = {{ {declared},"));
        let model = model
            .replace("value = 'a', unit = \"m\"", &format!("value = '{value}', unit = \"{unit}\""));
        let sigma = format!("x = {{ sigma = \"1 {unit}\" }}");
        scales.written(name, &model, "instrument = \"S\"\n", "", &sigma, unit, &[1.0, 2.0])
    };
    let length = made("length", r#"unit = "m""#, "a", "m");
    let angle = made("angle", r#"unit = "rad""#, "a", "rad");
    let number = made("number", r#"unit = "1""#, "a", "1");
    let vector = made("vector", r#"kind = "vector", unit = "m""#, "norm(a)", "m");
    let rotation = made("rotation", r#"kind = "rotation""#, "rotate(a, [1, 0, 0]).x", "1");
    for (one, other, said) in [
        (&length, &angle, ["a number in `m`", "a number in `rad`"]),
        (&number, &angle, ["a number in `1`", "a number in `rad`"]),
        (&length, &vector, ["a number in `m`", "a vector in `m`"]),
        (&angle, &rotation, ["a number in `rad`", "a rotation"]),
    ] {
        let why = in_any_order(&[one.clone(), other.clone()]).unwrap_err();
        assert!(said.iter().all(|said| why.contains(said)), "{why}");
        assert!(why.contains("`a` of instrument `S` is"), "{why}");
    }
    // Another unit of the same dimension is the same quantity.
    let millimetres = made("millimetres", r#"unit = "mm""#, "a", "m");
    let answer = in_any_order(&[length, millimetres]).unwrap();
    assert!((estimate(&answer).value.unwrap() - 1.5).abs() < CONVERGED);
}

const ARM: &str = r#"
model = "polar_one_rotation"
rig = "arm"
instrument = "tracker"
[parameters]
radius      = { value = "1.146 m", fixed = true }
orientation = { value = ["0 rad", "0 rad", "0 rad"], fixed = true }
position    = { value = ["0.4 m", "0.1 m", "1.4 m"], fixed = true }
"#;
const READINGS: &str = r#"
[measurands]
horizontal = { sigma = "10 urad" }
vertical   = { sigma = "10 urad" }
distance   = { sigma = "10 um" }
[[runs]]
name = "fast"
plan = { trigger = "10 Hz", duration = "2 s", arm_angle = { start = "10 deg", rate = "190 deg/s" } }
"#;

fn arm(scales: &Scales, name: &str, top: &str, parameters: &str, timing: &str) -> PathBuf {
    let folder = scales.path().join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let text = format!("{top}{ARM}{parameters}{READINGS}{timing}");
    std::fs::write(folder.join("campaign.toml"), text).unwrap();
    folder
}

#[test]
fn a_family_has_one_member_in_campaigns_that_share_it() {
    let scales = Scales::new();
    let top = "effects = [\"encoder_high_harmonic\"]\n";
    let made = |name: &str, order: u8| {
        arm(
            &scales,
            name,
            top,
            &format!("encoder_high_harmonic.order = {{ value = \"{order}\" }}\n"),
            "",
        )
    };
    let (three, five, alike) = (made("three", 3), made("five", 5), made("alike", 3));
    let opened = |all: [&PathBuf; 2]| open(&Request::new(all)).map_err(|faults| faults.to_string());
    assert!(opened([&three, &alike]).is_ok());
    let why = opened([&three, &five]).unwrap_err();
    assert_eq!(why, opened([&five, &three]).unwrap_err());
    let said = "`encoder_high_harmonic.order` of rig `arm` is 5 in campaign `five`, but 3 in campaign `three`";
    assert!(why.contains(said), "{why}");
}

/// Statements on effects that are not in use are not errors: nothing rests on them yet.
#[test]
fn unused_statements_that_differ_are_warned_of() {
    let scales = Scales::new();
    let made = |name: &str, offset: &str| {
        let said = format!("collimation.offset = {{ value = \"{offset}\", sigma = \"1 urad\" }}\n");
        arm(&scales, name, "", &said, "")
    };
    let (one, other) = (made("one", "20 urad"), made("other", "30 urad"));
    for order in [[&one, &other], [&other, &one]] {
        let warnings = open(&Request::new(order)).unwrap().warnings;
        let all: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let is_said =
            |one: &String| one.contains("`collimation.offset` of instrument `tracker` is");
        assert_eq!(all.iter().filter(|one| is_said(one)).count(), 1, "{all:?}");
    }
}

/// The offset of reference times belongs to a timing chain: equal chains of a rig share it, others
/// have their own.
#[test]
fn every_timing_chain_counts() {
    let scales = Scales::new();
    let made = |name: &str, tolerance: &str| {
        let timing = format!(
            "[timing]\nmethod = \"serial\"\nbaud = \"19200 Bd\"\nbits = 80\nresolution = \"25 ns\"\nbaud_tolerance = \"{tolerance}\"\n"
        );
        arm(&scales, name, "", "", &timing)
    };
    let (good, same, poor) =
        (made("good", "100 ppm"), made("same", "100 ppm"), made("poor", "10000 ppm"));
    let offsets = |all: &[&PathBuf]| {
        let layout = open(&Request::new(all)).unwrap().problem.layout;
        let own = layout.instances.into_iter().filter(|one| one.name == "time_referencing.offset");
        let mut own: Vec<_> = own.map(|one| (one.of, one.setting.sigma.unwrap()[0])).collect();
        own.sort_by(|a, b| a.1.total_cmp(&b.1));
        own
    };
    let (alone, of_poor) = (offsets(&[&good]), offsets(&[&poor]));
    assert!(of_poor[0].1 > 50.0 * alone[0].1);
    assert_eq!(offsets(&[&good, &same]), alone, "one chain");
    for order in [[&good, &poor], [&poor, &good]] {
        let [(first, u), (second, v)] = offsets(&order).try_into().unwrap();
        assert_eq!((first.as_deref(), u), (Some("good"), alone[0].1));
        assert_eq!((second.as_deref(), v), (Some("poor"), of_poor[0].1));
    }
    let [(first, _), (second, _)] = offsets(&[&poor, &same, &good]).try_into().unwrap();
    assert_eq!((first.as_deref(), second.as_deref()), (Some("good + same"), Some("poor")));
}
