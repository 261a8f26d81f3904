//! Coordinates in another unit than stated: one of them, or all of a place.

use crate::conventions::{found, names};
use crate::folder::Folder;
use crate::problems::Stream;

/// One coordinate of a place in feet beside two in metres, of what is read or of the log; all of them where
/// all are, though the place hardly moves along two.
#[test]
fn one_coordinate_in_feet_is_named_alone() {
    let model = "name = \"points\"\ntitle = \"Points of two systems\"\n\
        [inputs]\nax = { unit = \"m\" }\nay = { unit = \"m\" }\naz = { unit = \"m\" }\n\
        [parameters]\nfacing = { kind = \"rotation\", scope = \"setup\" }\n\
        shift = { kind = \"vector\", unit = \"m\", scope = \"setup\" }\n\
        [quantities]\ntarget = '[ax, ay, az]'\npoint = 'rotate(facing, target) + shift'\n\
        [measurands]\nx = { value = 'point.x', unit = \"m\" }\ny = { value = 'point.y', unit = \"m\" }\n\
        z = { value = 'point.z', unit = \"m\" }\n";
    let campaign = "title = \"Points\"\nmodel = \"model.toml\"\n\
        [measurands]\nx = { sigma = \"2 mm\" }\ny = { sigma = \"2 mm\" }\nz = { sigma = \"2 mm\" }\n\
        [[runs]]\nname = \"one\"\ndata = \"log.csv\"\n";
    let feet = |wanted: [bool; 6], spread: f64| {
        let mut random = Stream(83);
        let mut log = "ax [m],ay [m],az [m],x [m],y [m],z [m]\n".to_owned();
        for _ in 0..80 {
            let mut along = |size: f64| size * (2.0 * random.uniform() - 1.0);
            let own = [along(3.0), along(spread), 1.2 + along(spread)];
            let (sin, cos) = 0.4_f64.sin_cos();
            let turned = [cos * own[0] - sin * own[1], sin * own[0] + cos * own[1], own[2]];
            let read =
                [0, 1, 2].map(|at| turned[at] + [0.5, -0.2, 0.1][at] + 2e-3 * random.normal());
            let row: Vec<String> = own
                .iter()
                .chain(&read)
                .zip(wanted)
                .map(|(value, in_feet)| {
                    format!("{:.4}", if in_feet { value / 0.3048 } else { *value })
                })
                .collect();
            log.push_str(&format!("{}\n", row.join(",")));
        }
        let files = [("model.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
        found(&Folder::new("feet", &files)).unwrap()
    };
    let height = feet([false, false, false, false, false, true], 2.0);
    assert_eq!(
        (names(&height), &height.what[0].numbers[..]),
        (vec!["in_feet"], &["z".to_owned()][..])
    );
    assert!(height.variance_factors[1] < 2.0, "{height:?}");
    let logged = feet([false, true, false, false, false, false], 2.0);
    assert_eq!(
        (names(&logged), &logged.what[0].numbers[..]),
        (vec!["in_feet"], &["ay".to_owned()][..])
    );
    let all = feet([false, false, false, true, true, true], 0.02);
    assert_eq!(
        (names(&all), &all.what[0].numbers[..]),
        (vec!["coordinates_in_feet"], &["x", "y", "z"].map(str::to_owned)[..])
    );
}
