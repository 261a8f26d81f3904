//! Models, effects and what becomes of them together.

use std::collections::BTreeMap;
use std::path::Path;

use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::effect::Effect;
use homepoint::graph::Scope;
use homepoint::library::{Library, embedded, template};
use homepoint::model::{Model, Override, Process};
use homepoint::system::{Selected, System, candidates};
use homepoint::units::{Unit, parse_quantity};
use proptest::prelude::*;

use crate::folder::Folder;

fn shown<T>(result: Result<T, Diagnostics>) -> T {
    result.map_err(|faults| faults.to_string()).unwrap()
}

fn fault<T>(result: Result<T, Diagnostics>) -> String {
    result.err().unwrap().to_string()
}

fn library() -> Library {
    shown(Library::builtin())
}

fn model(name: &str) -> Model {
    shown(library().model(name, Path::new(".")))
}

fn select(names: &[&str]) -> Vec<Selected> {
    let library = library();
    names.iter().map(|name| shown(library.select(name))).collect()
}

fn value(name: &str, value: &str) -> Override {
    Override {
        name: name.into(),
        value: Some(vec![parse_quantity(value).unwrap()]),
        ..Override::default()
    }
}

fn names(system: &System) -> Vec<&str> {
    system.assembly.names.parameters.iter().map(|one| one.name.as_str()).collect()
}

#[test]
fn every_shipped_model_assembles() {
    for (name, _) in embedded::MODELS {
        let model = model(name);
        assert_eq!(model.name, *name);
        let system = shown(System::build(&model, &[], &[], &[]));
        let parameters = system.assembly.names.parameters.len();
        assert_eq!(system.settings.len(), parameters);
        assert_eq!(system.declared.len(), parameters);
        assert_eq!(system.assembly.measurands.len(), model.measurands.len());
        assert_eq!(system.assembly.coordinates.is_some(), model.coordinates.is_some(), "{name}");
    }
}

/// One column a model, in the order of their names: at how many heads the effect can be applied.
#[test]
fn shipped_effects_fit_shipped_models() {
    let constants =
        [value("encoder_interpolation.lines", "36000"), value("sampling_grid.period", "60 us")];
    let models: Vec<Model> = embedded::MODELS.iter().map(|(name, _)| model(name)).collect();
    let mut table = String::new();
    for effect in library().effects() {
        assert!(embedded::EFFECTS.iter().any(|(stem, _)| *stem == effect.name), "{}", effect.name);
        let counts: Vec<usize> = models
            .iter()
            .map(|model| candidates(model, effect, &constants).map_or(0, |found| found.len()))
            .collect();
        assert!(
            effect.builtin || counts.iter().any(|count| *count > 0),
            "{} fits no model",
            effect.name
        );
        let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
        table += &format!("{} {}\n", counts.join(" "), effect.name);
    }
    insta::assert_snapshot!(table);
}

#[test]
fn an_effect_that_does_not_fit_says_why() {
    let library = library();
    let mut lines = String::new();
    for (effect, name) in [
        ("platform_offset", "polar_one_rotation"),
        ("joint_compliance", "hand_eye"),
        ("transit_offset", "angular_intersection"),
        ("encoder_interpolation", "polar_one_rotation"),
        ("servo_velocity_lag", "ur5_laser_tracker"),
        ("angle_noise_level", "rail_car"),
        ("outliers", "rail_car"),
    ] {
        let reasons = candidates(&model(name), &shown(library.effect(effect)), &[]).err().unwrap();
        lines += &format!("{effect} on {name}: {}\n", reasons.messages());
    }
    let build = |effects: &[&str]| {
        fault(System::build(&model("polar_one_rotation"), &select(effects), &[], &[]))
    };
    lines += &build(&["platform_offset", "lost_samples", "collimation.left"]);
    insta::assert_snapshot!(lines);
}

#[test]
fn all_effects_of_a_model_apply_at_once() {
    let model = model("polar_two_rotations");
    let mut all = Vec::new();
    for effect in library().effects() {
        all.extend(candidates(&model, effect, &[]).unwrap_or_default());
    }
    assert!(all.len() > 50, "{}", all.len());
    // Those with nested rates multiply; the rest fit together in one graph.
    all.retain(|one| !one.effect.patches.iter().any(|patch| patch.formula.text.contains("rate(")));
    let system = shown(System::build(&model, &all, &[], &[]));
    assert_eq!(system.effects.len(), all.len());
}

