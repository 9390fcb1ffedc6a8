//! Drives that are not tendons: servos and screws that move one or several tendons.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::tracking::is_name;
use crate::base::BadOption;
use crate::effects::Model;

/// A drive and the tendons that it moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TendonDrive {
    /// The tendons, from 1.
    pub tendons: Vec<usize>,
    /// Displacement of each of these tendons per displacement of the drive: m/rad or m/m, as the
    /// recording's column says; positive where the drive pulls.
    pub gains: Vec<f64>,
}

/// Tendons (from 0) that a drive moves, and the displacement of each per displacement of the drive.
pub type DriveGains = Vec<(usize, f64)>;

/// The tendons of each drive by its name.
pub fn drive_gains(drives: &BTreeMap<String, TendonDrive>) -> BTreeMap<String, DriveGains> {
    let gains = |drive: &TendonDrive| {
        drive.tendons.iter().map(|tendon| tendon - 1).zip(drive.gains.clone()).collect()
    };
    drives.iter().map(|(name, drive)| (name.clone(), gains(drive))).collect()
}

impl Model {
    /// The tendons of each drive by its name.
    pub fn drive_gains(&self) -> BTreeMap<String, DriveGains> {
        drive_gains(&self.drives)
    }
}

/// Refuses drives without gains or of tendons that a robot of `count` tendons does not have.
///
/// # Errors
/// The path of the key (such as `drives.servo_1`) and the range that it left.
pub fn check_drives(
    drives: &BTreeMap<String, TendonDrive>,
    count: usize,
) -> Result<(), (String, BadOption)> {
    for (name, drive) in drives {
        let path = format!("drives.{name}");
        let refuse = |key, found, expected| Err((path.clone(), BadOption { key, found, expected }));
        if !is_name(name) {
            let expected = "names of letters, digits, `_` and `-`";
            return Err((
                String::new(),
                BadOption { key: "drives", found: format!("`{name}`"), expected },
            ));
        }
        let exists = |tendon: &usize| (1..=count).contains(tendon);
        let repeated = |(index, tendon): (usize, &usize)| drive.tendons[..index].contains(tendon);
        if drive.tendons.is_empty() || !drive.tendons.iter().all(exists) {
            return refuse(
                "tendons",
                format!("{:?}", drive.tendons),
                "numbers of tendons of this robot, from 1",
            );
        }
        if drive.tendons.iter().enumerate().any(repeated) {
            return refuse("tendons", format!("{:?}", drive.tendons), "each tendon once");
        }
        if drive.gains.len() != drive.tendons.len() {
            return refuse(
                "gains",
                format!("{:?}", drive.gains),
                "one number per tendon of the drive",
            );
        }
        drive
            .gains
            .iter()
            .try_for_each(|&gain| BadOption::unless_finite("gains", gain))
            .map_err(|error| (path.clone(), error))?;
    }
    Ok(())
}
