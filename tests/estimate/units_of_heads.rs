//! Numbers in another unit than the heads of their columns say, whatever unit that is, and what the line
//! to type makes of the fit.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::conventions::Mistaken;
use homepoint::estimate::minima::improved;

use crate::conventions::{found, names};
use crate::folder::Folder;
use crate::problems::Stream;

const RUNS: [&str; 3] = ["a", "b", "c"];

/// Units that heads state: of the boom's angle and length, of bearing, elevation and slant range.
type Heads = [&'static str; 5];
const RIGHT: Heads = ["deg", "m", "deg", "deg", "m"];

/// A boom that turns and reaches out, its head seen by a tracker. Heads may be wrong: the numbers are
/// those of [`RIGHT`].
fn boom(heads: impl Fn(&str) -> Heads) -> Folder {
    let model = "name = \"boom\"\ntitle = \"Boom\"\n\
        [inputs]\nslew = { unit = \"rad\", signal = true }\nreach = { unit = \"m\", signal = true }\n\
        [parameters]\nplace = { kind = \"vector\", unit = \"m\", scope = \"setup\" }\n\
        circle = { unit = \"rad\", scope = \"setup\" }\n\
        [quantities]\nout = 'reach + 3 m'\n\
        seen = '[out * cos(slew), out * sin(slew), 6 m + 0.1 * out] - place'\n\
        [measurands]\n\
        bearing = { value = 'atan2(seen.y, seen.x) - circle', kind = \"angle\", unit = \"rad\", period = \"360 deg\" }\n\
        elevation = { value = 'atan2(seen.z, hypot(seen.x, seen.y))', kind = \"angle\", unit = \"rad\" }\n\
        slant = { value = 'norm(seen)', unit = \"m\" }\n\
        [delays]\ntracker = { of = [\"bearing\", \"elevation\", \"slant\"], scope = \"instrument\" }\n";
    let mut campaign = "title = \"Boom\"\nmodel = \"model.toml\"\n\
        [inputs]\nreach = { sigma = \"0.5 mm\" }\n\
        [measurands]\nbearing = { sigma = \"0.3 mrad\" }\nelevation = { sigma = \"0.3 mrad\" }\n\
        slant = { sigma = \"3 mm\" }\n"
        .to_owned();
    let mut random = Stream(41);
    let mut files: Vec<(String, String)> = Vec::new();
    for (number, run) in RUNS.into_iter().enumerate() {
        campaign.push_str(&format!(
            "[[runs]]\nname = \"{run}\"\ndata = \"{run}.csv\"\nsignals = [\"{run}_sent.csv\"]\n"
        ));
        let phase = 1.7 * number as f64;
        let slew = |t: f64| 0.5 + 0.6 * (0.31 * t + phase).sin() + 0.1 * (1.1 * t).sin();
        let reach = |t: f64| 5.0 + 1.8 * (0.23 * t + 2.0 * phase).cos() + 0.2 * (0.9 * t).sin();
        let heads = heads(run);
        let mut sent = format!("time [s],slew [{}],reach [{}]\n", heads[0], heads[1]);
        let mut read = format!(
            "time [s],bearing [{}],elevation [{}],slant [{}]\n",
            heads[2], heads[3], heads[4]
        );
        for i in 0..1000 {
            let t = 0.04 * f64::from(i);
            let long = reach(t) + 5e-4 * random.normal();
            sent.push_str(&format!("{t:.2},{:.7},{long:.7}\n", slew(t).to_degrees()));
            if i % 5 == 0 && (50..950).contains(&i) {
                let (slew, out) = (slew(t + 0.04), reach(t + 0.04) + 3.0);
                let [x, y] = [out * slew.cos() - 1.2, out * slew.sin() + 4.3];
                let z = 6.0 + 0.1 * out - 2.1;
                let bearing = y.atan2(x) - 0.3 + 3e-4 * random.normal();
                let elevation = z.atan2(x.hypot(y)) + 3e-4 * random.normal();
                let slant = (x * x + y * y + z * z).sqrt() + 3e-3 * random.normal();
                let [bearing, elevation] = [bearing, elevation].map(f64::to_degrees);
                read.push_str(&format!("{t:.2},{bearing:.6},{elevation:.6},{slant:.5}\n"));
            }
        }
        files.extend([(format!("{run}.csv"), read), (format!("{run}_sent.csv"), sent)]);
    }
    let own = [("model.toml", model), ("campaign.toml", campaign.as_str())];
    let files = files.iter().map(|(name, text)| (name.as_str(), text.as_str()));
    Folder::new("boom", &own.into_iter().chain(files).collect::<Vec<_>>())
}

/// Heads of which some are wrong, in all runs.
fn with(wrong: &[(usize, &'static str)]) -> Heads {
    let mut heads = RIGHT;
    wrong.iter().for_each(|(at, unit)| heads[*at] = unit);
    heads
}

/// The variance factor with the line typed is the one that is promised, a good one.
fn the_promise_holds(folder: &Folder, one: &Mistaken) {
    let path = folder.join("campaign.toml");
    let mut campaign = std::fs::read_to_string(&path).unwrap();
    let each = one.columns.iter().map(|(name, formula)| format!("{name} = \"{formula}\""));
    let line = format!("columns = {{ {} }}\n", each.collect::<Vec<_>>().join(", "));
    for run in RUNS.iter().filter(|run| one.run.as_ref().is_none_or(|own| own == *run)) {
        let signals = format!("signals = [\"{run}_sent.csv\"]\n");
        campaign = campaign.replace(&signals, &format!("{signals}{line}"));
    }
    std::fs::write(&path, campaign).unwrap();
    let problem = improved(open(&Request::new([&**folder])).unwrap().problem).0;
    let fit = calibrate(problem, &Options::default()).unwrap();
    let [_, promised] = one.variance_factors;
    let kept = fit.variance_factor().unwrap();
    assert!(fit.is_sound() && (kept / promised - 1.0).abs() < 0.05, "{kept} {one:?}");
    assert!(promised < 1.3, "{one:?}");
}

#[test]
fn right_heads_are_not_doubted() {
    let found = found(&boom(|_| RIGHT));
    assert!(found.is_none(), "{found:?}");
}

#[test]
fn a_column_in_another_unit_than_its_head_is_named() {
    let of = |at, unit, wanted: &str, column: &str| {
        let folder = boom(|_| with(&[(at, unit)]));
        let one = found(&folder).unwrap();
        assert_eq!((one.what[0].name.as_str(), &one.run), (wanted, &None), "{one:?}");
        assert_eq!(one.what[0].numbers, [column], "{one:?}");
        the_promise_holds(&folder, &one);
    };
    of(2, "gon", "deg for gon", "bearing");
    of(2, "mrad", "deg for mrad", "bearing");
    of(4, "ft", "m for ft", "slant");
    of(1, "ft", "m for ft", "reach");
}

#[test]
fn a_column_of_one_run_in_another_unit_than_its_head_is_named() {
    let folder = boom(|run| if run == "b" { with(&[(4, "in")]) } else { RIGHT });
    let one = found(&folder).unwrap();
    assert_eq!((names(&one), one.run.as_deref()), (vec!["m for in"], Some("b")), "{one:?}");
    the_promise_holds(&folder, &one);
}

#[test]
fn columns_that_share_a_wrong_head_are_named_together() {
    let folder = boom(|_| with(&[(2, "gon"), (3, "gon")]));
    let one = found(&folder).unwrap();
    assert_eq!(one.what[0].name, "deg for gon", "{one:?}");
    assert_eq!(one.what[0].numbers, ["bearing", "elevation"], "{one:?}");
    assert_eq!(one.columns[0].1, "bearing / 0.9", "{one:?}");
    the_promise_holds(&folder, &one);
}

/// A stream is smoothed by its stated noise. In metres under a head that says millimetres its noise is a
/// thousandth of that as it is read, and all that is smoothed out would be missing.
#[test]
fn a_stream_in_another_unit_is_smoothed_as_it_will_be() {
    let folder = boom(|_| with(&[(1, "mm")]));
    let one = found(&folder).unwrap();
    assert_eq!((one.what[0].name.as_str(), &one.run), ("in_thousands", &None), "{one:?}");
    the_promise_holds(&folder, &one);
}
