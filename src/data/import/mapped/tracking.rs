//! Tracked bodies of tables.

use super::columns::{ColumnName, LogTable};
use super::map::{BodyMap, EulerMap, QuaternionOrder, TrackingMap};
use super::time::{self, NS, Stamps};
use crate::data::DataError;
use crate::data::import::Body;
use crate::data::recording::{Pose, unit_length};

/// Tracked bodies at common times.
pub(crate) struct MappedBodies {
    /// First time, nanoseconds on the tracker's clock.
    pub(crate) first_ns: i64,
    /// Times since the first one, seconds, not decreasing.
    pub(crate) time_s: Vec<f64>,
    /// The base, at rest where it is not tracked.
    pub(crate) base: Body,
    /// The tip.
    pub(crate) tip: Body,
    /// Further points by name.
    pub(crate) points: Vec<(String, Body)>,
    /// Whether the times were dates, and then whether in a known zone.
    pub(crate) is_zoned: Option<bool>,
    /// Rows that repeat the time and the pose of the row before.
    pub(crate) repeated: usize,
}

/// The poses of one body with their times, nanoseconds.
struct Track {
    has_orientation: bool,
    is_zoned: Option<bool>,
    poses: Vec<(i64, Option<Pose>)>,
    repeated: usize,
}

/// Reads all bodies. `table_of` gives the table of a body of the map.
///
/// # Errors
/// [`DataError`] names file, line and column.
pub(crate) fn read(
    map: &TrackingMap,
    table_of: &dyn Fn(&BodyMap) -> Result<LogTable, DataError>,
) -> Result<MappedBodies, DataError> {
    let track = |body: &BodyMap, path: &str| track(&table_of(body)?, map, body, path);
    let tip = track(&map.tip, "tracking.tip")?;
    let base = map.base.as_ref().map(|body| track(body, "tracking.base")).transpose()?;
    let points = map
        .points
        .iter()
        .map(|(name, body)| Ok((name, track(body, &format!("tracking.points.{name}"))?)));
    let points = points.collect::<Result<Vec<_>, DataError>>()?;
    let all = || std::iter::once(&tip).chain(&base).chain(points.iter().map(|(_, track)| track));
    let mut times_ns: Vec<i64> =
        all().flat_map(|track| track.poses.iter().map(|(time, _)| *time)).collect();
    times_ns.sort_unstable();
    times_ns.dedup();
    let first_ns = times_ns.first().copied().unwrap_or(0);
    let body = |name: &str, track: &Track| {
        let mut poses = vec![None; times_ns.len()];
        for (time, pose) in &track.poses {
            if let Ok(place) = times_ns.binary_search(time) {
                poses[place] = *pose;
            }
        }
        Body { name: name.to_owned(), has_orientation: track.has_orientation, poses }
    };
    let at_rest = || {
        let metres = map.unit.metres();
        let pose = Pose {
            position_m: map.origin.unwrap_or_default().map(|x| x * metres),
            quaternion: [1.0, 0.0, 0.0, 0.0],
        };
        Body {
            name: "base".to_owned(),
            has_orientation: false,
            poses: vec![Some(pose); times_ns.len()],
        }
    };
    Ok(MappedBodies {
        first_ns,
        time_s: times_ns.iter().map(|time| (time - first_ns) as f64 / NS).collect(),
        base: base.as_ref().map_or_else(at_rest, |track| body("base", track)),
        tip: body("tip", &tip),
        points: points.iter().map(|(name, track)| ((*name).clone(), body(name, track))).collect(),
        is_zoned: tip.is_zoned,
        repeated: all().map(|track| track.repeated).sum(),
    })
}

/// Columns of a body.
struct PoseColumns {
    position: [usize; 3],
    orientation: Option<OrientationColumns>,
    valid: Option<usize>,
}

/// Columns of an orientation.
enum OrientationColumns {
    /// w, x, y, z.
    Quaternion([usize; 4]),
    /// Angles, and what they mean.
    Angles([usize; 3], EulerMap),
}

fn columns(
    table: &LogTable,
    map: &TrackingMap,
    body: &BodyMap,
    path: &str,
) -> Result<PoseColumns, DataError> {
    let (message_position, message_orientation) = table.own_pose();
    let find = |names: &[ColumnName], key: &str| table.find_all(names, &format!("{path}.{key}"));
    let position = body.position.clone().or(message_position).unwrap_or_else(|| {
        // Refused below as a column that is not there.
        ["x", "y", "z"].map(|name| ColumnName::Name(name.to_owned()))
    });
    let position = find(&position, "position")?;
    let unit = map.unit.of_commands();
    let told = format!("{} as `tracking.unit`", unit.word());
    table.check_units(&position, unit.spellings(), &told)?;
    let named_orientation = body.orientation.clone().map(|[a, b, c, d]| match map.quaternion {
        QuaternionOrder::Wxyz => [a, b, c, d],
        QuaternionOrder::Xyzw => [d, a, b, c],
    });
    // Without its own position a body is that of the message.
    let default_orientation = message_orientation.filter(|_| body.position.is_none());
    let orientation = match (&body.angles, map.euler) {
        (Some(names), Some(euler)) => {
            let indices = find(names, "angles")?;
            Some(OrientationColumns::Angles([indices[0], indices[1], indices[2]], euler))
        }
        _ => {
            let indices = named_orientation
                .or(default_orientation)
                .map(|names| find(&names, "orientation"))
                .transpose()?;
            indices.map(|indices| {
                OrientationColumns::Quaternion([indices[0], indices[1], indices[2], indices[3]])
            })
        }
    };
    let valid = map.valid.as_ref().map(|name| table.column(name, "tracking.valid")).transpose()?;
    Ok(PoseColumns { position: [position[0], position[1], position[2]], orientation, valid })
}

