//! What is said of bad model and effect files, and that nothing written makes the reader fall over.

use homepoint::diagnostic::Source;
use homepoint::effect::Effect;
use homepoint::library::{embedded, template};
use homepoint::model::Model;
use homepoint::system::System;
use proptest::prelude::*;

/// A small model with one more line in a section.
fn with(section: &str, line: &str) -> String {
    let mut text = String::from("name = \"small\"\n");
    for (name, lines) in [
        ("inputs", "angle = { unit = \"rad\", signal = true }"),
        ("parameters", "radius = { unit = \"m\", scope = \"rig\" }"),
        ("quantities", "way = 'radius * angle'"),
        ("measurands", "reading = { value = 'way', unit = \"m\" }"),
    ] {
        text += &format!("[{name}]\n{lines}\n");
        if name == section {
            text += &format!("{line}\n");
        }
    }
    if !text.contains(&format!("[{section}]")) {
        text += &format!("[{section}]\n{line}\n");
    }
    text
}

fn model_fault(text: &str) -> String {
    let model = match Model::parse(Source::new("model.toml", text)) {
        Err(faults) => return faults.to_string(),
        Ok(model) => model,
    };
    match System::build(&model, &[], &[], &[]) {
        Err(faults) => format!("(assembled) {faults}"),
        Ok(_) => "no fault".to_owned(),
    }
}

#[test]
fn the_small_model_is_sound() {
    assert_eq!(
        model_fault(&with("none", "")),
        "model.toml:10:2: error: `none` is not a key of a model\n  help: did you mean `name`?"
    );
    assert_eq!(model_fault(&with("parameters", "")), "no fault");
}

