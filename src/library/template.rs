//! The first model of a new user.

/// A commented model that passes its own check, to be changed by its owner. `name` must be a valid
/// name, see [`crate::model::name::fault_of`].
pub fn template(name: &str) -> String {
    TEXT.replace("NAME", name)
}

const TEXT: &str = r#"# What an instrument reads, as formulas. Lengths, angles and times carry their units.
name   = "NAME"
title  = "What it is, in a few words"
source = "where the equations come from"

[inputs]                       # recorded beside the readings; a signal moves
arm_angle = { unit = "rad", signal = true, about = "encoder angle, zero at the homepoint" }

[parameters]                   # unknown, or known with a stated uncertainty: value = "1 m", sigma = "20 um"
radius      = { unit = "m", scope = "rig", start = "1 m", about = "arm axis to target" }
orientation = { kind = "rotation", scope = "setup", about = "arm frame to instrument frame" }
position    = { kind = "vector", unit = "m", scope = "setup", about = "the arm's centre seen from the instrument" }

[quantities]                   # in single quotes; each may name those above and below
arm_turn = 'rotation_z(arm_angle)'
target   = 'rotate(arm_turn, [radius, 0, 0])'
point    = 'rotate(orientation, target) + position'

[measurands]                   # what the instrument reads; each has its own delay, `distance.delay`
horizontal = { value = 'atan2(point.y, point.x)', kind = "angle", unit = "rad", period = "360 deg" }
vertical   = { value = 'atan2(hypot(point.x, point.y), point.z)', kind = "angle", unit = "rad" }
distance   = { value = 'norm(point)', unit = "m" }

[coordinates]                  # the target from one sample's readings: gives the fit its start
point = { from = 'target', rotation = "orientation", translation = "position", measured = 'distance * [sin(vertical) * cos(horizontal), sin(vertical) * sin(horizontal), cos(vertical)]' }
"#;
