//! Numbers in another unit than stated are named, of all runs or of one; where a unit mends nothing it is
//! not.

use std::path::Path;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::conventions::mistaken;
use homepoint::estimate::start::start;
use homepoint::library::conventions;

use crate::conventions::{changed, found, names};
use crate::folder::Folder;
use crate::problems::Stream;
use crate::problems::camera::Camera;

/// Where one run of several is in another unit, that run and its unit are named, and no convention of
/// all of them.
#[test]
fn a_run_in_another_unit_is_named() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let mut opened = open(&Request::new([example])).unwrap();
    let part = &mut opened.problem.parts[0];
    let measurands = &part.system.assembly.names.measurands;
    let distance = measurands.iter().position(|one| one.name == "distance").unwrap();
    let distance = part.columns()[distance];
    let run = part.runs[3].name.clone();
    part.runs[3].record.edit(|samples| {
        samples.readings[distance].iter_mut().for_each(|reading| *reading *= 1e3);
    });
    let one = mistaken(&opened.problem, None, &conventions([]).unwrap()).unwrap();
    assert_eq!((names(&one), one.run.as_ref()), (vec!["in_thousandths"], Some(&run)), "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
    let text = homepoint::report::conventions::text(Some(&one));
    assert!(text.contains(&format!("mistaken in run `{run}`; set right")), "{text}");
    assert!(text.contains(&format!("of run `{run}`: columns = {{ distance = ")), "{text}");
}

