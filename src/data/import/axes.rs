//! Axes of the tracker, written as `x=+y,y=-x,z=+z`.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::str::FromStr;

/// The project's axes (x up, z along the straight robot) in terms of the tracker's: a rotation by
/// quarter turns, and a reflection where the tracker's axes are left-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    turn: Matrix3<f64>,
}

/// Text that does not describe axes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found {found}, expected each axis once, right-handed, such as {example}", example = Axes::Y_UP)]
pub struct BadAxes {
    found: String,
}

impl Axes {
    /// y up in the tracker (Motive's default), the robot along its z.
    pub const Y_UP: &'static str = "x=+y,y=-x,z=+z";

    /// The tracker's own axes.
    pub const SAME: &'static str = "x=+x,y=+y,z=+z";

    /// These axes, turned once more by a quarter turn in the project's frame.
    pub(crate) fn then(&self, turn: &Matrix3<f64>) -> Axes {
        Axes { turn: turn * self.turn }
    }

    /// Transforms a vector from the tracker's to the project's axes.
    pub(crate) fn vector(&self, tracked: &Vector3<f64>) -> Vector3<f64> {
        self.turn * tracked
    }

    /// Transforms a rotation from the tracker's to the project's axes.
    pub(crate) fn rotation(&self, tracked: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        // A reflection turns the sense of a rotation about the reflected axis.
        let axis = self.turn * tracked.imag() * self.turn.determinant();
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::from_parts(tracked.w, axis))
    }
}

impl std::fmt::Display for Axes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (own_axis, name) in NAMES.into_iter().enumerate() {
            let tracker_axis = self.turn.row(own_axis).iamax_full().1;
            let sign = if self.turn[(own_axis, tracker_axis)] < 0.0 { '-' } else { '+' };
            let comma = if own_axis == 0 { "" } else { "," };
            write!(f, "{comma}{name}={sign}{}", NAMES[tracker_axis])?;
        }
        Ok(())
    }
}

/// Names of the axes.
const NAMES: [&str; 3] = ["x", "y", "z"];

impl FromStr for Axes {
    type Err = BadAxes;

    fn from_str(words: &str) -> Result<Axes, BadAxes> {
        Axes::of_hand(words, false)
    }
}

impl Axes {
    /// Reads axes in terms of right-handed or left-handed ones.
    ///
    /// # Errors
    /// [`BadAxes`] when an axis is missing or the hand is the other.
    pub(crate) fn of_hand(words: &str, left_handed: bool) -> Result<Axes, BadAxes> {
        let hand = if left_handed { -1.0 } else { 1.0 };
        let bad = |found: &str| BadAxes { found: found.to_owned() };
        let mut turn = Matrix3::zeros();
        let parts: Vec<&str> = words.split(',').collect();
        for part in &parts {
            let (own_axis, tracker_axis) =
                part.split_once('=').ok_or_else(|| bad(&format!("`{part}`")))?;
            let tracker_axis = tracker_axis.trim();
            let sign = if tracker_axis.starts_with('-') { -1.0 } else { 1.0 };
            let tracker_axis = tracker_axis.strip_prefix(['+', '-']).unwrap_or(tracker_axis);
            let entry = axis(own_axis).zip(axis(tracker_axis));
            turn[entry.ok_or_else(|| bad(&format!("`{part}`")))?] += sign;
        }
        // A repeated axis leaves another without any, and the determinant 0.
        match (parts.len(), turn.determinant() * hand) {
            (3, 1.0) => Ok(Axes { turn }),
            (3, -1.0) => {
                Err(bad(if left_handed { "right-handed axes" } else { "left-handed axes" }))
            }
            _ => Err(bad("an axis twice, or no axis")),
        }
    }
}

fn axis(name: &str) -> Option<usize> {
    NAMES.iter().position(|axis| *axis == name.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_and_its_axis_map_alike() {
        let axes: Axes = Axes::Y_UP.parse().unwrap();
        assert_eq!(axes.vector(&Vector3::new(1.0, 2.0, 3.0)), Vector3::new(2.0, -1.0, 3.0));
        let (turn, arm) =
            (UnitQuaternion::new(Vector3::new(0.3, -0.2, 0.5)), Vector3::new(0.1, 0.7, -0.4));
        let turned = axes.rotation(&turn) * axes.vector(&arm);
        assert!((turned - axes.vector(&(turn * arm))).norm() < 1e-15);
    }

    #[test]
    fn a_reflected_turn_and_its_axis_map_alike() {
        let axes = Axes::of_hand("x=+y,y=+x,z=+z", true).unwrap();
        let (turn, arm) =
            (UnitQuaternion::new(Vector3::new(0.3, -0.2, 0.5)), Vector3::new(0.1, 0.7, -0.4));
        let turned = axes.rotation(&turn) * axes.vector(&arm);
        assert!((turned - axes.vector(&(turn * arm))).norm() < 1e-15);
        assert!(
            Axes::of_hand("x=+x,y=+y,z=+z", true).unwrap_err().to_string().contains("right-handed")
        );
    }

    #[test]
    fn axes_are_written_as_they_are_read() {
        for words in [Axes::Y_UP, "x=+z,y=+y,z=-x"] {
            assert_eq!(words.parse::<Axes>().unwrap().to_string(), words);
        }
    }

    #[test]
    fn what_is_not_a_right_handed_frame_is_refused() {
        for (words, found) in [
            ("x=+y,y=+x,z=+z", "left-handed"),
            ("x=+y,y=-y,z=+z", "twice"),
            ("x=+y,y=-x", "no axis"),
            ("x=+y,y=-x,z=+w", "`z=+w`"),
            ("x=+y,y=-x,z=+z,z=+z", "twice"),
            ("", "``"),
        ] {
            let said = Axes::from_str(words).unwrap_err().to_string();
            assert!(said.contains(found) && said.contains(Axes::Y_UP), "{words}: {said}");
        }
        assert!(Axes::from_str("z=-z, x=y, y=x").is_ok());
    }
}
