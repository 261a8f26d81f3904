//! A camera on a hand that moves, computed here and not by the program: poses of the hand as a
//! stream, positions and attitudes of the camera as data, one delay between their clocks.

use std::fmt::Write;

use homepoint::quaternion::Quaternion;

use crate::folder::Folder;
use crate::problems::Stream;

/// A time (s) and a pose: position (m), attitude.
pub(crate) type Pose = (f64, [f64; 3], Quaternion<f64>);

/// What is true, and how it is logged.
#[derive(Clone)]
pub(crate) struct Camera {
    /// The camera's stamp plus this is the moment on the hand's clock (s).
    pub(crate) delay: f64,
    /// Hand to camera (m), in the hand's frame.
    pub(crate) lever: [f64; 3],
    /// Camera frame to hand frame (rotation vector, rad).
    pub(crate) turn: [f64; 3],
    /// Base frame to target frame (rotation vector, rad), and where its origin is there (m).
    pub(crate) base: ([f64; 3], [f64; 3]),
    /// Standard deviations: positions (m), attitudes (rad).
    pub(crate) noise: (f64, f64),
    /// From, to and interval (s) of the hand's log and of the camera's, by their own clocks.
    pub(crate) hand: (f64, f64, f64),
    pub(crate) camera: (f64, f64, f64),
    /// The motion of the hand: place and rotation vector at a time.
    pub(crate) motion: fn(f64) -> ([f64; 3], [f64; 3]),
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            delay: 0.013,
            lever: [0.07, -0.03, 0.11],
            turn: [0.3, -1.2, 0.8],
            base: ([0.4, 0.2, -1.9], [0.6, -0.2, 1.1]),
            noise: (1e-3, 1e-3),
            hand: (-2.0, 22.0, 0.01),
            camera: (0.0, 20.0, 0.05),
            motion: wandering,
        }
    }
}

/// A motion that never repeats, whose attitude goes over full turns.
pub(crate) fn wandering(t: f64) -> ([f64; 3], [f64; 3]) {
    let place = [
        0.3 * (0.9 * t).sin() + 0.1 * (2.3 * t).cos(),
        0.25 * (1.1 * t + 0.4).sin() + 0.08 * (2.9 * t).sin(),
        0.2 * (0.7 * t).cos() + 0.06 * (1.9 * t + 1.0).sin(),
    ];
    let turn = [
        2.2 * (0.5 * t).sin() + 0.3 * (1.7 * t).cos(),
        1.6 * (0.8 * t + 0.7).sin(),
        0.9 * t + 0.5 * (1.3 * t).sin(),
    ];
    (place, turn)
}

fn rotation(vector: [f64; 3]) -> Quaternion<f64> {
    let angle = vector.iter().map(|one| one * one).sum::<f64>().sqrt();
    if angle == 0.0 { Quaternion::identity() } else { Quaternion::from_axis_angle(vector, angle) }
}