/// A dump of the whole assembly: same text, same result.
fn fingerprint(system: &System) -> String {
    format!("{:?}{:?}{:?}", system.assembly.graph.nodes(), system.settings, names(system))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn the_order_of_effects_changes_nothing(order in Just(vec![
        "timestamp_jitter", "collimation", "encoder_eccentricity", "vertical_index",
        "arm_angle_delay_map", "distance_scale", "distance_offset", "arm_radius",
    ]).prop_shuffle()) {
        let model = model("polar_one_rotation");
        let sorted = {
            let mut sorted = order.clone();
            sorted.sort_unstable();
            shown(System::build(&model, &select(&sorted), &[], &[]))
        };
        let shuffled = shown(System::build(&model, &select(&order), &[], &[]));
        prop_assert_eq!(fingerprint(&sorted), fingerprint(&shuffled));
    }
}

#[test]
fn effects_apply_in_the_order_of_what_they_act_on() {
    let effects = select(&[
        "vertical_index",
        "distance_scale",
        "collimation",
        "clock_drift",
        "distance_scale",
    ]);
    let system = shown(System::build(&model("polar_one_rotation"), &effects, &[], &[]));
    let order: Vec<&str> = system.effects.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(order, ["clock_drift", "collimation", "vertical_index", "distance_scale"]);
    for (index, effect) in system.effects.iter().enumerate() {
        for parameter in &effect.parameters {
            assert_eq!(system.declared[*parameter].effect, Some(index));
        }
    }
}

#[test]
fn effects_are_applied_at_every_head() {
    let model = model("angular_intersection");
    let both = shown(System::build(&model, &select(&["collimation"]), &[], &[]));
    assert!(names(&both).ends_with(&["collimation.a.offset", "collimation.b.offset"]));
    let one = shown(System::build(&model, &select(&["collimation.b"]), &[], &[]));
    assert!(names(&one).ends_with(&["collimation.b.offset"]));
    assert!(!names(&one).contains(&"collimation.a.offset"));
    // `t` at a head is the delay of that head's readings only.
    let late = shown(System::build(&model, &select(&["rate_dependent_delay.a"]), &[], &[]));
    let plain = shown(System::build(&model, &[], &[], &[]));
    let offsets = |system: &System| -> Vec<String> {
        let graph = &system.assembly.graph;
        system
            .assembly
            .measurands
            .iter()
            .map(|one| format!("{:?}", graph.node(one.offset)))
            .collect()
    };
    let changed: Vec<bool> = offsets(&late)
        .iter()
        .zip(&offsets(&plain))
        .map(|(late, plain)| late.contains("Binary") && !plain.contains("Binary"))
        .collect();
    assert_eq!(changed, [true, true, false, false]);
    // An override of the general name holds for all heads, unless a special one says more.
    let overrides =
        [value("collimation.b.offset", "2 arcsec"), value("collimation.offset", "1 arcsec")];
    let system = shown(System::build(&model, &select(&["collimation"]), &overrides, &[]));
    let values: Vec<f64> = system
        .effects
        .iter()
        .map(|one| system.settings[one.parameters[0]].value.as_ref().unwrap()[0])
        .collect();
    let arcsec = Unit::parse("arcsec").unwrap();
    assert_eq!(values, [arcsec.to_si(1.0), arcsec.to_si(2.0)]);
}

#[test]
fn a_parameter_for_each_measurand() {
    let system = shown(System::build(
        &model("polar_one_rotation"),
        &select(&["arm_angle_delay_map"]),
        &[],
        &[],
    ));
    assert_eq!(system.effects[0].parameters.len(), 6);
    assert!(names(&system).contains(&"arm_angle_delay_map.cosine.vertical"));
    let system = shown(System::build(
        &model("polar_one_rotation"),
        &select(&["correlated_noise"]),
        &[],
        &[],
    ));
    let randoms: Vec<&str> = system.randoms.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(
        randoms,
        [
            "correlated_noise.angle_part.horizontal",
            "correlated_noise.angle_part.vertical",
            "correlated_noise.distance_part"
        ]
    );
    assert!(
        system.randoms.iter().all(|one| one.process == Process::Memory && one.memory.is_some())
    );
}

