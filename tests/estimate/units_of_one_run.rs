//! The unit of one run's readings, beside inputs that would predict as little in a smaller unit.

use crate::conventions::{found, names};
use crate::folder::Folder;
use crate::problems::Stream;

/// Runs of which one has its readings in another unit, as files with these columns of each sample.
fn with_another_unit(
    name: &str,
    (model, sigma): (&str, &str),
    heads: &str,
    row: impl Fn(f64, f64) -> Vec<f64>,
    (noise, factor): (f64, f64),
) -> Folder {
    let mut campaign = format!("title = \"Runs\"\nmodel = \"model.toml\"\n{sigma}\n");
    let mut random = Stream(29);
    let mut files = vec![("model.toml".to_owned(), model.to_owned())];
    for run in 0..4 {
        campaign.push_str(&format!("[[runs]]\nname = \"{run}\"\ndata = \"{run}.csv\"\n"));
        let mut text = format!("{heads}\n");
        for at in 0..300 {
            let mut cells = row(f64::from(run), 0.07 * f64::from(at));
            if let Some(reading) = cells.last_mut() {
                *reading += noise * random.normal();
                *reading *= if run == 2 { factor } else { 1.0 };
            }
            let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:.6}")).collect();
            text.push_str(&format!("{}\n", cells.join(",")));
        }
        files.push((format!("{run}.csv"), text));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    Folder::new(name, &files)
}

/// Pressures of one run in hPa beside speeds that would predict nothing in hundredths: that leaves a
/// variance factor of 1.3 in place of 1.0, which is far more than noise of so many readings.
#[test]
fn what_fits_worse_by_more_than_noise_is_not_about_as_good() {
    let model = "name = \"pitot\"\ntitle = \"Pitot tube\"\n[inputs]\nspeed = { unit = \"m/s\" }\n\
        [parameters]\ngain = { unit = \"kg/m^3\", scope = \"rig\", start = \"0.6 kg/m^3\" }\n\
        zero = { unit = \"Pa\", scope = \"rig\" }\n\
        [measurands]\npressure = { value = 'gain * speed^2 + zero', unit = \"Pa\" }\n";
    let row = |run: f64, at: f64| {
        let speed = 10.0 + 6.0 * (at + run).sin();
        vec![speed, 0.61 * speed * speed + 0.4]
    };
    let sigma = "[measurands]\npressure = { sigma = \"0.4 Pa\" }";
    let heads = "speed [m/s],pressure [Pa]";
    let folder = with_another_unit("pitot", (model, sigma), heads, row, (0.4, 0.01));
    let one = found(&folder).unwrap();
    assert_eq!((names(&one), one.run.as_deref()), (vec!["hPa for Pa"], Some("2")), "{one:?}");
}

/// The sine and cosine of a crank's angle have no unit, though arcminutes of them would predict as little
/// as one run reads: it was logged in metres under heads of millimetres.
#[test]
fn a_sine_beside_its_cosine_is_in_no_other_unit() {
    let model = "name = \"crank\"\ntitle = \"Crank\"\n\
        [inputs]\ncosine = { unit = \"1\" }\nsine = { unit = \"1\" }\n\
        [parameters]\nlead = { unit = \"rad\", scope = \"rig\" }\n\
        [measurands]\nx = { value = '0.8 m * (sine * cos(lead) + cosine * sin(lead))', unit = \"m\" }\n";
    let row = |run: f64, at: f64| {
        let (sine, cosine) = (1.7 * (at + run).sin()).sin_cos();
        vec![cosine, sine, 800.0 * (sine + 0.05 * cosine)]
    };
    let sigma = "[measurands]\nx = { sigma = \"5 mm\" }";
    let heads = "cosine [1],sine [1],x [mm]";
    let folder = with_another_unit("crank", (model, sigma), heads, row, (5.0, 1e-3));
    let one = found(&folder).unwrap();
    assert_eq!((&*one.what[0].numbers, one.run.as_deref()), (&["x".to_owned()][..], Some("2")));
    assert!(one.alike.iter().all(|one| one.numbers == ["x"]), "{one:?}");
}
