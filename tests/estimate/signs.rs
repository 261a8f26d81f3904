//! Of two minima that fit alike a start says which is meant.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::minima::improved;

use crate::folder::Folder;
use crate::problems::Stream;

/// A marker on a wheeled robot in a frame that is turned by more than a right angle: a scale of 1.02
/// there, or of -1.02 with the frame turned by half a turn.
#[test]
fn a_scale_keeps_the_sign_with_which_it_starts() {
    let model = "name = \"robot\"\ntitle = \"Marker on a robot\"\n\
        [inputs]\nax = { unit = \"m\" }\nay = { unit = \"m\" }\nheading = { unit = \"rad\" }\n\
        [parameters]\nframe = { unit = \"rad\" }\nplace_x = { unit = \"m\" }\nplace_y = { unit = \"m\" }\n\
        scale = { unit = \"1\", start = \"1\" }\nlever = { unit = \"m\" }\n\
        [quantities]\nalong = 'scale * ax + cos(heading) * lever'\n\
        across = 'scale * ay + sin(heading) * lever'\n\
        [measurands]\n\
        x = { value = 'cos(frame) * along - sin(frame) * across + place_x', unit = \"m\", sigma = \"1 mm\" }\n\
        y = { value = 'sin(frame) * along + cos(frame) * across + place_y', unit = \"m\", sigma = \"1 mm\" }\n";
    let campaign = "title = \"Hall\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"hall\"\ndata = \"read.csv\"\n";
    for frame in [-2.4, -1.0, 0.4, 2.2_f64] {
        let mut random = Stream(7);
        let mut table = "ax [m],ay [m],heading [rad],x [m],y [m]\n".to_owned();
        for k in 0..80 {
            let t = 0.2 * f64::from(k);
            let [ax, ay, heading] = [2.0 * (0.4 * t).sin(), 1.5 * (0.3 * t).cos(), 0.6 * t];
            let along = 1.02 * ax + heading.cos() * 0.12;
            let across = 1.02 * ay + heading.sin() * 0.12;
            let x = frame.cos() * along - frame.sin() * across + 1.7 + 1e-3 * random.normal();
            let y = frame.sin() * along + frame.cos() * across - 0.6 + 1e-3 * random.normal();
            table.push_str(&format!("{ax:.6},{ay:.6},{heading:.6},{x:.6},{y:.6}\n"));
        }
        let files = [("model.toml", model), ("campaign.toml", campaign), ("read.csv", &table)];
        let folder = Folder::new("marker", &files);
        let problem = open(&Request::new([&*folder])).unwrap().problem;
        let (problem, _) = improved(problem);
        let fit = calibrate(problem, &Default::default()).unwrap();
        let value = |name: &str| {
            let found = fit.estimates().into_iter().find(|one| one.name == name);
            found.and_then(|one| one.value).unwrap()
        };
        assert!((value("scale") - 1.02).abs() < 1e-3, "{frame}: {}", value("scale"));
        assert!((value("lever") - 0.12).abs() < 1e-3, "{frame}: {}", value("lever"));
        let apart = (value("frame") - frame).sin().abs();
        assert!(
            apart < 1e-3 && (value("frame") - frame).cos() > 0.0,
            "{frame}: {}",
            value("frame")
        );
    }
}

/// Where the readings exclude the stated sign, theirs stays.
#[test]
fn readings_decide_where_only_one_sign_fits() {
    let model = "name = \"axis\"\ntitle = \"Axis\"\n[inputs]\nsent = { unit = \"m\" }\n\
        [parameters]\nzero = { unit = \"rad\" }\ngain = { unit = \"rad/m\", start = \"1 rad/m\" }\n\
        [measurands]\nq = { value = 'gain * sent + zero', kind = \"angle\", unit = \"rad\", sigma = \"1 mrad\" }\n";
    let campaign =
        "title = \"Axis\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"a\"\ndata = \"read.csv\"\n";
    let mut random = Stream(9);
    let mut table = "sent [m],q [rad]\n".to_owned();
    for k in 0..60 {
        let sent = 0.01 * f64::from(k);
        table.push_str(&format!("{sent:.3},{:.6}\n", 0.3 - 0.9 * sent + 1e-3 * random.normal()));
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("read.csv", &table)];
    let folder = Folder::new("axis", &files);
    let (problem, _) = improved(open(&Request::new([&*folder])).unwrap().problem);
    let fit = calibrate(problem, &Default::default()).unwrap();
    let found = fit.estimates().into_iter().find(|one| one.name == "gain").unwrap();
    assert!((found.value.unwrap() + 0.9).abs() < 0.01, "{found:?}");
}