fn track(
    table: &LogTable,
    map: &TrackingMap,
    body: &BodyMap,
    path: &str,
) -> Result<Track, DataError> {
    let chosen = table.rows_where(&body.conditions, &format!("{path}.where"))?;
    let table: &LogTable = &chosen;
    let columns = columns(table, map, body, path)?;
    let has_time = map.time.is_some() || table.is_topic();
    let stamps = if has_time {
        time::stamps(table, map.time.as_ref(), "tracking.time")?
    } else {
        // Rows that hold both commands and poses are told by their numbers.
        Stamps::of_rows(table, 1)
    };
    let mut poses: Vec<(i64, Option<Pose>)> = Vec::new();
    let mut repeated = 0;
    // Row of the pose that was read last.
    let mut last_row = 0;
    for (row, &stamp_ns) in stamps.ns.iter().enumerate() {
        let pose = pose(table, map, &columns, row)?;
        match poses.last_mut() {
            Some((last_ns, _)) if *last_ns > stamp_ns => {
                let expected = "a time not earlier than in the previous row";
                return Err(stamps.wrong(table, row, None, expected));
            }
            Some((last_ns, last_pose)) if *last_ns == stamp_ns => match (&last_pose, &pose) {
                (Some(last), Some(pose)) if last != pose => {
                    return Err(two_at_once(table, &stamps, last_row, row, path));
                }
                (Some(_), _) => repeated += usize::from(pose.is_some()),
                (None, _) => *last_pose = pose,
            },
            _ => poses.push((stamp_ns, pose)),
        }
        if pose.is_some() {
            last_row = row;
        }
    }
    let Stamps { is_zoned, .. } = stamps;
    Ok(Track { has_orientation: columns.orientation.is_some(), is_zoned, poses, repeated })
}

/// The error for two poses of one body at one time.
fn two_at_once(
    table: &LogTable,
    stamps: &Stamps,
    before: usize,
    row: usize,
    path: &str,
) -> DataError {
    let found = format!(
        "another pose than in {} at the same time ({} s)",
        table.place(before),
        stamps.ns[row] as f64 / NS
    );
    let expected = format!(
        "one pose per time: `{path}.where` of the map selects the rows of one body (`{{COLUMN: \
         TEXT}}`); if times are rounded, `tracking.time.rate_hz` numbers the frames"
    );
    stamps.wrong(table, row, Some(found), expected)
}

/// The pose in a row; none where tracking was lost.
fn pose(
    table: &LogTable,
    map: &TrackingMap,
    columns: &PoseColumns,
    row: usize,
) -> Result<Option<Pose>, DataError> {
    if let Some(valid) = columns.valid
        && table.number(valid, row)?.is_none_or(|flag| flag == 0.0)
    {
        return Ok(None);
    }
    let Some(position) = table.numbers(&columns.position, row)? else { return Ok(None) };
    if map.lost_value.is_some_and(|lost| position.iter().all(|x| *x == lost)) {
        return Ok(None);
    }
    let quaternion = match &columns.orientation {
        None => Some([1.0, 0.0, 0.0, 0.0]),
        Some(columns) => orientation(table, columns, row)?,
    };
    let metres = map.unit.metres();
    Ok(quaternion.map(|quaternion| Pose { position_m: position.map(|x| x * metres), quaternion }))
}

/// The quaternion w, x, y, z in a row; none where tracking was lost.
fn orientation(
    table: &LogTable,
    columns: &OrientationColumns,
    row: usize,
) -> Result<Option<[f64; 4]>, DataError> {
    match columns {
        OrientationColumns::Angles(columns, euler) => {
            Ok(table.numbers(columns, row)?.map(|angles| euler.quaternion(angles)))
        }
        OrientationColumns::Quaternion(columns) => {
            let quaternion =
                table.numbers(columns, row)?.filter(|parts| parts.iter().any(|part| *part != 0.0));
            let Some(quaternion) = quaternion else { return Ok(None) };
            unit_length(&quaternion).map_err(|length| {
                let expected =
                    format!("a unit quaternion w, x, y, z (this row's has length {length:.4})");
                table.wrong(columns[0], row, expected)
            })?;
            Ok(Some(quaternion))
        }
    }
}