#[test]
fn faults_of_models() {
    let mut lines = String::new();
    for (section, line) in [
        ("inputs", "speed = { unit = \"m/x\" }"),
        ("inputs", "speed = { unti = \"m\" }"),
        ("inputs", "speed = { unit = \"m\", signal = \"yes\" }"),
        ("inputs", "speed = { unit = \"degC\", sigma = \"1 degC\" }"),
        ("inputs", "speed = { unit = \"rad\", period = \"360 mm\" }"),
        ("inputs", "speed = { unit = \"m\", smooth = \"-1 s\" }"),
        ("inputs", "speed = 3"),
        ("parameters", "time = { unit = \"s\" }"),
        ("parameters", "sin = { unit = \"1\" }"),
        ("parameters", "\"a b\" = { unit = \"1\" }"),
        ("parameters", "\"\" = { unit = \"1\" }"),
        ("parameters", "angle = { unit = \"1\" }"),
        ("parameters", "radius = { unit = \"1\" }"),
        ("parameters", "p = { unit = \"m\", value = \"1 s\" }"),
        ("parameters", "p = { unit = \"m\", value = \"1,5 m\" }"),
        ("parameters", "p = { unit = \"m\", value = 1.5 }"),
        ("parameters", "p = { unit = \"m\", value = nan }"),
        ("parameters", "p = { value = 1e999 }"),
        ("parameters", "p = { unit = \"m\", value = [\"1 m\", \"2 m\", \"3 m\"] }"),
        ("parameters", "p = { kind = \"vector\", unit = \"m\", value = \"1 m\" }"),
        ("parameters", "p = { kind = \"vector\", unit = \"m\", value = [\"1 m\", \"2 m\"] }"),
        (
            "parameters",
            "p = { kind = \"vector\", unit = \"m\", value = [\"1 m\", \"2 m\", \"3 s\"] }",
        ),
        ("parameters", "p = { kind = \"rotaton\" }"),
        ("parameters", "p = { kind = \"rotation\", unit = \"m\" }"),
        ("parameters", "p = { unit = \"m\", value = \"1 m\", sigma = \"0 m\" }"),
        ("parameters", "p = { unit = \"m\", sigma = \"1 m\" }"),
        ("parameters", "p = { unit = \"m\", lower = \"1 m\", upper = \"1 m\" }"),
        ("parameters", "p = { unit = \"m\", lower = \"1 m\", value = \"0.9 m\" }"),
        ("parameters", "p = { unit = \"m\", fixed = true, value = \"1 m\", sigma = \"1 m\" }"),
        ("parameters", "p = { unit = \"m\", fixed = true }"),
        ("parameters", "p = { unit = \"m\", scope = \"rigg\" }"),
        ("parameters", "p = { kind = \"vector\", unit = \"m\", scope = \"sample\" }"),
        ("parameters", "p = { unit = \"m\", per = \"measurand\" }"),
        ("parameters", "p = { unit = \"m\", sum = \"one\" }"),
        ("parameters", "\"readin.delay\" = { value = \"1 ms\" }"),
        ("parameters", "\"reading.delay\" = { value = \"1 m\" }"),
        ("parameters", "\"reading.delay\" = { valeu = \"1 ms\" }"),
        ("quantities", "more = 'radius +'"),
        ("quantities", "more = 'radius + angel'"),
        ("quantities", "more = 'radius + angle'"),
        ("quantities", "more = '''\n  radius\n  + angel'''"),
        ("quantities", "more = \"radius + angel\""),
        ("quantities", "more = \"radius\\t + angel\""),
        ("quantities", "more = 5"),
        ("quantities", "more = 'more'"),
        ("measurands", "other = { unit = \"m\" }"),
        ("measurands", "other = { value = 'angle', kind = \"angle\", unit = \"m\" }"),
        ("measurands", "other = { value = 'way', unit = \"m\", period = \"1 m\" }"),
        ("measurands", "other = { value = 'angle', unit = \"m\" }"),
        ("delays", "shared = { of = [\"readin\"] }"),
        ("delays", "shared = { }"),
        ("delays", "reading = { of = [\"reading\"] }"),
        ("delays", "a = { of = [\"reading\"] }\nb = { of = [\"reading\"] }"),
        ("delays", "a = { of = [\"reading\"], plausible = \"1 m\" }"),
        ("heads", "a = { horizontal = \"readin\" }"),
        ("heads", "x = { horizontal = \"reading\" }"),
        ("coordinates", "helper = 'angle'"),
        (
            "coordinates",
            "point = { from = '[way, 0, 0]', rotation = \"turn\", translation = \"radius\", measured = '[0, 0, 0]' }",
        ),
        ("parameter", "p = { }"),
    ] {
        let fault = model_fault(&with(section, line));
        assert_ne!(fault, "no fault", "{line}");
        lines += &format!("[{section}] {line}\n{fault}\n\n");
    }
    for text in [
        "",
        "name = \"a\"",
        "name = \"sin\"",
        "name = \"a\"\nname = \"b\"",
        "name = [",
        "name = \"\\q\"",
        "\u{feff}x",
    ] {
        lines += &format!("{text:?}\n{}\n\n", model_fault(text));
    }
    insta::assert_snapshot!(lines);
}

#[test]
fn faults_of_effects() {
    let mut lines = String::new();
    let patch = "[patch]\ndistance = 'distance + c'";
    for body in [
        String::new(),
        "acts = \"distanse\"".to_owned(),
        "acts = \"distance\"".to_owned(),
        format!("acts = \"distance\"\nbuiltin = true\n{patch}"),
        format!("acts = \"distance\"\n[parameters]\nc = {{ unit = \"m\" }}\n{patch}"),
        format!(
            "acts = \"distance\"\n[parameters]\nx = {{ unit = \"m\", typical = \"1 m\" }}\n{patch}"
        ),
        format!(
            "acts = \"distance\"\n[parameters]\nc = {{ unit = \"m\", typical = \"-1 m\" }}\n{patch}"
        ),
        format!(
            "acts = \"distance\"\n[parameters]\nc = {{ unit = \"m\", typical = \"1 m\", process = \"walk\" }}\n{patch}"
        ),
        format!(
            "acts = \"distance\"\n[parameters]\nc = {{ unit = \"m\", typical = \"1 m\", scope = \"sample\", process = \"memory\" }}\n{patch}"
        ),
        format!(
            "acts = \"distance\"\n[parameters]\nc = {{ kind = \"vector\", unit = \"m\", typical = \"1 m\", scope = \"sample\" }}\n{patch}"
        ),
        format!("acts = \"distance\"\n[shape]\nc = [1, \"2 m\"]\n{patch}"),
        format!("acts = \"distance\"\n[shape]\nc = []\n{patch}"),
        format!(
            "acts = \"distance\"\n[shape]\nc = {{ unit = \"Hz\", from = \"2 Hz\", to = \"1 Hz\" }}\n{patch}"
        ),
        format!("acts = \"distance\"\n[shape]\nc = {{ unit = \"Hz\", from = \"2 Hz\" }}\n{patch}"),
        "acts = \"distance\"\n[patch]\neach.angel = 'self'".to_owned(),
        "acts = \"distance\"\n[patch]\na.b.c.d.e = 'self'".to_owned(),
        "acts = \"distance\"\n[patch]\ntime = 'time'".to_owned(),
        "acts = \"distance\"\n[patch]\ndistance = 'distance +* 2'".to_owned(),
        "acts = \"distance\"\n[patch]\nhorizontal.sigma = 2".to_owned(),
        format!("acts = \"distance\"\n[patches]\na = 1\n{patch}"),
    ] {
        let text = format!("name = \"mine\"\n{body}\n");
        let fault = Effect::parse(Source::new("effect.toml", text)).err().unwrap();
        lines += &format!("{body}\n{fault}\n\n");
    }
    insta::assert_snapshot!(lines);
}