#[test]
fn scopes_can_be_changed_both_ways() {
    let model = model("polar_one_rotation");
    let scope = |name: &str, scope| Override {
        name: name.into(),
        scope: Some(scope),
        ..Override::default()
    };
    let overrides = [
        scope("timestamp_jitter.jitter", Scope::Run),
        scope("distance_offset.offset", Scope::Sample),
    ];
    let effects = select(&["timestamp_jitter", "distance_offset"]);
    let system = shown(System::build(&model, &effects, &overrides, &[]));
    let at = names(&system).iter().position(|name| *name == "timestamp_jitter.jitter").unwrap();
    assert_eq!(system.settings[at].scope, Scope::Run);
    assert_eq!(system.randoms.len(), 1);
    assert_eq!(system.randoms[0].name, "distance_offset.offset");
    // Distance comes before noise.
    let (distance, jitter) = (&system.effects[0], &system.effects[1]);
    assert_eq!(system.randoms[0].typical, distance.effect.parameters[0].setting.typical);
    assert!(distance.randoms == [0] && distance.parameters.is_empty());
    assert!(jitter.parameters == [at] && jitter.randoms.is_empty());
}

#[test]
fn a_model_may_have_random_parameters_of_its_own() {
    let text = template("own")
        .replace(
            "[quantities]",
            "shake = { unit = \"m\", scope = \"sample\", value = \"1 mm\" }\n[quantities]",
        )
        .replace("'norm(point)'", "'norm(point) + shake'");
    let own = shown(Model::parse(Source::new("own.toml", text)));
    let system = shown(System::build(&own, &[], &[], &[]));
    assert_eq!((system.randoms[0].name.as_str(), system.randoms[0].sigma), ("shake", Some(0.001)));
    let used =
        system.assembly.graph.nodes().iter().any(|node| format!("{node:?}").contains("Random(0)"));
    assert!(used);
}

#[test]
fn input_errors_come_from_the_campaign_or_the_model() {
    let model = model("polar_two_rotations");
    let system = shown(System::build(&model, &[], &[], &[Some(1e-6), None]));
    assert_eq!(system.randoms.len(), 1);
    assert_eq!(
        (system.randoms[0].name.as_str(), system.randoms[0].sigma),
        ("arm_angle.error", Some(1e-6))
    );
    assert!(system.randoms[0].fixed);
    assert_eq!(system.assembly.names.inputs[0].error, Some(0));
    assert_eq!(system.assembly.names.inputs[1].error, None);
}

#[test]
fn overrides_change_what_they_name() {
    let model = model("tool_pose_laser_tracker");
    let known = Override { fixed: Some(true), ..value("tracker.delay", "2 ms") };
    let system = shown(System::build(&model, &[], &[known], &[]));
    let at = names(&system).iter().position(|name| *name == "tracker.delay").unwrap();
    let setting = &system.settings[at];
    assert_eq!((setting.fixed, setting.value.as_deref()), (true, Some([0.002].as_slice())));
    assert_eq!((setting.scope, setting.plausible), (Scope::Run, Some(0.01)));
    assert_eq!(system.declared[at].delay_of, [0, 1, 2]);
    assert!(system.assembly.names.measurands.iter().all(|one| one.delay == at));
    assert!(!names(&system).contains(&"x.delay"));
    // The model's own line on a delay.
    let text = template("own")
        .replace("radius ", "\"distance.delay\" = { value = \"1 ms\", fixed = true }\nradius ");
    let own = shown(Model::parse(Source::new("own.toml", text)));
    let system = shown(System::build(&own, &[], &[], &[]));
    let at = names(&system).iter().position(|name| *name == "distance.delay").unwrap();
    assert!(system.settings[at].fixed && system.settings[at].value.as_deref() == Some(&[0.001]));
    let free =
        Override { name: "distance.delay".into(), fixed: Some(false), ..Override::default() };
    let system = shown(System::build(&own, &[], &[free], &[]));
    assert!(!system.settings[at].fixed && system.settings[at].value.as_deref() == Some(&[0.001]));
}

