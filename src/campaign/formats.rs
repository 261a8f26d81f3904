//! Formats of logs that other programs share, by name: which of their columns is what, in which unit.
//!
//! A format knows roles (time, position, attitude), not models: which inputs or measurands have a
//! role is `roles`' business. To add a format, add a row to [`FORMATS`]; a test asks for its name in
//! `docs/files-as-they-are.md`.

use crate::units::Unit;

/// What a column of a format is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A part of the stamp, which is the sum of its parts; most have the part 0 alone.
    Time(usize),
    /// A component of the position: 0 to 2 for x, y, z.
    Position(usize),
    /// A component of the attitude's quaternion: 0 to 3 for w, x, y, z.
    Attitude(usize),
    /// A column that says neither.
    Other,
}

/// A column of a format: its role, its unit where the header has none, its names.
type FormatColumn = (Role, &'static str, &'static [&'static str]);

/// A format.
#[derive(Debug, PartialEq)]
pub struct Format {
    /// Its name in a campaign.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Whether a file without header has these columns, in their order.
    pub by_order: bool,
    /// Its columns.
    pub columns: &'static [FormatColumn],
}

use Role::{Attitude, Other, Position, Time};

/// The known formats.
pub const FORMATS: &[Format] = &[
    Format {
        name: "tum",
        about: "poses as the TUM benchmark has them: seconds, position, quaternion x y z w",
        by_order: true,
        columns: &[
            (Time(0), "s", &["timestamp"]),
            (Position(0), "m", &["tx"]),
            (Position(1), "m", &["ty"]),
            (Position(2), "m", &["tz"]),
            (Attitude(1), "1", &["qx"]),
            (Attitude(2), "1", &["qy"]),
            (Attitude(3), "1", &["qz"]),
            (Attitude(0), "1", &["qw"]),
        ],
    },
    Format {
        name: "asl",
        about: "poses as ETH's ASL and EuRoC have them: nanoseconds, position, quaternion w x y z",
        by_order: false,
        columns: &[
            (Time(0), "ns", &["timestamp"]),
            (Position(0), "m", &["p_RS_R_x", "p_RS_x"]),
            (Position(1), "m", &["p_RS_R_y", "p_RS_y"]),
            (Position(2), "m", &["p_RS_R_z", "p_RS_z"]),
            (Attitude(0), "1", &["q_RS_w"]),
            (Attitude(1), "1", &["q_RS_x"]),
            (Attitude(2), "1", &["q_RS_y"]),
            (Attitude(3), "1", &["q_RS_z"]),
        ],
    },
    Format {
        name: "ros_pose",
        about: "poses as `rostopic echo -p` writes them: stamps in nanoseconds",
        by_order: false,
        columns: &[
            (Time(0), "ns", &["field.header.stamp"]),
            (Position(0), "m", &POSITION[0]),
            (Position(1), "m", &POSITION[1]),
            (Position(2), "m", &POSITION[2]),
            (Attitude(0), "1", &ATTITUDE[0]),
            (Attitude(1), "1", &ATTITUDE[1]),
            (Attitude(2), "1", &ATTITUDE[2]),
            (Attitude(3), "1", &ATTITUDE[3]),
        ],
    },
    Format {
        name: "ros2_pose",
        about: "poses as `ros2 topic echo --csv` writes PoseStamped: sec, nanosec, frame, position, quaternion x y z w",
        by_order: true,
        columns: &[
            (Time(0), "s", &["header.stamp.sec"]),
            (Time(1), "ns", &["header.stamp.nanosec"]),
            (Other, "1", &["header.frame_id"]),
            (Position(0), "m", &["pose.position.x"]),
            (Position(1), "m", &["pose.position.y"]),
            (Position(2), "m", &["pose.position.z"]),
            (Attitude(1), "1", &["pose.orientation.x"]),
            (Attitude(2), "1", &["pose.orientation.y"]),
            (Attitude(3), "1", &["pose.orientation.z"]),
            (Attitude(0), "1", &["pose.orientation.w"]),
        ],
    },
    Format {
        name: "ros2_transform",
        about: "poses as `ros2 topic echo --csv` writes TransformStamped: sec, nanosec, two frames, translation, quaternion x y z w",
        by_order: true,
        columns: &[
            (Time(0), "s", &["header.stamp.sec"]),
            (Time(1), "ns", &["header.stamp.nanosec"]),
            (Other, "1", &["header.frame_id"]),
            (Other, "1", &["child_frame_id"]),
            (Position(0), "m", &["transform.translation.x"]),
            (Position(1), "m", &["transform.translation.y"]),
            (Position(2), "m", &["transform.translation.z"]),
            (Attitude(1), "1", &["transform.rotation.x"]),
            (Attitude(2), "1", &["transform.rotation.y"]),
            (Attitude(3), "1", &["transform.rotation.z"]),
            (Attitude(0), "1", &["transform.rotation.w"]),
        ],
    },
    Format {
        name: "rtklib",
        about: "positions as RTKLIB writes them with -e or -a: date and time of day, x y z or east north up",
        by_order: false,
        columns: &[
            (Time(0), "s", &["GPST", "UTC", "JST"]),
            (Position(0), "m", &["e-baseline", "x-ecef"]),
            (Position(1), "m", &["n-baseline", "y-ecef"]),
            (Position(2), "m", &["u-baseline", "z-ecef"]),
        ],
    },
];

/// What messages with poses call their parts.
const POSITION: [[&str; 3]; 3] = [
    ["field.pose.position.x", "field.pose.pose.position.x", "field.transform.translation.x"],
    ["field.pose.position.y", "field.pose.pose.position.y", "field.transform.translation.y"],
    ["field.pose.position.z", "field.pose.pose.position.z", "field.transform.translation.z"],
];
const ATTITUDE: [[&str; 3]; 4] = [
    ["field.pose.orientation.w", "field.pose.pose.orientation.w", "field.transform.rotation.w"],
    ["field.pose.orientation.x", "field.pose.pose.orientation.x", "field.transform.rotation.x"],
    ["field.pose.orientation.y", "field.pose.pose.orientation.y", "field.transform.rotation.y"],
    ["field.pose.orientation.z", "field.pose.pose.orientation.z", "field.transform.rotation.z"],
];

/// How far the length of a quaternion of a format may be off 1.
const OFF_LENGTH: f64 = 0.01;

impl Format {
    /// The format of a name.
    pub fn of(name: &str) -> Option<&'static Self> {
        FORMATS.iter().find(|format| format.name == name)
    }

    /// The format whose columns are all among these names of a header.
    pub(crate) fn with_names(names: &[&str]) -> Option<&'static Self> {
        let has_all = |format: &&Self| {
            let mut roles = format.columns.iter().map(|(role, ..)| *role);
            roles.all(|role| format.named(role, names).is_some())
        };
        FORMATS.iter().find(has_all)
    }

    /// The format of a file without header whose first rows hold these numbers.
    pub(crate) fn with_rows(rows: &[Vec<f64>]) -> Option<&'static Self> {
        let fits = |format: &&Self| {
            let place = |role| format.columns.iter().position(|(own, ..)| *own == role);
            let quaternion: Option<Vec<usize>> = (0..4).map(|k| place(Attitude(k))).collect();
            let (Some(time), Some(quaternion)) = (place(Time(0)), quaternion) else { return false };
            let is_pose = |row: &Vec<f64>| {
                let mut all = format.columns.iter().zip(row);
                row.len() == format.columns.len()
                    && all.all(|((role, ..), cell)| *role == Other || cell.is_finite())
                    && {
                        let square = quaternion.iter().map(|k| row[*k] * row[*k]).sum::<f64>();
                        (square.sqrt() - 1.0).abs() < OFF_LENGTH
                    }
            };
            // Rows may be out of order.
            let goes_on = |pair: &&[Vec<f64>]| pair[1][time] >= pair[0][time];
            let on = rows.windows(2).filter(goes_on).count();
            !rows.is_empty() && rows.iter().all(is_pose) && 4 * on >= 3 * (rows.len() - 1)
        };
        FORMATS.iter().filter(|format| format.by_order).find(fits)
    }

    /// Where a role stands in a file whose columns have these names: by its name, else by its order.
    pub(crate) fn place(&self, role: Role, names: &[&str]) -> Option<usize> {
        let is_whole = self.by_order && names.len() == self.columns.len();
        let by_order = || self.columns.iter().position(|(own, ..)| *own == role && is_whole);
        self.named(role, names).or_else(by_order)
    }

    fn named(&self, role: Role, names: &[&str]) -> Option<usize> {
        let (.., all) = self.columns.iter().find(|(own, ..)| *own == role)?;
        let is_it = |name: &&str| all.iter().any(|own| own.eq_ignore_ascii_case(name));
        names.iter().position(is_it)
    }

    /// The unit of a role where the header has none.
    pub(crate) fn unit(&self, role: Role) -> Unit {
        let own = self.columns.iter().find(|(own, ..)| *own == role);
        own.and_then(|(_, unit, _)| Unit::parse(unit).ok()).unwrap_or_else(Unit::one)
    }
}

/// Names of columns of dates in a zone, and how far it is ahead of UTC (h).
const ZONES: [(&str, u8); 1] = [("JST", 9)];

/// How far the dates of a column of this name are ahead of UTC (h), if they are.
pub(crate) fn ahead_of_utc(name: &str) -> Option<u8> {
    ZONES.iter().find(|(own, _)| own.eq_ignore_ascii_case(name)).map(|(_, hours)| *hours)
}

/// Seconds from 1970 on between which logs are written: 2001 to 2100.
const SINCE_1970: std::ops::Range<f64> = 1e9..4.1e9;

/// The unit in which a stamp of these years counts from 1970 on, if it does.
pub(crate) fn unit_since_1970(stamp: f64) -> Option<&'static str> {
    let units = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
    let unit = units.into_iter().find(|(_, factor)| SINCE_1970.contains(&(stamp * factor)));
    unit.map(|(symbol, _)| symbol)
}