#[test]
fn long_and_deep_texts_are_refused_or_read_quickly() {
    let long = "#".repeat(300_000);
    assert!(model_fault(&long).contains("at most"));
    let deep =
        with("quantities", &format!("deep = '{}1{}'", "(".repeat(50_000), ")".repeat(50_000)));
    assert!(model_fault(&deep).contains("model.toml:8:"));
    let nested = format!("a = {}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(model_fault(&nested).contains("error"));
    let many: String = (0..12_000).map(|k| format!("a{k} = 'b'\n")).collect();
    let faults =
        Model::parse(Source::new("m.toml", format!("name = \"m\"\n{many}"))).err().unwrap();
    assert_eq!(faults.0.len(), 51);
    let chain: String = (1..3_000).map(|k| format!("q{k} = 'q{}'\n", k - 1)).collect();
    assert_ne!(model_fault(&with("quantities", &format!("q0 = 'way'\n{chain}"))), "");
}

/// Reads a text as both kinds of files, and assembles what could be read.
fn survive(text: &str) {
    if let Err(faults) = Effect::parse(Source::new("any.toml", text)) {
        assert!(!faults.0.is_empty());
    }
    match Model::parse(Source::new("any.toml", text)) {
        Err(faults) => assert!(!faults.0.is_empty()),
        Ok(model) => drop(System::build(&model, &[], &[], &[])),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_text_is_survived(text in any::<String>()) {
        survive(&text);
    }

    #[test]
    fn any_line_is_survived(
        section in prop::sample::select(vec!["inputs", "parameters", "quantities", "measurands", "delays", "heads", "coordinates", "shape", "patch"]),
        line in r#"["'a-z_.]{1,9} = ("[ -~µ]{0,12}"|'[a-z+*/^().,0-9 -]{0,16}'|\{ (unit|value|kind|of|from|scope) = ["'a-z0-9 ]{0,9}[}\]]?)"#,
    ) {
        survive(&with(section, &line));
    }

    /// Shipped files with a piece cut out, doubled or overwritten.
    #[test]
    fn mutated_files_are_survived(
        file in any::<prop::sample::Index>(),
        (from, length) in (any::<prop::sample::Index>(), 0_usize..12),
        piece in prop::sample::select(vec!["", "'", "\"", "{", "}", "[", "]", "=", "\n", ".", "é", "\0", "1e999", " m", "rate(", "[[x]]", "t"]),
    ) {
        let template = template("new");
        let mut files: Vec<&str> = embedded::MODELS.iter().chain(embedded::EFFECTS).map(|(_, text)| *text).collect();
        files.push(&template);
        let text: Vec<char> = file.get(&files).chars().collect();
        let from = from.index(text.len());
        let to = (from + length).min(text.len());
        let mutated: String = text[..from].iter().copied().chain(piece.chars()).chain(text[to..].iter().copied()).collect();
        survive(&mutated);
    }
}
