//! Settings of the motion capture system.

use std::fmt;
use std::net::Ipv4Addr;

use natnet::Version;
use serde::{Deserialize, Serialize};

use super::pose::RigidPose;
use crate::base::BadOption;

/// Transport of the frames: Motive's "transmission type".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Transport {
    /// To this computer only, while it sends keep-alive messages.
    Unicast,
    /// To a group that any computer may join.
    Multicast,
}

/// Motive's up axis. Bodies are created with their axes along Motive's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub enum UpAxis {
    /// Y up, Motive's default: x of this program is Motive's y, z is Motive's z.
    Y,
    /// Z up: x of this program is Motive's z, z is Motive's x.
    Z,
}

/// Version of the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub enum StreamVersion {
    /// The version that the server announces.
    #[serde(rename = "auto")]
    Auto,
    /// NatNet 3.0 (Motive 2.0 and 2.1).
    #[serde(rename = "3.0")]
    V3_0,
    /// NatNet 3.1 (Motive 2.2 and 2.3).
    #[serde(rename = "3.1")]
    V3_1,
    /// NatNet 4.0 (Motive 3.0).
    #[serde(rename = "4.0")]
    V4_0,
    /// NatNet 4.1 (Motive 3.1).
    #[serde(rename = "4.1")]
    V4_1,
}

impl StreamVersion {
    /// The version, unless the server chooses it.
    pub fn fixed(self) -> Option<Version> {
        match self {
            StreamVersion::Auto => None,
            StreamVersion::V3_0 => Some(Version::new(3, 0, 0, 0)),
            StreamVersion::V3_1 => Some(Version::new(3, 1, 0, 0)),
            StreamVersion::V4_0 => Some(Version::new(4, 0, 0, 0)),
            StreamVersion::V4_1 => Some(Version::V4_1),
        }
    }
}

/// A rigid body of Motive, by name or by streaming id.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged)]
pub enum BodyName {
    /// Streaming id, as in Motive's properties of the body.
    Id(i32),
    /// Name, as in Motive's list of assets; case-sensitive.
    Name(String),
}

impl fmt::Display for BodyName {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BodyName::Id(id) => write!(out, "streaming id {id}"),
            BodyName::Name(name) => write!(out, "'{name}'"),
        }
    }
}

/// Settings of the motion capture system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackingSettings {
    /// IPv4 address of the computer that runs Motive (its "local interface").
    pub server: Ipv4Addr,
    /// UDP port of the server for commands.
    pub command_port: u16,
    /// UDP port of the frames: of the group in multicast, of the server in unicast.
    pub data_port: u16,
    /// `unicast` or `multicast`, as in Motive.
    pub transport: Transport,
    /// Multicast group of the server.
    pub multicast_group: Ipv4Addr,
    /// IPv4 address of this computer on the cameras' network; 0.0.0.0 lets the system choose.
    pub interface: Ipv4Addr,
    /// Rigid body fixed to the robot's base; null if there is none and the base does not move
    /// relative to the cameras: the base body's frame is then Motive's own.
    pub base_body: Option<BodyName>,
    /// Rigid body fixed to the robot's tip.
    pub tip_body: BodyName,
    /// Frame rate set in Motive, Hz; determines which gaps between samples are interpolated.
    pub rate_hz: f64,
    /// `auto`, or the version of the stream: `3.0`, `3.1`, `4.0`, `4.1`. It is requested from
    /// unicast servers.
    pub version: StreamVersion,
    /// Longest time for an answer of the server while connecting, s.
    pub connect_s: f64,
    /// `Y` or `Z`, as in Motive's streaming settings.
    pub up_axis: UpAxis,
    /// Pose of the robot's base frame in the base body's frame, in the axes given by `up_axis`: x
    /// up, z along the straight robot.
    pub alignment: RigidPose,
    /// Pose of the robot's tip in the tip body's frame, in the same axes.
    pub tip_offset: RigidPose,
}

impl Default for TrackingSettings {
    fn default() -> Self {
        TrackingSettings {
            server: Ipv4Addr::LOCALHOST,
            command_port: 1510,
            data_port: 1511,
            transport: Transport::Unicast,
            multicast_group: Ipv4Addr::new(239, 255, 42, 99),
            interface: Ipv4Addr::UNSPECIFIED,
            base_body: Some(BodyName::Name("base".into())),
            tip_body: BodyName::Name("tip".into()),
            rate_hz: 100.0,
            version: StreamVersion::Auto,
            connect_s: 2.0,
            up_axis: UpAxis::Y,
            alignment: RigidPose::default(),
            tip_offset: RigidPose::default(),
        }
    }
}

impl TrackingSettings {
    /// True if both bodies are given by their streaming ids.
    pub fn names_no_body(&self) -> bool {
        let is_name = |body: &BodyName| matches!(body, BodyName::Name(_));
        !is_name(&self.tip_body) && !self.base_body.as_ref().is_some_and(is_name)
    }

    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_counted("command_port", self.command_port.into())?;
        BadOption::unless_counted("data_port", self.data_port.into())?;
        BadOption::unless_positive("rate_hz", self.rate_hz)?;
        BadOption::unless_positive("connect_s", self.connect_s)?;
        let (group, expected) =
            (self.multicast_group, "an address of 224.0.0.0 to 239.255.255.255");
        BadOption::unless(group.is_multicast(), "multicast_group", group, expected)?;
        let distinct = self.base_body.as_ref() != Some(&self.tip_body);
        BadOption::unless(distinct, "tip_body", &self.tip_body, "another body than base_body")?;
        self.alignment.check("alignment")?;
        self.tip_offset.check("tip_offset")
    }
}
