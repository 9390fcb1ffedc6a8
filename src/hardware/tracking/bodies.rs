//! The robot's two bodies among those that the server tracks.

use natnet::{FrameOfData, ModelDef, RigidBody};

use super::fault::TrackingFault;
use super::pose::RigidPose;
use super::settings::{BodyName, TrackingSettings};

/// Largest deviation of the squared norm of a quaternion from 1: the server sends single precision.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Largest coordinate in a capture volume, metres.
const MAX_COORDINATE_M: f64 = 1000.0;

/// Most bodies listed in an error.
const MAX_LISTED: usize = 30;

/// Streaming ids of the bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TrackedBodies {
    /// None if the base does not move.
    base: Option<i32>,
    tip: i32,
}

impl TrackedBodies {
    /// Finds the bodies of `settings`; without a model they are known by their ids alone.
    pub(super) fn find(
        settings: &TrackingSettings,
        model: Option<&ModelDef>,
    ) -> Result<TrackedBodies, TrackingFault> {
        let id = |role, body: &BodyName| match (body, model) {
            (body, Some(model)) => id_of(role, body, model),
            (BodyName::Id(id), None) => Ok(*id),
            (BodyName::Name(_), None) => Err(TrackingFault::BodyMissing {
                role,
                body: body.clone(),
                there_are: "no described bodies".to_owned(),
            }),
        };
        let base = settings.base_body.as_ref().map(|body| id("base", body)).transpose()?;
        let tip = id("tip", &settings.tip_body)?;
        if base == Some(tip) {
            return Err(TrackingFault::BodyShared { id: tip });
        }
        Ok(TrackedBodies { base, tip })
    }

    /// Base and tip in a frame; none if one of them is not tracked.
    pub(super) fn poses(&self, frame: &FrameOfData) -> Option<(RigidPose, RigidPose)> {
        let base = match self.base {
            Some(id) => pose_of(id, frame)?,
            None => RigidPose::default(),
        };
        Some((base, pose_of(self.tip, frame)?))
    }

    /// Why [`TrackedBodies::poses`] returned none.
    pub(super) fn unseen(&self, frame: &FrameOfData) -> &'static str {
        let missing = |id| !frame.rigid_bodies.iter().any(|body| body.id == id);
        let is_tracked = |id| pose_of(id, frame).is_some();
        match self.base {
            _ if missing(self.tip) => "frames without the tip's body",
            Some(base) if missing(base) => "frames without the base's body",
            Some(base) if !is_tracked(base) && !is_tracked(self.tip) => {
                "base and tip are not tracked"
            }
            Some(base) if !is_tracked(base) => "the base is not tracked",
            _ => "the tip is not tracked",
        }
    }

    /// True if the frame lists both, tracked or not.
    pub(super) fn are_in(&self, frame: &FrameOfData) -> bool {
        let contains = |id| frame.rigid_bodies.iter().any(|body| body.id == id);
        contains(self.tip) && self.base.is_none_or(contains)
    }
}

fn id_of(role: &'static str, body: &BodyName, model: &ModelDef) -> Result<i32, TrackingFault> {
    let is_it = |(name, id): &(&str, i32)| match body {
        BodyName::Id(expected) => id == expected,
        BodyName::Name(expected) => name == expected,
    };
    let matching: Vec<(&str, i32)> = model.rigid_bodies().filter(is_it).collect();
    let [(_, id)] = matching[..] else {
        let (body, there_are) = (body.clone(), listed(model));
        return Err(match matching.len() {
            0 => TrackingFault::BodyMissing { role, body, there_are },
            count => TrackingFault::BodyDouble { role, body, count, there_are },
        });
    };
    // A second body with the same id makes the frames ambiguous, whatever its name.
    let count = model.rigid_bodies().filter(|(_, other)| *other == id).count();
    if count > 1 {
        return Err(TrackingFault::BodyDouble {
            role,
            body: BodyName::Id(id),
            count,
            there_are: listed(model),
        });
    }
    Ok(id)
}

fn listed(model: &ModelDef) -> String {
    let mut names: Vec<String> =
        model.rigid_bodies().map(|(name, id)| format!("'{name}' (id {id})")).collect();
    if names.is_empty() {
        return "none".into();
    }
    let more = names.len().saturating_sub(MAX_LISTED);
    names.truncate(MAX_LISTED);
    if more > 0 {
        names.push(format!("{more} more"));
    }
    names.join(", ")
}

/// The pose of the only body with this id, if it is tracked and its values are valid.
fn pose_of(id: i32, frame: &FrameOfData) -> Option<RigidPose> {
    let mut same = frame.rigid_bodies.iter().filter(|body| body.id == id);
    // Two bodies of one id: nobody knows which is the robot's.
    let (body, None) = (same.next()?, same.next()) else { return None };
    body.tracking_valid().then(|| pose(body))?
}

fn pose(body: &RigidBody) -> Option<RigidPose> {
    let position_m = body.position.map(f64::from);
    let [x, y, z, w] = body.orientation.map(f64::from);
    let length2 = w * w + x * x + y * y + z * z;
    let possible = position_m.iter().all(|value| value.abs() < MAX_COORDINATE_M)
        && (length2 - 1.0).abs() < UNIT_TOLERANCE;
    possible.then_some(RigidPose { position_m, quaternion: [w, x, y, z] })
}
