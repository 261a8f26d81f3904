//! A parameter that acts by its square about its start is no parameter without effect.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;

use crate::scale::{SCALE, Scales};

#[test]
fn a_square_at_zero_is_said_and_is_determined_from_elsewhere() {
    let scales = Scales::new();
    let square = SCALE.replace("value = 'a'", "value = 'a * a / (1 m)'");
    let silent = SCALE.replace("value = 'a'", "value = '0 * a + 0.25 m'");
    let sigma = "x = { sigma = \"1 mm\" }";
    let fit = |name: &str, model: &str, head: &str| {
        let folder = scales.written(name, model, "", head, sigma, "m", &[0.25, 0.251, 0.249]);
        calibrate(open(&Request::new([folder])).unwrap().problem, &Options::default()).unwrap()
    };
    let found = fit("square", &square, "");
    let [one] = &found.unobservable[..] else { panic!("{:?}", found.unobservable) };
    assert!(one.words.contains("acts by its square"), "{}", one.words);
    assert!(one.remedy.contains("start it elsewhere: [parameters] a = { start"), "{}", one.remedy);
    // The remedy helps: a² = 0.25 m².
    let found = fit("elsewhere", &square, "a = { start = \"1 m\" }");
    assert!(found.is_sound(), "{:?}", found.unobservable);
    assert!((found.estimates()[0].value.unwrap() - 0.5).abs() < 1e-9);
    // What has no effect at all is said to have none.
    let found = fit("silent", &silent, "");
    assert!(found.unobservable[0].words.contains("has no effect on any reading"));
}

#[test]
fn the_start_of_a_vector_is_a_list_of_three() {
    let scales = Scales::new();
    let vector = SCALE
        .replace("a = { unit", "a = { kind = \"vector\", unit")
        .replace("value = 'a'", "value = '(a.x * a.x + a.y * a.y) / (1 m) + a.z'");
    let fit = |name: &str, head: &str| {
        let folder = scales.written(
            name,
            &vector,
            "",
            head,
            "x = { sigma = \"1 mm\" }",
            "m",
            &[0.25, 0.251, 0.249],
        );
        calibrate(open(&Request::new([folder])).unwrap().problem, &Options::default()).unwrap()
    };
    let found = fit("vector", "");
    let remedies: Vec<&str> = found.unobservable.iter().map(|one| one.remedy.as_str()).collect();
    let due = "a = { start = [\"...\", \"0 m\", \"0.25 m\"] }";
    assert!(remedies.iter().any(|remedy| remedy.contains(due)), "{remedies:?}");
    // It is read as it is printed, once the open component is put in.
    let line = due.replace("...", "0.1 m");
    fit("started", &line);
}
