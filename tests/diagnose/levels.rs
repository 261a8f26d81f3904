//! Places of an input that are read again and again, each with an error of its own: what repeats at a place
//! is no noise, however large noise is stated to be.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

/// Readings of so many places in rounds, each in an order of its own, with errors of the places; a place is
/// a number, or one of those that divide a turn.
fn rounds(places: usize, rounds: usize, error: f64, turns: bool, seed: u64) -> Diagnosis {
    let mut random = Stream(seed);
    let errors: Vec<f64> = (0..places).map(|_| error * random.normal()).collect();
    let (unit, column, step) =
        if turns { ("rad", "deg", 360.0 / places as f64) } else { ("1", "1", 1.0) };
    let model = format!(
        "name = \"box\"\ntitle = \"Box\"\n[inputs]\nplace = {{ unit = \"{unit}\" }}\n\
         [parameters]\nzero = {{ unit = \"m\", scope = \"run\" }}\n\
         [measurands]\nread = {{ value = 'zero', unit = \"m\" }}\n"
    );
    let mut campaign =
        "title = \"Box\"\nmodel = \"box.toml\"\n[measurands]\nread = { sigma = \"1 um\" }\n"
            .to_owned();
    let mut files = vec![("box.toml".to_owned(), model)];
    for round in 0..rounds {
        let mut order: Vec<(f64, usize)> = (0..places).map(|at| (random.normal(), at)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut log = format!("place [{column}],read [um]\n");
        let zero = 5.0 * random.normal();
        for (_, at) in order {
            let read = zero + errors[at] + random.normal();
            writeln!(log, "{},{read:.2}", step * at as f64).unwrap();
        }
        files.push((format!("round_{round}.csv"), log));
        write!(campaign, "[[runs]]\nname = \"round_{round}\"\ndata = \"round_{round}.csv\"\n")
            .unwrap();
    }
    files.push(("campaign.toml".to_owned(), campaign));
    diagnosed(&files)
}

/// Four rounds of 24 faces, a box of ten weights three times, 36 divisions of a circle in two rounds.
#[test]
fn each_place_has_an_error_of_its_own() {
    for (places, of, error, turns) in [(24, 4, 4.0, false), (10, 3, 5.0, false), (36, 2, 5.0, true)]
    {
        for seed in 1..=3 {
            let found = rounds(places, of, error, turns, seed);
            assert_eq!(found.verdict, Verdict::Unknown, "{places} {seed}: {}", told(&found));
            let [part] = &found.remainder[..] else { panic!("{}", told(&found)) };
            assert_eq!(part.place.words, "an error of `read` over place");
            assert!(found.levels.iter().all(|one| one.factor < 1.6), "{}", told(&found));
        }
    }
}

/// Where the readings of a place differ by as much as those of all, it is noise.
#[test]
fn places_that_do_not_differ_have_noise() {
    for (places, of, turns) in [(24, 4, false), (10, 3, false), (36, 2, true)] {
        for seed in 1..=3 {
            let found = rounds(places, of, 0.0, turns, seed);
            assert_eq!(found.verdict, Verdict::Adequate, "{places} {seed}: {}", told(&found));
        }
    }
}

/// A weight at twelve marks in rows and columns, in rounds of an order of their own; at one of them the plate
/// gives way, if at all.
fn marks(error: f64, seed: u64) -> Diagnosis {
    let mut random = Stream(seed);
    let model = "name = \"plate\"\ntitle = \"Plate\"\n\
                 [inputs]\nx = { unit = \"m\" }\ny = { unit = \"m\" }\n\
                 [parameters]\nzero = { unit = \"N\" }\nslope_x = { unit = \"N/m\" }\nslope_y = { unit = \"N/m\" }\n\
                 [measurands]\ncell = { value = 'zero + slope_x * x + slope_y * y', unit = \"N\" }\n";
    let campaign = "title = \"Plate\"\nmodel = \"plate.toml\"\n[measurands]\ncell = { sigma = \"0.1 N\" }\n\
                    [[runs]]\nname = \"marks\"\ndata = \"marks.csv\"\n";
    let mut log = "x [m],y [m],cell [N]\n".to_owned();
    for _ in 0..8 {
        let mut order: Vec<(f64, u32)> = (0..12).map(|at| (random.normal(), at)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, at) in order {
            let (x, y) = (0.1 * f64::from(at % 4), 0.15 * f64::from(at / 4));
            let own = if at == 6 { error } else { 0.0 };
            let read = 40.0 + 70.0 * x - 30.0 * y + own + 0.1 * random.normal();
            writeln!(log, "{x},{y},{read:.3}").unwrap();
        }
    }
    let files = [("plate.toml", model), ("campaign.toml", campaign), ("marks.csv", &log)];
    diagnosed(&files.map(|(name, text)| (name.to_owned(), text.to_owned())))
}

/// What one place of a plane does is over both of its axes together, and is no noise.
#[test]
fn one_mark_of_a_plane_has_an_error_of_its_own() {
    for seed in 1..=3 {
        let found = marks(0.5, seed);
        assert_eq!(found.verdict, Verdict::Unknown, "{seed}: {}", told(&found));
        let [part] = &found.remainder[..] else { panic!("{}", told(&found)) };
        assert_eq!(part.place.words, "an error of `cell` over x and y together", "{seed}");
        let found = marks(0.0, seed);
        assert_eq!(found.verdict, Verdict::Adequate, "{seed}: {}", told(&found));
    }
}
