//! Effects beside one of several campaigns count for that one alone, and the message says where they
//! are.

use std::process::{Command, Output};

use crate::folder::Folder;

const MODEL: &str = "name = \"scale\"\ntitle = \"Scale\"\n[inputs]\nplace = { unit = \"m\" }\n[parameters]\n\
     zero = { unit = \"m\" }\n[measurands]\nx = { value = 'place + zero', unit = \"m\", sigma = \"1 mm\" }\n";
const EFFECT: &str = "name = \"rope_stretch\"\ntitle = \"Stretch\"\nacts = \"instrument\"\n[parameters]\n\
     part = { unit = \"1\", typical = \"1e-3\", scope = \"instrument\" }\n[patch]\nx = 'x + part * place'\n";
const CAMPAIGN: &str = "model = \"../model.toml\"\ninstrument = \"S\"\n[parameters]\n\"x.delay\" = { value = \"0 s\", fixed = true }\n\
     [[runs]]\nname = \"one\"\ndata = \"one.csv\"\n";

fn campaigns() -> Folder {
    let rows = |shift: f64| {
        let row = |n: i32| {
            let place = 0.1 * f64::from(n);
            let noise = 1e-3 * f64::from((n * 37) % 11 - 5) / 3.0;
            format!("{n},{place},{}\n", place * 1.002 + shift + noise)
        };
        format!("time [s],place [m],x [m]\n{}", (0..40).map(row).collect::<String>())
    };
    Folder::new(
        "elsewhere",
        &[
            ("model.toml", MODEL),
            ("first/campaign.toml", CAMPAIGN),
            ("first/one.csv", &rows(0.2)),
            ("first/effects/rope_stretch.toml", EFFECT),
            ("second/campaign.toml", CAMPAIGN),
            ("second/one.csv", &rows(0.21)),
        ],
    )
}

fn run(folder: &Folder, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    command.args(arguments).current_dir(&**folder).output().unwrap()
}

fn told(folder: &Folder, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn an_effect_beside_another_campaign_is_named_with_its_folder() {
    let folder = campaigns();
    let set = "rope_stretch.part=0.002";
    let with: &[&[&str]] = &[
        &["calibrate", "first", "second", "--with", "rope_stretch"],
        &["calibrate", "second", "first", "--with", "rope_stretch"],
        &["diagnose", "first", "--holdout", "second", "--set", set],
    ];
    for arguments in with {
        let text = told(&folder, arguments);
        assert!(text.contains("there is no effect `rope_stretch`"), "{text}");
        assert!(text.contains("beside the campaign `second`"), "{text}");
        assert!(text.contains("`--effects first/effects` gives it to all"), "{text}");
        assert!(!text.contains("known: "), "{text}");
        // It does.
        let output = run(&folder, &[arguments, &["--effects", "first/effects"][..]].concat());
        assert_ne!(output.status.code(), Some(2), "{output:?}");
    }
}

#[test]
fn a_name_that_nothing_has_is_answered_with_similar_ones_alone() {
    let folder = campaigns();
    let text = told(&folder, &["calibrate", "first", "--set", "rope.share=0.002"]);
    assert!(text.contains("similar names: rope_stretch.part"), "{text}");
    let text = told(&folder, &["calibrate", "first", "--set", "xyzzyx=0.002"]);
    assert!(!text.contains("names:") && !text.contains("known:"), "{text}");
}

/// A folder stands for its campaign: the model in it, and the effects beside it.
#[test]
fn effects_of_a_folder_are_those_of_its_campaign() {
    let folder = campaigns();
    let of = |what: &str| {
        let output = run(&folder, &["effects", what]);
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let (found, of_model) = (of("first"), of("model.toml"));
    assert!(found.contains("rope_stretch") && !of_model.contains("rope_stretch"), "{found}");
    let why = "not testable here: the model has no";
    assert_eq!(found.matches(why).count(), of_model.matches(why).count());
    assert_eq!(of("second"), of_model);
}

/// A part of a name stands for the effects that have it.
#[test]
fn a_word_of_a_name_is_answered_with_the_effects_that_have_it() {
    let text = told(&campaigns(), &["calibrate", "first", "--with", "refraction"]);
    assert!(text.contains("did you mean `vertical_refraction`?"), "{text}");
    let text = told(&campaigns(), &["calibrate", "first", "--with", "runout"]);
    assert!(text.contains("`axial_runout_second` or `radial_runout_second`?"), "{text}");
}

/// The models of the campaign in whose folder an effect lies are asked, also where they are elsewhere.
#[test]
fn an_effect_is_checked_with_the_model_of_its_campaign() {
    let folder = campaigns();
    let path = "first/effects/rope_stretch.toml";
    let checked = |folder: &Folder| {
        let output = run(folder, &["check", path]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(checked(&folder), format!("{path}: an effect for ../model.toml\n"));
    // A square has no slope at zero.
    std::fs::write(folder.join(path), EFFECT.replace("part * place", "part^2 * place")).unwrap();
    assert!(checked(&folder).contains("`rope_stretch.part` has no slope at zero"));
}
