//! Campaigns begun from logs: which columns are called alike, which are not used, which show no noise.

use std::path::PathBuf;

use homepoint::campaign::begin::{Begun, begin};

use crate::begin::library;
use crate::folder::Folder;
use crate::stream::Stream;

fn begun(files: [(&str, &str); 2]) -> Begun {
    let folder = Folder::new("begin-alike", &files);
    let logs = files.map(|(name, _)| (folder.join(name), PathBuf::from(name)));
    begin(&logs, None, &library(), None).unwrap()
}

/// Rows of a table; each number is made from the time and noise.
fn table(head: &str, every: f64, of: impl Fn(f64, &mut Stream) -> Vec<f64>) -> String {
    let mut stream = Stream(5);
    let mut text = format!("{head}\n");
    for n in 0..400 {
        let time = every * f64::from(n);
        let cells = std::iter::once(time).chain(of(time, &mut stream));
        let cells: Vec<String> = cells.map(|cell| format!("{cell:.6}")).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

#[test]
fn a_name_within_another_one_is_alike() {
    let way = |t: f64| (0.9 * t).sin();
    for (own, heads, other) in [
        ("x", "cmd,sim_x,dx_dk", "sim_x"),
        ("x_meas", "trolley,x_sim,sigma_x", "x_sim"),
        ("rig.x", "trolley,rig_x_model,y", "rig_x_model"),
    ] {
        let heads: Vec<String> = heads.split(',').map(|head| format!("{head} [m]")).collect();
        let data = table(&format!("time [s],{own} [mm]"), 0.05, |t, stream| {
            vec![1e3 * way(t) + stream.normal()]
        });
        let stream = table(&format!("time [s],{}", heads.join(",")), 0.05 / 2.0, |t, _| {
            vec![way(t + 0.3), way(t), 0.1 * way(t)]
        });
        let begun = begun([("data.csv", &data), ("stream.csv", &stream)]);
        let expected = format!("{{ column = \"{other}\", unit = \"m\" }}");
        assert!(begun.campaign.contains(&expected), "{other}\n{}", begun.campaign);
    }
}

#[test]
fn what_does_not_vary_shows_no_noise_and_what_is_not_used_is_listed() {
    let turn = |t: f64| 0.4 * (0.7 * t).sin();
    let data = table("time [s],x [m],y [m],z [m],heading [rad]", 0.05, |t, stream| {
        let noise = 1e-3 * stream.normal();
        vec![(0.5 * t).sin() + noise, (0.3 * t).cos() + noise, 0.0, turn(t)]
    });
    let poses = table("time [s],px [m],py [m],pz [m],qx [],qy [],qz [],qw []", 0.025, |t, _| {
        let (sin, cos) = (0.5 * turn(t)).sin_cos();
        vec![(0.5 * t).sin(), (0.3 * t).cos(), 0.1 * (0.2 * t).sin(), 0.0, 0.0, sin, cos]
    });
    let begun = begun([("data.csv", &data), ("poses.csv", &poses)]);
    let line = begun.campaign.lines().find(|line| line.contains("z = { sigma"));
    assert!(line.is_some_and(|line| line.contains("WRITE it: all of its readings are the same")));
    let is_listed = |line: &String| line.contains("not used of `data.csv`: `heading`");
    assert!(begun.unused.iter().any(is_listed), "{:?}\n{}", begun.unused, begun.campaign);
}