#[test]
fn overrides_that_mean_nothing_are_told() {
    let model = model("polar_one_rotation");
    let effects = select(&["encoder_interpolation", "encoder_eccentricity"]);
    let mut lines = String::new();
    let fixed =
        |name: &str| Override { name: name.into(), fixed: Some(true), ..Override::default() };
    let scope = |name: &str, scope| Override {
        name: name.into(),
        scope: Some(scope),
        ..Override::default()
    };
    for said in [
        value("radios", "1 m"),
        value("radius", "1 s"),
        value("position", "1 m"),
        value("horizontal.dealy", "1 ms"),
        value("encoder_eccentricity.cosin", "1 arcsec"),
        fixed("radius"),
        scope("horizontal.delay", Scope::Sample),
        scope("orientation", Scope::Sample),
        value("encoder_interpolation.lines", "1 m"),
    ] {
        let lines_known = value("encoder_interpolation.lines", "36000");
        let result = System::build(&model, &effects, &[lines_known, said], &[]);
        lines += &format!("{}\n", fault(result));
    }
    lines += &fault(System::build(&model, &effects, &[], &[]));
    lines += "\n";
    let library = library();
    lines += &fault(library.check_overrides(&model, &[value("colimation.offset", "1 arcsec")]));
    shown(library.check_overrides(
        &model,
        &[value("collimation.offset", "1 arcsec"), value("arm_angle.error", "1 arcsec")],
    ));
    insta::assert_snapshot!(lines);
}

#[test]
fn members_of_families_are_chosen() {
    let model = model("polar_one_rotation");
    let one = |order: f64| Selected {
        member: BTreeMap::from([("order".to_owned(), order)]),
        ..select(&["encoder_high_harmonic"]).remove(0)
    };
    let names_of = |effects: &[Selected], overrides: &[Override]| -> Vec<(String, f64)> {
        let system = shown(System::build(&model, effects, overrides, &[]));
        system.effects.iter().map(|one| (one.name.clone(), one.member["order"])).collect()
    };
    let plain = "encoder_high_harmonic".to_owned();
    assert_eq!(names_of(&select(&["encoder_high_harmonic"]), &[]), [(plain.clone(), 3.0)]);
    assert_eq!(names_of(&[one(5.0)], &[]), [(plain.clone(), 5.0)]);
    let said = value("encoder_high_harmonic.order", "7");
    assert_eq!(names_of(&select(&["encoder_high_harmonic"]), &[said]), [(plain, 7.0)]);
    assert_eq!(
        names_of(&[one(8.0), one(4.0)], &[]),
        [
            ("encoder_high_harmonic[order=4]".to_owned(), 4.0),
            ("encoder_high_harmonic[order=8]".to_owned(), 8.0)
        ]
    );
}

#[test]
fn the_template_passes_its_own_check() {
    let model = shown(Model::parse(Source::new("new.toml", template("my_rig"))));
    assert_eq!(model.name, "my_rig");
    let system = shown(System::build(&model, &[], &[], &[]));
    assert!(system.assembly.coordinates.is_some());
}

#[test]
fn folders_of_effects_join_the_library() {
    let folder = Folder::new("nouns", &[]);
    let effects = folder.join("effects");
    std::fs::create_dir_all(&effects).unwrap();
    let text = "name = \"mine\"\nacts = \"distance\"\nparameters = { c = { unit = \"m\", typical = \"1 mm\" } }\npatch = { distance = 'distance + c' }\n";
    std::fs::write(effects.join("mine.toml"), text).unwrap();
    let library =
        library().with_effects_beside(&folder).unwrap().with_effects_dir(&effects).unwrap();
    assert_eq!(library.effect("mine").unwrap().patches.len(), 1);
    assert!(fault(library.effect("mien")).contains("did you mean `mine`?"));
    std::fs::write(effects.join("copy.toml"), text.replace("1 mm", "2 mm")).unwrap();
    assert!(fault(library.clone().with_effects_dir(&effects)).contains("is already in"));
    std::fs::write(effects.join("copy.toml"), b"name = \"\xff\"").unwrap();
    assert!(fault(library.clone().with_effects_dir(&effects)).contains("not UTF-8"));
    std::fs::write(folder.join("own.toml"), template("own")).unwrap();
    assert_eq!(shown(library.model("own.toml", &folder)).name, "own");
    assert!(
        fault(library.model("polar_one_rotatoin", &folder))
            .contains("did you mean `polar_one_rotation`?")
    );
    assert!(fault(library.model("none.toml", &folder)).contains("none.toml"));
    assert!(fault(library.model("./effects/", &folder)).contains("is not a file"));
    assert!(Effect::parse(Source::new("e.toml", text)).is_ok());
}
