//! Commands of drives in place of those of tendons: `drive_NAME_rad` or `drive_NAME_m`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use super::{Actuation, Recording, column_error, optional};
use crate::base::Rows;
use crate::data::DataError;
use crate::data::table::Table;

/// Unit of a drive's displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveUnit {
    /// Radians (`drive_NAME_rad`).
    Radians,
    /// Metres (`drive_NAME_m`).
    Metres,
}

/// The commands of one drive.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveTrack {
    /// Its name in the columns of a recording and in `drives` of a model.
    pub name: String,
    /// Its unit.
    pub unit: DriveUnit,
    /// Its commanded displacement in each row, 0 at home.
    pub displacement: Vec<f64>,
}

impl DriveTrack {
    /// The same drive in these rows alone.
    #[must_use]
    pub fn of_rows(&self, rows: Range<usize>) -> DriveTrack {
        DriveTrack { displacement: self.displacement[rows].to_vec(), ..self.clone() }
    }

    /// Name of its column.
    pub fn column(&self) -> String {
        let unit = match self.unit {
            DriveUnit::Radians => "rad",
            DriveUnit::Metres => "m",
        };
        format!("drive_{}_{unit}", self.name)
    }
}

/// Name and unit of the drive that a column belongs to.
pub(super) fn drive_of(column: &str) -> Option<(&str, DriveUnit)> {
    let (name, unit) = column.strip_prefix("drive_")?.rsplit_once('_')?;
    let unit = match unit {
        "rad" => DriveUnit::Radians,
        "m" => DriveUnit::Metres,
        _ => return None,
    };
    (!name.is_empty()).then_some((name, unit))
}

/// The drives of a file, in the order of their names.
pub(super) fn read(table: &Table) -> Result<Vec<DriveTrack>, DataError> {
    let mut drives: Vec<DriveTrack> = Vec::new();
    for (column, cells) in &table.columns {
        let Some((name, unit)) = drive_of(column) else { continue };
        if drives.iter().any(|drive| drive.name == name) {
            let found = format!("the drive `{name}` in radians and in metres");
            return Err(table.header_error(column, found, "one of the two"));
        }
        let expected = match unit {
            DriveUnit::Radians => "radians, a number",
            DriveUnit::Metres => "metres, a number",
        };
        let number = |row| {
            optional::finite(cells, row).ok_or_else(|| table.cell_error(row, column, expected))
        };
        let displacement = (0..table.rows).map(number).collect::<Result<_, _>>()?;
        drives.push(DriveTrack { name: name.to_owned(), unit, displacement });
    }
    drives.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(drives)
}

impl Recording {
    /// Converts the commands of drives, if there are any, to displacements of `tendons` tendons:
    /// the sum of gain times displacement over the drives. `gains` holds for each drive of the
    /// model the tendons (from 0) that it moves and the gain of each; `path` is the file that the
    /// recording was read from. The drives stay in [`Recording::drives`] and are what is written.
    ///
    /// # Errors
    /// [`DataError::Column`] for a drive that the model lacks, and for one of the model that the
    /// recording lacks.
    pub fn convert_drives(
        &mut self,
        path: &Path,
        gains: &BTreeMap<String, Vec<(usize, f64)>>,
        tendons: usize,
    ) -> Result<(), DataError> {
        if self.drives.is_empty() {
            return Ok(());
        }
        let names: Vec<&str> = gains.keys().map(String::as_str).collect();
        if let Some(drive) = self.drives.iter().find(|drive| !gains.contains_key(&drive.name)) {
            let expected = match names.as_slice() {
                [] => {
                    "displacements of tendons (tendon_1_m…): the model has no `drives`".to_owned()
                }
                known => format!("a drive of the model: {}", known.join(", ")),
            };
            return Err(column_error(
                path,
                drive.column(),
                format!("the drive `{}`", drive.name),
                expected,
            ));
        }
        let missing_drive =
            names.iter().find(|name| self.drives.iter().all(|drive| drive.name != **name));
        if let Some(name) = missing_drive {
            let expected = format!("a column `drive_{name}_rad` or `drive_{name}_m`");
            let found = format!("no commands of the drive `{name}`");
            return Err(column_error(path, format!("drive_{name}_rad"), found, expected));
        }
        if let Some(commands) = self.tendon_commands(gains, tendons) {
            self.commands = commands;
            self.actuation = Actuation::Lengths;
        }
        Ok(())
    }

    /// The recording with the commands that its drives give with these gains, as
    /// [`Recording::convert_drives`] takes them; itself where it has no drives, or one without
    /// gains.
    pub fn driven_by(
        &self,
        gains: &BTreeMap<String, Vec<(usize, f64)>>,
        tendons: usize,
    ) -> Cow<'_, Recording> {
        let commands =
            if self.drives.is_empty() { None } else { self.tendon_commands(gains, tendons) };
        commands.map_or(Cow::Borrowed(self), |commands| {
            Cow::Owned(Recording { commands, ..self.clone() })
        })
    }

    /// Displacements of `tendons` tendons, row by row; `None` where a drive has no gains.
    fn tendon_commands(
        &self,
        gains: &BTreeMap<String, Vec<(usize, f64)>>,
        tendons: usize,
    ) -> Option<Rows> {
        let driven: Vec<(&DriveTrack, &Vec<(usize, f64)>)> = self
            .drives
            .iter()
            .map(|drive| Some((drive, gains.get(&drive.name)?)))
            .collect::<Option<_>>()?;
        let mut commands = Rows::new(tendons);
        for row in 0..self.len() {
            let mut command = vec![0.0; tendons];
            for (drive, gains) in &driven {
                gains
                    .iter()
                    .for_each(|&(tendon, gain)| command[tendon] += gain * drive.displacement[row]);
            }
            commands.push(&command);
        }
        Some(commands)
    }

    /// Displacements of the drives in one row, in the order of their names.
    pub fn drive_displacements(&self, row: usize) -> Vec<f64> {
        self.drives.iter().map(|drive| drive.displacement[row]).collect()
    }
}