/// Streams of one of three sessions in degrees, both angles of them: each by itself mends little.
#[test]
fn all_angles_of_a_stream_in_degrees_are_named_together() {
    let model = "name = \"head\"\ntitle = \"Pan and tilt\"\n\
        [inputs]\npan = { unit = \"rad\", signal = true }\ntilt = { unit = \"rad\", signal = true }\n\
        [parameters]\npan_zero = { unit = \"rad\" }\ntilt_zero = { unit = \"rad\" }\n\
        [measurands]\naz = { value = 'pan + pan_zero', kind = \"angle\", unit = \"rad\" }\n\
        el = { value = 'tilt + tilt_zero', kind = \"angle\", unit = \"rad\" }\n\
        [delays]\nhead = { of = [\"az\", \"el\"] }\n";
    let mut campaign = "title = \"Three\"\nmodel = \"model.toml\"\n\
        [measurands]\naz = { sigma = \"1 mrad\" }\nel = { sigma = \"1 mrad\" }\n"
        .to_owned();
    let mut random = Stream(17);
    let mut files: Vec<(String, String)> = Vec::new();
    for (run, by) in [("a", 1.0), ("b", 180.0 / std::f64::consts::PI), ("c", 1.0)] {
        campaign.push_str(&format!(
            "[[runs]]\nname = \"{run}\"\ndata = \"{run}.csv\"\nsignals = [\"{run}_sent.csv\"]\n"
        ));
        let phase = 6.0 * random.uniform();
        let pan = |t: f64| 0.9 * (0.9 * t + phase).sin() + 0.2 * (2.3 * t).sin();
        let tilt = |t: f64| 0.4 * (0.7 * t + 2.0 * phase).sin() + 0.1 * (1.9 * t).cos();
        let mut sent = "time [s],pan [rad],tilt [rad]\n".to_owned();
        let mut read = "time [s],az [rad],el [rad]\n".to_owned();
        for i in 0..1500 {
            let t = 0.02 * f64::from(i);
            sent.push_str(&format!("{t:.2},{:.7},{:.7}\n", by * pan(t), by * tilt(t)));
            if i % 5 == 0 && (100..1400).contains(&i) {
                let [az, el] = [pan(t - 0.03) + 0.2, tilt(t - 0.03) - 0.1];
                let [az, el] = [az, el].map(|angle| angle + 1e-3 * random.normal());
                read.push_str(&format!("{t:.2},{az:.6},{el:.6}\n"));
            }
        }
        files.extend([(format!("{run}.csv"), read), (format!("{run}_sent.csv"), sent)]);
    }
    files.extend(
        [("model.toml", model), ("campaign.toml", campaign.as_str())]
            .map(|(name, text)| (name.to_owned(), text.to_owned())),
    );
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let one = found(&Folder::new("degrees_in_one", &files)).unwrap();
    assert_eq!((names(&one), one.run.as_deref()), (vec!["in_degrees"], Some("b")), "{one:?}");
    assert_eq!(one.what[0].numbers, ["pan", "tilt"], "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// Readings that are components of one quantity belong together: an accelerometer on a platform that
/// tilts, logged in multiples of standard gravity.
#[test]
fn components_of_one_quantity_are_read_in_one_unit() {
    let model = "name = \"tilting\"\ntitle = \"Accelerometer on a tilting platform\"\n\
        [inputs]\nroll = { unit = \"rad\" }\npitch = { unit = \"rad\" }\n\
        [parameters]\nbias = { kind = \"vector\", unit = \"m/s^2\", scope = \"instrument\" }\n\
        [quantities]\nbody = 'rotation_y(pitch) * rotation_x(roll)'\n\
        force = 'rotate(inverse(body), [0 m/s^2, 0 m/s^2, 9.81 m/s^2]) + bias'\n\
        [measurands]\nax = { value = 'force.x', unit = \"m/s^2\" }\n\
        ay = { value = 'force.y', unit = \"m/s^2\" }\naz = { value = 'force.z', unit = \"m/s^2\" }\n";
    let campaign = "title = \"Twenty stops\"\nmodel = \"model.toml\"\n[measurands]\n\
        ax = { sigma = \"5 mm/s^2\" }\nay = { sigma = \"5 mm/s^2\" }\naz = { sigma = \"5 mm/s^2\" }\n\
        [[runs]]\nname = \"stops\"\ndata = \"stops.csv\"\n";
    let mut table = "roll [rad],pitch [rad],ax [m/s^2],ay [m/s^2],az [m/s^2]\n".to_owned();
    for stop in 0..20 {
        let (roll, pitch) = (0.5 * f64::from(stop * 7 % 20) / 20.0 - 0.2, 0.03 * f64::from(stop));
        // What rotates about y, then x, sees of a vertical force; an error of a few mm/s².
        let error = |k: i32| 0.004 * f64::from((stop * 13 + k * 5) % 7 - 3);
        let force = [
            -9.81 * pitch.sin() + 0.05 + error(0),
            9.81 * pitch.cos() * roll.sin() - 0.03 + error(1),
            9.81 * pitch.cos() * roll.cos() + 0.02 + error(2),
        ];
        let [x, y, z] = force.map(|one| one / 9.80665);
        table.push_str(&format!("{roll:.6},{pitch:.6},{x:.6},{y:.6},{z:.6}\n"));
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("stops.csv", &table)];
    let one = found(&Folder::new("accelerations_in_g", &files)).unwrap();
    assert_eq!(names(&one), ["accelerations_in_g"], "{one:?}");
    let typed: Vec<&str> = one.columns.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(typed, ["ax", "ay", "az"], "{one:?}");
}

/// A robot's velocities against motion capture that the model turns into the robot's frame, while the
/// log has them in the room's: noise in two of three measurands. Small numbers fit the stated
/// uncertainties, but no better than large ones fit theirs.
#[test]
fn a_small_unit_is_no_remedy_for_a_wrong_model() {
    let model = "name = \"twist\"\ntitle = \"Twist\"\n\
        [inputs]\npx = { unit = \"m\", signal = true }\npy = { unit = \"m\", signal = true }\n\
        yaw = { unit = \"rad\", signal = true }\n\
        [parameters]\nscale = { unit = \"1\", start = \"1\" }\n\
        [quantities]\n\
        velocity = 'rotate(inverse(rotation_z(yaw)), [rate(px), rate(py), 0 m/s])'\n\
        [measurands]\nvx = { value = 'scale * velocity.x', unit = \"m/s\" }\n\
        vy = { value = 'scale * velocity.y', unit = \"m/s\" }\n\
        wz = { value = 'rate(yaw)', unit = \"rad/s\" }\n\
        [delays]\nodometry = { of = [\"vx\", \"vy\", \"wz\"] }\n";
    let campaign = "title = \"Hall\"\nmodel = \"model.toml\"\n[measurands]\n\
        vx = { sigma = \"10 mm/s\" }\nvy = { sigma = \"10 mm/s\" }\nwz = { sigma = \"10 mrad/s\" }\n\
        [[runs]]\nname = \"hall\"\ndata = \"read.csv\"\nsignals = [\"sent.csv\"]\n";
    let mut random = Stream(23);
    let mut sent = "time [s],px [m],py [m],yaw [rad]\n".to_owned();
    let mut read = "time [s],vx [m/s],vy [m/s],wz [rad/s]\n".to_owned();
    // Place, and what its rates are.
    let place = |t: f64| {
        [
            2.0 * (0.31 * t).sin() + 0.3 * (1.1 * t).cos(),
            1.5 * (0.23 * t).cos(),
            0.7 * t + (0.5 * t).sin(),
        ]
    };
    let rates = |t: f64| {
        let x = 0.62 * (0.31 * t).cos() - 0.33 * (1.1 * t).sin();
        [x, -0.345 * (0.23 * t).sin(), 0.7 + 0.5 * (0.5 * t).cos()]
    };
    for i in 0..3000 {
        let t = 0.02 * f64::from(i);
        let [x, y, yaw] = place(t);
        sent.push_str(&format!("{t:.2},{x:.6},{y:.6},{yaw:.6}\n"));
        if i % 4 == 0 && (100..2900).contains(&i) {
            let cells = rates(t - 0.05).map(|rate| format!("{:.5}", rate + 0.01 * random.normal()));
            read.push_str(&format!("{t:.2},{}\n", cells.join(",")));
        }
    }
    let files = [
        ("model.toml", model),
        ("campaign.toml", campaign),
        ("sent.csv", sent.as_str()),
        ("read.csv", read.as_str()),
    ];
    let one = found(&Folder::new("twist_in_the_room", &files));
    assert!(one.is_none(), "{one:?}");
}

/// Coordinates in inches under heads that say millimetres.
#[test]
fn inches_for_millimetres_are_named() {
    let folder = Camera::default().stops(24, 3);
    for axis in ["x", "y", "z"] {
        changed(&folder, "stops.csv", axis, |value| value / 0.0254 / 1e3);
    }
    let one = found(&folder).unwrap();
    assert_eq!(names(&one), ["coordinates_in_inches_for_millimetres"], "{one:?}");
}

/// An input with a stated scatter and a free gain: in a smaller unit its gain would be larger, and the
/// readings as uncertain as that gain makes the scatter. They do not fit better so.
#[test]
fn an_input_with_scatter_is_in_no_smaller_unit() {
    let model = "name = \"valve\"\ntitle = \"Valve\"\n[inputs]\nset = { unit = \"1\" }\n\
        [parameters]\nzero = { unit = \"1\" }\ngain = { unit = \"1\" }\n\
        [measurands]\nlift = { value = 'gain * set + zero', unit = \"1\" }\n";
    let campaign = "title = \"Play\"\nmodel = \"model.toml\"\n[inputs]\nset = { sigma = \"0.01 %\" }\n\
        [measurands]\nlift = { sigma = \"0.1 %\" }\n[[runs]]\nname = \"loop\"\ndata = \"loop.csv\"\n";
    let mut table = "set [%],lift [%]\n".to_owned();
    let mut random = Stream(31);
    for i in 0..240 {
        let (turn, at) = (i / 40, f64::from(i % 40));
        // Play of 3 %: the lift stays behind on either way.
        let (set, behind) =
            if turn % 2 == 0 { (2.0 * at + 10.0, -1.5) } else { (90.0 - 2.0 * at, 1.5) };
        let lift = 0.98 * set + 1.3 + behind + 0.1 * random.normal();
        table.push_str(&format!("{set:.2},{lift:.3}\n"));
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("loop.csv", &table)];
    let found = found(&Folder::new("valve", &files));
    assert!(found.is_none(), "{found:?}");
}

/// A joint and its simulation: readings of an angle with a stated uncertainty each.
fn joint(read: impl Fn(f64) -> f64, noise: f64) -> Folder {
    let model = "name = \"joint\"\ntitle = \"Joint\"\n\
        [inputs]\nsent = { unit = \"rad\", signal = true }\n\
        [measurands]\nq = { value = 'sent', kind = \"angle\", unit = \"rad\" }\n";
    let campaign = "title = \"Joint\"\nmodel = \"model.toml\"\n[measurands]\nq = { sigma = \"s_q\" }\n\
        [[runs]]\nname = \"run\"\ndata = \"run.csv\"\nsignals = [\"sent.csv\"]\n";
    let mut random = Stream(23);
    let angle = |t: f64| 0.8 * (0.9 * t).sin() + 0.3 * (2.3 * t + 0.4).sin();
    let mut sent = "time [s],sent [rad]\n".to_owned();
    let mut own = "time [s],q [rad],s_q [rad]\n".to_owned();
    for i in 0..1500 {
        let t = 0.01 * f64::from(i);
        sent.push_str(&format!("{t:.2},{:.7}\n", angle(t)));
        if (100..1400).contains(&i) {
            let q = read(angle(t + 0.009)) + noise * random.normal();
            own.push_str(&format!("{t:.2},{q:.6},0.0005\n"));
        }
    }
    let files = [("model.toml", model), ("campaign.toml", campaign)];
    let files = files.into_iter().chain([("run.csv", &*own), ("sent.csv", &*sent)]);
    Folder::new("joint", &files.collect::<Vec<_>>())
}

#[test]
fn degrees_with_the_other_sense_are_named_together() {
    let folder = joint(|angle| -angle.to_degrees(), 0.0005_f64.to_degrees());
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    let one = mistaken(&problem, None, &conventions([]).unwrap()).unwrap();
    assert_eq!(one.what[0].name, "in_degrees and reversed_sign", "{one:?}");
    assert_eq!(one.columns, [("q".to_owned(), "-(q * pi / 180)".to_owned())], "{one:?}");
}

/// Larger uncertainties fit anything: the column that states them is no number of another unit.
#[test]
fn a_column_of_uncertainties_is_in_no_other_unit() {
    let folder = joint(|angle| angle, 0.005);
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    let found = mistaken(&problem, None, &conventions([]).unwrap());
    assert!(found.is_none(), "{found:?}");
}

/// Forces in pounds-force: a diagnosis sets the weighed mass free, for another mass does as well. From
/// where that fit ended the convention is found all the same.
#[test]
fn a_convention_is_found_from_a_fit_in_which_a_stated_value_was_free() {
    let model = "name = \"wrist\"\ntitle = \"Weight at a wrist\"\n\
        [inputs]\nroll = { unit = \"rad\" }\n\
        [parameters]\nmass = { unit = \"kg\", value = \"2.1 kg\", fixed = true }\nzero = { unit = \"N\" }\n\
        [measurands]\nside = { value = 'mass * 9.81 m/s^2 * sin(roll) + zero', unit = \"N\" }\n";
    let mut random = Stream(19);
    let mut log = "roll [rad],side [N]\n".to_owned();
    for _ in 0..80 {
        let roll = 3.0 * random.uniform() - 1.5;
        let side = (2.1 * 9.81 * roll.sin() + 0.4 + 0.05 * random.normal()) / 4.448_221_615;
        log.push_str(&format!("{roll:.5},{side:.5}\n"));
    }
    let campaign = "title = \"Wrist\"\nmodel = \"model.toml\"\n\
        [measurands]\nside = { sigma = \"0.05 N\" }\n[[runs]]\nname = \"one\"\ndata = \"log.csv\"\n";
    let files = [("model.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
    let folder = Folder::new("pounds", &files);
    let opened = open(&Request::new([&folder])).unwrap();
    let mut fitted = start(&opened.problem).0;
    let mass = opened.problem.layout.instances.iter().position(|one| one.name == "mass").unwrap();
    fitted.values[mass][0] = 2.1 / 4.448_221_615;
    let conventions = conventions([]).unwrap();
    let one = mistaken(&opened.problem, Some(&fitted), &conventions).unwrap();
    assert_eq!(names(&one), ["in_pounds_force"], "{one:?}");
}

/// All angles in gon under degrees, of which the vertical one counts from the horizon: neither by itself
/// brings the model near to its readings.
#[test]
fn gon_and_another_axis_are_found_together() {
    let model = "name = \"station\"\ntitle = \"Free station\"\n\
        [inputs]\nx = { unit = \"m\" }\ny = { unit = \"m\" }\nz = { unit = \"m\" }\n\
        [parameters]\nposition = { unit = \"m\", kind = \"vector\", start = [\"40 m\", \"-60 m\", \"2 m\"] }\n\
        circle = { unit = \"rad\", start = \"200 deg\" }\n\
        [quantities]\nseen = '[x, y, z] - position'\n\
        [measurands]\nhz = { value = 'atan2(seen.y, seen.x) - circle', kind = \"angle\", unit = \"rad\", period = \"360 deg\" }\n\
        zd = { value = 'atan2(hypot(seen.x, seen.y), seen.z)', kind = \"angle\", unit = \"rad\" }\n\
        sd = { value = 'norm(seen)', unit = \"m\" }\n";
    let mut random = Stream(23);
    let mut log = "x [m],y [m],z [m],hz [deg],zd [deg],sd [m]\n".to_owned();
    for _ in 0..40 {
        let mut along = |size: f64| size * (2.0 * random.uniform() - 1.0);
        let (x, y, z) = (along(90.0), along(90.0), along(20.0));
        let [dx, dy, dz] = [x - 43.0, y + 58.0, z - 1.2];
        let gon = |angle: f64| angle * 200.0 / std::f64::consts::PI;
        let hz = gon(dy.atan2(dx) - 3.4 + 2e-5 * random.normal()).rem_euclid(400.0);
        let elevation = gon(dz.atan2(dx.hypot(dy)) + 2e-5 * random.normal());
        let sd = (dx * dx + dy * dy + dz * dz).sqrt() + 1e-3 * random.normal();
        log.push_str(&format!("{x:.4},{y:.4},{z:.4},{hz:.5},{elevation:.5},{sd:.4}\n"));
    }
    let campaign = "title = \"Station\"\nmodel = \"model.toml\"\n\
        [measurands]\nhz = { sigma = \"20 urad\" }\nzd = { sigma = \"20 urad\" }\nsd = { sigma = \"1 mm\" }\n\
        [[runs]]\nname = \"one\"\ndata = \"log.csv\"\n";
    let files = [("model.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
    let one = found(&Folder::new("gon_and_zenith", &files)).unwrap();
    let all = names(&one);
    assert!(all.contains(&"complement") && all.contains(&"in_gon"), "{one:?}");
    let gon = one.what.iter().find(|own| own.name == "in_gon").unwrap();
    assert_eq!(gon.numbers, ["hz", "zd"], "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// A force plate whose y axis points the other way: the place and the force along it have the other sign,
/// numbers of two kinds of which neither helps without the other.
#[test]
fn an_axis_of_a_place_and_of_a_force_is_mirrored_together() {
    let model = "name = \"plate\"\ntitle = \"Force plate\"\n\
        [inputs]\ntip_x = { unit = \"m\" }\ntip_y = { unit = \"m\" }\npush_x = { unit = \"N\" }\npush_y = { unit = \"N\" }\n\
        [parameters]\nheading = { unit = \"rad\" }\nat_x = { unit = \"m\" }\nat_y = { unit = \"m\" }\n\
        [quantities]\ndx = 'tip_x - at_x'\ndy = 'tip_y - at_y'\n\
        [measurands]\ncx = { value = 'cos(heading) * dx + sin(heading) * dy', unit = \"m\" }\n\
        cy = { value = 'cos(heading) * dy - sin(heading) * dx', unit = \"m\" }\n\
        fx = { value = 'cos(heading) * push_x + sin(heading) * push_y', unit = \"N\" }\n\
        fy = { value = 'cos(heading) * push_y - sin(heading) * push_x', unit = \"N\" }\n";
    let mut random = Stream(29);
    let mut log =
        "tip_x [m],tip_y [m],push_x [N],push_y [N],cx [m],cy [m],fx [N],fy [N]\n".to_owned();
    for _ in 0..60 {
        let mut along = |size: f64| size * (2.0 * random.uniform() - 1.0);
        let (x, y, px, py) = (along(0.3), along(0.25), along(60.0), along(60.0));
        let (sin, cos) = (-0.05_f64).sin_cos();
        let [dx, dy] = [x - 0.01, y + 0.02];
        let mut read = |value: f64, noise: f64| value + noise * random.normal();
        let (cx, cy) = (read(cos * dx + sin * dy, 2e-3), read(sin * dx - cos * dy, 2e-3));
        let (fx, fy) = (read(cos * px + sin * py, 1.5), read(sin * px - cos * py, 1.5));
        log.push_str(&format!("{x:.4},{y:.4},{px:.2},{py:.2},{cx:.4},{cy:.4},{fx:.2},{fy:.2}\n"));
    }
    let campaign = "title = \"Plate\"\nmodel = \"model.toml\"\n\
        [measurands]\ncx = { sigma = \"2 mm\" }\ncy = { sigma = \"2 mm\" }\nfx = { sigma = \"1.5 N\" }\nfy = { sigma = \"1.5 N\" }\n\
        [[runs]]\nname = \"one\"\ndata = \"log.csv\"\n";
    let files = [("model.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
    let one = found(&Folder::new("plate", &files)).unwrap();
    let mut numbers: Vec<&String> = one.what.iter().flat_map(|own| &own.numbers).collect();
    numbers.sort_unstable();
    assert_eq!(numbers, ["cy", "fy"], "{one:?}");
    assert!(one.what.iter().all(|own| own.name == "reversed_sign"), "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// An axis whose readings in mm are stated as um, with errors of several micrometres: positions in
/// thousandths would fit as well, with residuals far smaller than stated.
#[test]
fn residuals_far_smaller_than_stated_are_no_better_fit() {
    let model = "name = \"axis\"\ntitle = \"Axis\"\n[inputs]\nnominal = { unit = \"m\" }\n\
        [parameters]\nzero = { unit = \"m\" }\n[measurands]\nposition = { value = 'nominal + zero', unit = \"m\" }\n";
    let campaign = "title = \"Axis\"\nmodel = \"model.toml\"\n[measurands]\n\
        position = { sigma = \"0.4 um\" }\n[[runs]]\nname = \"all\"\ndata = \"all.csv\"\n";
    let mut random = Stream(5);
    // The units that heads state, and where the true factor is: of the reading, or of the input.
    for (heads, due, other, formula) in [
        (["mm", "um"], "position", "nominal", "position * 1000"),
        (["um", "mm"], "nominal", "position", "nominal * 1000"),
    ] {
        let mut table = format!("nominal [{}],position [{}]\n", heads[0], heads[1]);
        for i in 0..300 {
            let x = 12.5 * f64::from(i % 41);
            let error = 0.003 * (0.02 * x).sin() + 0.0004 * random.normal();
            table.push_str(&format!("{x:.1},{:.5}\n", x + error));
        }
        let files = [("model.toml", model), ("campaign.toml", campaign), ("all.csv", &*table)];
        let folder = Folder::new("axis", &files);
        let problem = open(&Request::new([&*folder])).unwrap().problem;
        let one = mistaken(&problem, None, &conventions([]).unwrap()).unwrap();
        assert_eq!(one.what[0].numbers, [due], "{one:?}");
        let alike: Vec<&String> = one.alike.iter().flat_map(|one| &one.numbers).collect();
        assert!(one.what.len() == 1 && alike.iter().all(|name| *name == other), "{one:?}");
        assert!(!alike.is_empty() && one.variance_factors[1] > 4.0, "{one:?}");
        assert!(one.columns.iter().any(|(_, own)| own == formula), "{one:?}");
    }
}
