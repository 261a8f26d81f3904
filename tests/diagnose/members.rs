//! Which member of a family an effect has, where other effects hide in what it explains: it is found
//! beside all of them, by a diagnosis and by a fit with all of them put in.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::evidence::members::choose;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const BENCH: &str = r#"
name = "bench"
title = "A phase meter on a bench"
[inputs]
place = { unit = "m" }
room = { unit = "K" }
[parameters]
zero = { unit = "m", scope = "instrument" }
[measurands]
reading = { value = 'place + zero', unit = "m" }
"#;
const EFFECTS: &[(&str, &str, &str)] = &[
    (
        "wave",
        "c = { unit = \"m\", typical = \"5 mm\", scope = \"instrument\" }\ns = { unit = \"m\", typical = \"5 mm\", scope = \"instrument\" }",
        "reading = 'reading + c * cos(2 * pi * place / length) + s * sin(2 * pi * place / length)'\n\
         [shape]\nlength = { unit = \"m\", from = \"2 m\", to = \"80 m\" }",
    ),
    (
        "warmth",
        "k = { unit = \"m/K\", typical = \"1 mm/K\", scope = \"instrument\" }",
        "reading = 'reading + k * (room - 293 K)'",
    ),
    (
        "scale",
        "k = { unit = \"1\", typical = \"200e-6\", scope = \"instrument\" }",
        "reading = 'reading + k * place'",
    ),
];

/// A wave of a few periods over the bench, a scale and a slow swing of the room: the wave enters first,
/// and takes some of the others with it, by another length.
fn bench(length: f64, seed: u64) -> Campaign<'static> {
    let mut stream = Stream(seed);
    let mut log = String::from("place [m],room [K],reading [m]\n");
    for row in 0..1200 {
        let place = 60.0 * f64::from(row) / 1199.0;
        let room = 293.0 + 4.0 * (place / 9.0 + 1.0).sin() + 0.3 * stream.normal();
        let phase = TAU * place / length;
        let wave = 0.040 * phase.cos() - 0.030 * phase.sin();
        let others = 0.0006 * place + 0.004 * (room - 293.0);
        let reading = place + 0.02 + wave + others + 0.006 * stream.normal();
        let _ = writeln!(log, "{place},{room},{reading}");
    }
    let measurands = "reading = { sigma = \"6 mm\" }";
    Campaign { model: BENCH, effects: EFFECTS, measurands, log }
}

#[test]
fn the_member_of_a_row_is_found_beside_all_rows() {
    for (seed, length) in [(1, 17.0), (2, 23.0), (3, 27.0)] {
        let found = bench(length, seed).diagnosed();
        let mut rows = names(&found);
        rows.sort_unstable();
        assert_eq!(rows, ["scale", "warmth", "wave"], "{}", told(&found));
        assert!(found.remainder.is_empty(), "{}", told(&found));
        let wave = found.rows.iter().find(|row| row.name == "wave").unwrap();
        let (member, sigma) = (wave.member["length"], wave.member_sigma["length"]);
        assert!(
            sigma < 0.003 * length && (member - length).abs() < 4.0 * sigma,
            "{member} {sigma}"
        );
        for (value, truth) in wave.values.iter().zip([0.040, -0.030]) {
            let (value, sigma) = (value.value.unwrap(), value.sigma.unwrap());
            assert!(sigma < 0.001 && (value - truth).abs() < 4.0 * sigma, "{value} {sigma}");
        }
    }
}

/// The range has lines that a coarse grid of members would miss.
#[test]
fn a_fit_with_effects_takes_the_member_that_is_best_beside_the_others() {
    for (seed, length) in [(4, 2.13), (5, 31.0)] {
        let folder = tempfile::tempdir().unwrap();
        bench(length, seed).write_to(folder.path());
        let mut request = Request::new([folder.path()]);
        request.with = ["wave", "warmth", "scale"].map(str::to_owned).to_vec();
        let opened = open(&request).unwrap();
        let options = Options::default();
        let (problem, chosen) =
            choose(opened.problem, &opened.recipes, &request.with, &options).unwrap();
        let [one] = &chosen[..] else { panic!("{chosen:?}") };
        assert!((one.value / length - 1.0).abs() < 0.01, "{one:?}");
        let factor = calibrate(problem, &options).unwrap().variance_factor().unwrap();
        assert!((factor - 1.0).abs() < 0.2, "{factor}");
    }
}
