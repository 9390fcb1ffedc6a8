//! Tracked points along the body: `point_NAME_x_m,point_NAME_y_m,point_NAME_z_m` and, where it was
//! measured, their orientation `point_NAME_qw,point_NAME_qx,point_NAME_qy,point_NAME_qz`.

use std::collections::BTreeSet;
use std::path::Path;

use super::optional::ColumnGroup;

use super::{Recording, column_error};
use crate::base::Point3;
use crate::data::DataError;
use crate::data::table::Table;

const POSITION: [&str; 3] = ["x_m", "y_m", "z_m"];
const QUATERNION: [&str; 4] = ["qw", "qx", "qy", "qz"];

/// What was measured of one tracked point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTrack {
    /// Its name in the columns of a recording and in `tracking.points` of a model.
    pub name: String,
    /// Position in each row, metres; not a number where the point was not seen.
    pub position_m: Vec<Point3>,
    /// Orientation of the body there in each row, unit quaternion w, x, y, z.
    pub quaternion: Option<Vec<[f64; 4]>>,
}

impl PointTrack {
    pub(super) fn position_columns(&self) -> [String; 3] {
        POSITION.map(|part| column(&self.name, part))
    }

    pub(super) fn quaternion_columns(&self) -> [String; 4] {
        QUATERNION.map(|part| column(&self.name, part))
    }

    /// Whether the point was seen in this row.
    pub fn is_seen(&self, row: usize) -> bool {
        self.position_m[row].iter().all(|x| x.is_finite())
    }
}

fn column(name: &str, part: &str) -> String {
    format!("point_{name}_{part}")
}

/// The name of the point that a column belongs to.
pub(super) fn name_of(column: &str) -> Option<&str> {
    let (name, part) = column.strip_prefix("point_").and_then(split_part)?;
    (!name.is_empty() && (POSITION.contains(&part) || QUATERNION.contains(&part))).then_some(name)
}

/// The columns of a point: its position, and its orientation where the file `has` a part of it.
pub(super) fn columns(name: &str, has: impl Fn(&str) -> bool) -> Vec<String> {
    let [position, orientation] = [&POSITION[..], &QUATERNION[..]]
        .map(|parts| parts.iter().map(|part| column(name, part)).collect::<Vec<String>>());
    let is_turned = orientation.iter().any(|column| has(column));
    position.into_iter().chain(if is_turned { orientation } else { Vec::new() }).collect()
}

/// `NAME_x_m` as `NAME` and `x_m`, `NAME_qw` as `NAME` and `qw`.
fn split_part(text: &str) -> Option<(&str, &str)> {
    let ends = POSITION.iter().chain(&QUATERNION);
    ends.into_iter().find_map(|part| Some((text.strip_suffix(part)?.strip_suffix('_')?, *part)))
}

/// The points of a file, in the order of their names. A cell is empty where the point was not seen.
pub(super) fn read(table: &Table) -> Result<Vec<PointTrack>, DataError> {
    let names: BTreeSet<&str> =
        table.columns.iter().filter_map(|(name, _)| name_of(name)).collect();
    let unseen = vec![false; table.rows];
    let point = |name: &str| {
        let mut point =
            PointTrack { name: name.to_owned(), position_m: Vec::new(), quaternion: None };
        let (position, orientation) = (point.position_columns(), point.quaternion_columns());
        let group =
            |names: Vec<_>, required| ColumnGroup { table, names, required, lost: Some(&unseen) };
        let read = group(position.iter().map(String::as_str).collect(), true).read::<3>()?;
        point.position_m = read.unwrap_or_default();
        point.quaternion =
            group(orientation.iter().map(String::as_str).collect(), false).quaternions()?;
        Ok(point)
    };
    names.into_iter().map(point).collect()
}

/// `path` is the file that the recording was read from.
impl Recording {
    /// The tracked point of this name.
    pub fn point(&self, name: &str) -> Option<&PointTrack> {
        self.points.iter().find(|point| point.name == name)
    }

    /// Whether the tip or a further point was seen in this row.
    pub fn is_seen(&self, row: usize) -> bool {
        let tip_m = self.tip_m.as_ref().map(|tips_m| tips_m[row]);
        tip_m.is_some_and(|tip_m| tip_m.iter().all(|x| x.is_finite()))
            || self.points.iter().any(|point| point.is_seen(row))
    }

    /// Refuses a point that the robot's model does not place; `placed` are the names in its
    /// `tracking.points`.
    ///
    /// # Errors
    /// [`DataError::Column`] for the first one.
    pub fn check_points(&self, path: &Path, placed: &[String]) -> Result<(), DataError> {
        let Some(point) = self.points.iter().find(|point| !placed.contains(&point.name)) else {
            return Ok(());
        };
        let expected = match placed {
            [] => "no tracked point: the model has no `tracking.points`".to_owned(),
            names => format!("a point of the model's `tracking.points`: {}", names.join(", ")),
        };
        let [column, ..] = point.position_columns();
        Err(column_error(path, column, format!("the point `{}`", point.name), expected))
    }
}
