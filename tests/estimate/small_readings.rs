//! Readings that a convention makes smaller fit their stated uncertainties whatever the model: that is no
//! evidence for it.

use crate::conventions::found;
use crate::folder::Folder;
use crate::problems::Stream;

/// A ball on the table of a five-axis machine, whose table turns about an axis beside the one that is
/// stated, not square to the tilt, and rises twice a turn. Inches for metres would leave a variance
/// factor of 0.03 of 193, where nothing is left to fit.
#[test]
fn inches_are_no_remedy_for_a_wrong_axis() {
    let model = "name = \"rtest\"\ntitle = \"Tilting table\"\n\
        [inputs]\na = { unit = \"rad\" }\nc = { unit = \"rad\" }\n\
        [parameters]\nprobe_zero = { kind = \"vector\", unit = \"m\", scope = \"rig\" }\n\
        ball_off = { kind = \"vector\", unit = \"m\", scope = \"rig\" }\n\
        [quantities]\ntilt_turn = 'rotation_x(a)'\ntable_turn = 'rotation_z(c)'\n\
        on_table = 'rotate(table_turn, ball_off)'\n\
        deviation = 'probe_zero + rotate(tilt_turn, on_table)'\n\
        [measurands]\ndx = { value = 'deviation.x', unit = \"m\" }\n\
        dy = { value = 'deviation.y', unit = \"m\" }\ndz = { value = 'deviation.z', unit = \"m\" }\n";
    let campaign = "title = \"Places\"\nmodel = \"model.toml\"\n[measurands]\n\
        dx = { sigma = \"1 um\" }\ndy = { sigma = \"1 um\" }\ndz = { sigma = \"1 um\" }\n\
        [[runs]]\nname = \"places\"\ndata = \"places.csv\"\n\
        columns = { a = \"A [deg]\", c = \"C [deg]\", dx = \"dX [um]\", dy = \"dY [um]\", dz = \"dZ [um]\" }\n";
    let mut table = "A [deg],C [deg],dX [um],dY [um],dZ [um]\n".to_owned();
    let mut random = Stream(3);
    for place in 0..210 {
        let (tilt, turn) = (f64::from(place / 30 * 25 - 75), f64::from(place % 30 * 12));
        let (a, c) = (tilt.to_radians(), turn.to_radians());
        // The ball is 150 mm from the axis and 120 mm above the table; lengths are in µm.
        let lean = -29.9;
        let x = 11.0 * c.cos() + 5.0 * c.sin() + 0.12 * lean;
        let y = 11.0 * c.sin() - 5.0 * c.cos() + 31.2;
        let rise = 4.8 * (2.0 * c).cos() + 2.65 * (2.0 * c).sin();
        let z = 8.0 - 0.15 * lean * c.cos() + rise;
        let read = [
            4.0 + x,
            a.cos() * y - a.sin() * z + 6.96 * a.sin() - 7.0,
            a.sin() * y + a.cos() * z + 6.96 * (1.0 - a.cos()) + 3.0,
        ];
        let [x, y, z] = read.map(|one| one + random.normal());
        table.push_str(&format!("{tilt:.0},{turn:.0},{x:.1},{y:.1},{z:.1}\n"));
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("places.csv", &table)];
    let one = found(&Folder::new("tilting_table", &files));
    assert!(one.is_none(), "{one:?}");
}