/// Turns about x, then y, then z, so that a steady turn about z is one.
fn turned([x, y, z]: [f64; 3]) -> Quaternion<f64> {
    rotation([0.0, 0.0, z]) * rotation([0.0, y, 0.0]) * rotation([x, 0.0, 0.0])
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

fn moments((from, to, interval): (f64, f64, f64)) -> impl Iterator<Item = f64> {
    let count = ((to - from) / interval).round() as u32;
    (0..=count).map(move |n| from + f64::from(n) * interval)
}

impl Camera {
    /// The pose of the hand on its own clock, without noise, of continuous sign.
    pub(crate) fn hand_poses(&self) -> Vec<Pose> {
        let mut last = Quaternion::identity();
        let each = moments(self.hand).map(|t| {
            let (place, turn) = (self.motion)(t);
            let q = turned(turn);
            let along =
                last.components().iter().zip(q.components()).map(|(a, b)| a * b).sum::<f64>();
            last = if along < 0.0 {
                Quaternion::from_components(q.components().map(|c| -c))
            } else {
                q
            };
            (t, place, last)
        });
        each.collect()
    }

    /// What the camera reads.
    pub(crate) fn camera_poses(&self, seed: u64) -> Vec<Pose> {
        let mut noise = Stream(seed);
        let mut three = |size: f64| std::array::from_fn(|_| size * noise.normal());
        let [base, mount] = [rotation(self.base.0), rotation(self.turn)];
        let each = moments(self.camera).map(|t| {
            let (place, turn) = (self.motion)(t + self.delay);
            let hand = turned(turn);
            let point = plus(base.rotate(plus(place, hand.rotate(self.lever))), self.base.1);
            let attitude = base * hand * mount * rotation(three(self.noise.1));
            (t, plus(point, three(self.noise.0)), attitude)
        });
        each.collect()
    }

    /// A campaign of both logs, with more lines at the top of campaign.toml.
    pub(crate) fn campaign(&self, head: &str, hand: &[Pose], camera: &[Pose]) -> Folder {
        let (place, turn) = self.noise;
        let text = format!(
            "title = \"Camera\"\nmodel = \"hand_eye\"\n{head}\n[measurands]\nx = {{ sigma = \"{place} m\" }}\ny = {{ sigma = \"{place} m\" }}\nz = {{ sigma = \"{place} m\" }}\nattitude = {{ sigma = \"{turn} rad\" }}\n[[runs]]\nname = \"run\"\ndata = \"camera.csv\"\nsignals = [\"hand.csv\"]\n"
        );
        let hand = table(
            "time [s],hand_x [m],hand_y [m],hand_z [m],hand_qw [1],hand_qx [1],hand_qy [1],hand_qz [1]",
            hand,
        );
        let camera = table(
            "time [s],x [m],y [m],z [m],attitude_w [1],attitude_x [1],attitude_y [1],attitude_z [1]",
            camera,
        );
        let files = [("campaign.toml", &*text), ("hand.csv", &*hand), ("camera.csv", &*camera)];
        Folder::new("camera", &files)
    }
}

impl Camera {
    /// A campaign of stops without times: in each row the poses of hand and camera.
    pub(crate) fn stops(&self, count: usize, seed: u64) -> Folder {
        let still = Self {
            delay: 0.0,
            hand: (0.0, 1.7 * (count - 1) as f64, 1.7),
            camera: (0.0, 1.7 * (count - 1) as f64, 1.7),
            ..self.clone()
        };
        let (place, turn) = self.noise;
        let campaign = format!(
            "title = \"Stops\"\nmodel = \"hand_eye\"\n[measurands]\nx = {{ sigma = \"{place} m\" }}\ny = {{ sigma = \"{place} m\" }}\nz = {{ sigma = \"{place} m\" }}\nattitude = {{ sigma = \"{turn} rad\" }}\n[[runs]]\nname = \"stops\"\ndata = \"stops.csv\"\n"
        );
        let columns = [
            "hand_x [m],hand_y [m],hand_z [m],hand_qw [1],hand_qx [1],hand_qy [1],hand_qz [1]",
            "x [m],y [m],z [m],attitude_w [1],attitude_x [1],attitude_y [1],attitude_z [1]",
        ];
        let mut text = format!("{}\n", columns.join(","));
        for ((_, [a, b, c], p), (_, [x, y, z], q)) in
            still.hand_poses().iter().zip(still.camera_poses(seed))
        {
            let ([pw, px, py, pz], [qw, qx, qy, qz]) = (p.components(), q.components());
            writeln!(text, "{a:.7},{b:.7},{c:.7},{pw:.8},{px:.8},{py:.8},{pz:.8},{x:.7},{y:.7},{z:.7},{qw:.8},{qx:.8},{qy:.8},{qz:.8}").unwrap();
        }
        Folder::new("stops", &[("campaign.toml", &*campaign), ("stops.csv", &*text)])
    }
}

/// Poses as a file: the header, then a row each.
fn table(header: &str, poses: &[Pose]) -> String {
    let mut text = format!("{header}\n");
    for (t, [x, y, z], q) in poses {
        let [qw, qx, qy, qz] = q.components();
        writeln!(text, "{t:.6},{x:.7},{y:.7},{z:.7},{qw:.8},{qx:.8},{qy:.8},{qz:.8}").unwrap();
    }
    text
}
