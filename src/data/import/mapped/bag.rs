//! Topics of a bag as tables: a message is a row, a field a column.

use std::collections::BTreeMap;
use std::path::Path;

use super::cdr::CdrReader;
use super::columns::{LogCells, LogTable, TopicColumns};
use super::join::{JoinedLog, join, without_tracking};
use super::map::{BodyMap, ImportMap, TrackingMap};
use super::{MappedImport, commands, tracking};
use crate::data::DataError;
use crate::data::mcap::{Bag, BagMessage};

/// Imports topics of a bag by a checked map.
///
/// # Errors
/// [`DataError`] names file, topic, message, column, what was found and what was expected.
pub fn import_bag(file: &Path, map: &ImportMap) -> Result<MappedImport, DataError> {
    let bag = Bag::read(file)?;
    let topic = map.commands.topic.as_deref().unwrap_or_default();
    let commands = commands::read(&table(&bag, topic, None)?, &map.commands)?;
    let Some(tracking) = &map.tracking else {
        return without_tracking(vec![(file.to_owned(), commands)], None);
    };
    let table_of = |body: &BodyMap| table(&bag, topic_of(body, tracking), body.child.as_deref());
    let bodies = tracking::read(tracking, &table_of)?;
    let log = JoinedLog { file: file.to_owned(), commands, tracking_file: file.to_owned(), bodies };
    join(vec![log], tracking, false, None)
}

fn topic_of<'a>(body: &'a BodyMap, map: &'a TrackingMap) -> &'a str {
    body.topic.as_deref().or(map.topic.as_deref()).unwrap_or_default()
}

/// A kind of message that can be read.
struct MessageKind {
    name: &'static str,
    columns: TopicColumns,
    read: fn(&mut CdrReader, &mut Row) -> Option<()>,
}

/// What one message holds.
#[derive(Default)]
struct Row {
    stamp_ns: Option<i64>,
    child: Option<String>,
    numbers: Vec<(String, f64)>,
}

impl Row {
    fn parts(&mut self, prefix: &str, parts: [&str; 4], numbers: &[f64]) {
        self.numbers.extend(
            parts.iter().zip(numbers).map(|(part, number)| (format!("{prefix}.{part}"), *number)),
        );
    }

    /// A position, and an orientation beside it.
    fn pose(&mut self, cdr: &mut CdrReader, [position, turn]: [&str; 2]) -> Option<()> {
        self.parts(position, ["x", "y", "z", ""], &cdr.numbers::<3>()?);
        self.parts(turn, ["x", "y", "z", "w"], &cdr.numbers::<4>()?);
        Some(())
    }
}

const STAMP: &str = "header.stamp";
const LOG_TIME: &str = "log_time";
const CHILD: &str = "child_frame_id";

const fn kind(
    name: &'static str,
    time: &'static str,
    [position, orientation]: [Option<&'static str>; 2],
    read: fn(&mut CdrReader, &mut Row) -> Option<()>,
) -> MessageKind {
    MessageKind { name, columns: TopicColumns { time, position, orientation }, read }
}

const POSE: [&str; 2] = ["pose.position", "pose.orientation"];
const TRANSFORM: [&str; 2] = ["transform.translation", "transform.rotation"];
const ODOMETRY: [&str; 2] = ["pose.pose.position", "pose.pose.orientation"];

const fn both([position, turn]: [&'static str; 2]) -> [Option<&'static str>; 2] {
    [Some(position), Some(turn)]
}

static KINDS: [MessageKind; 7] = [
    kind("geometry_msgs/PoseStamped", STAMP, both(POSE), |cdr, row| {
        row.stamp_ns = Some(cdr.header()?);
        row.pose(cdr, POSE)
    }),
    kind("geometry_msgs/PointStamped", STAMP, [Some("point"), None], |cdr, row| {
        row.stamp_ns = Some(cdr.header()?);
        row.parts("point", ["x", "y", "z", ""], &cdr.numbers::<3>()?);
        Some(())
    }),
    kind("geometry_msgs/TransformStamped", STAMP, both(TRANSFORM), transform),
    // Read transform by transform.
    kind("tf2_msgs/TFMessage", STAMP, both(TRANSFORM), transform),
    kind("nav_msgs/Odometry", STAMP, both(ODOMETRY), |cdr, row| {
        row.stamp_ns = Some(cdr.header()?);
        row.child = Some(cdr.text()?);
        row.pose(cdr, ODOMETRY)
    }),
    kind("sensor_msgs/JointState", STAMP, [None, None], |cdr, row| {
        row.stamp_ns = Some(cdr.header()?);
        let names = cdr.list(CdrReader::text)?;
        for field in ["position", "velocity", "effort"] {
            let numbers = cdr.list(CdrReader::f64)?;
            row.numbers.extend(
                names
                    .iter()
                    .zip(numbers)
                    .map(|(name, number)| (format!("{field}[{name}]"), number)),
            );
        }
        Some(())
    }),
    kind("std_msgs/Float64MultiArray", LOG_TIME, [None, None], |cdr, row| {
        cdr.list(|cdr| Some((cdr.text()?, cdr.u32()?, cdr.u32()?)))?;
        cdr.u32()?;
        let numbers = cdr.list(CdrReader::f64)?;
        row.numbers.extend(
            numbers.into_iter().enumerate().map(|(k, number)| (format!("data[{k}]"), number)),
        );
        Some(())
    }),
];

fn transform(cdr: &mut CdrReader, row: &mut Row) -> Option<()> {
    row.stamp_ns = Some(cdr.header()?);
    row.child = Some(cdr.text()?);
    row.pose(cdr, TRANSFORM)
}

/// The rows of a message: one, or one a transform.
fn rows(kind: &MessageKind, message: &BagMessage) -> Option<Vec<Row>> {
    let mut cdr = CdrReader::new(&message.data)?;
    let row = |cdr: &mut CdrReader| {
        let mut row = Row::default();
        (kind.read)(cdr, &mut row).map(|()| row)
    };
    if kind.name.starts_with("tf2") { cdr.list(row) } else { row(&mut cdr).map(|row| vec![row]) }
}

/// The names `a/msg/B` and `a/B` are one.
fn plain(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

fn refuse(bag: &Bag, topic: &str, found: String, expected: String) -> DataError {
    DataError::Line { file: bag.file.clone(), place: format!("topic `{topic}`"), found, expected }
}

/// The table of a topic; of one child frame where `child` is given.
///
/// # Errors
/// [`DataError::Line`] for a topic that is not there, another kind of message, and a message that
/// cannot be read.
fn table(bag: &Bag, topic: &str, child: Option<&str>) -> Result<LogTable, DataError> {
    let Some(bag_topic) = bag.topics.get(topic) else {
        let all: Vec<String> = bag.topics.keys().map(|name| format!("`{name}`")).collect();
        return Err(refuse(
            bag,
            topic,
            "no such topic".to_owned(),
            format!("one of {}", all.join(", ")),
        ));
    };
    let readable = |(name, encoding): &(String, String)| {
        KINDS.iter().find(|kind| kind.name == plain(name)).filter(|_| encoding == "cdr")
    };
    let kinds: Vec<&MessageKind> = bag_topic.kinds.iter().filter_map(readable).collect();
    let [kind] = kinds[..] else {
        let kinds: Vec<String> = bag_topic
            .kinds
            .iter()
            .map(|(name, encoding)| format!("`{name}` in `{encoding}`"))
            .collect();
        let all: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
        let expected = format!("one of {} in `cdr`", all.join(", "));
        return Err(refuse(
            bag,
            topic,
            format!("messages of type {}", kinds.join(" and ")),
            expected,
        ));
    };
    let mut parsed: Vec<(usize, &BagMessage, Row)> = Vec::new();
    for (number, message) in bag_topic.messages.iter().enumerate() {
        let damaged = || {
            let (found, expected) = (
                format!("{} bytes in message {}", message.data.len(), number + 1),
                kind.name.to_owned(),
            );
            refuse(bag, topic, found, expected)
        };
        let rows = rows(kind, message).ok_or_else(damaged)?;
        parsed.extend(rows.into_iter().map(|row| (number + 1, message, row)));
    }
    if let Some(child) = child {
        let children: std::collections::BTreeSet<String> =
            parsed.iter().filter_map(|(_, _, row)| row.child.clone()).collect();
        parsed.retain(|(_, _, row)| row.child.as_deref() == Some(child));
        if parsed.is_empty() {
            let all: Vec<String> = children.iter().map(|name| format!("`{name}`")).collect();
            return Err(refuse(
                bag,
                topic,
                format!("no child frame `{child}`"),
                format!("one of {}", all.join(", ")),
            ));
        }
    } else if let Some(other) = parsed.iter().find(|(_, _, row)| row.child != parsed[0].2.child) {
        let frames = [&parsed[0].2, &other.2].map(|row| row.child.clone().unwrap_or_default());
        let found = format!("the child frames `{}` and `{}`", frames[0], frames[1]);
        return Err(refuse(
            bag,
            topic,
            found,
            "one of them as `child` of the body in the map".to_owned(),
        ));
    }
    if parsed.is_empty() {
        return Err(refuse(bag, topic, "no messages".to_owned(), "at least one".to_owned()));
    }
    Ok(columns(bag, topic, kind, &parsed))
}

/// The rows as columns; a number that a message lacks is not a number.
fn columns(
    bag: &Bag,
    topic: &str,
    kind: &MessageKind,
    parsed: &[(usize, &BagMessage, Row)],
) -> LogTable {
    let times = |time: fn(&BagMessage) -> u64| {
        LogCells::Nanoseconds(parsed.iter().map(|(_, message, _)| time(message) as i64).collect())
    };
    let mut columns = vec![
        (LOG_TIME.to_owned(), times(|message| message.log_ns)),
        ("publish_time".to_owned(), times(|message| message.publish_ns)),
    ];
    if parsed.iter().all(|(_, _, row)| row.stamp_ns.is_some()) {
        let stamps = parsed.iter().filter_map(|(_, _, row)| row.stamp_ns).collect();
        columns.push((STAMP.to_owned(), LogCells::Nanoseconds(stamps)));
    }
    if parsed.iter().all(|(_, _, row)| row.child.is_some()) {
        let children = parsed.iter().filter_map(|(_, _, row)| row.child.clone()).collect();
        columns.push((CHILD.to_owned(), LogCells::Text(children)));
    }
    let mut names: Vec<&str> = Vec::new();
    let mut numbers: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (index, (_, _, row)) in parsed.iter().enumerate() {
        for (name, number) in &row.numbers {
            let cells = numbers.entry(name).or_insert_with(|| {
                names.push(name);
                vec![f64::NAN; parsed.len()]
            });
            cells[index] = *number;
        }
    }
    let filled = names
        .iter()
        .filter_map(|&name| Some((name.to_owned(), LogCells::Numbers(numbers.remove(name)?))));
    columns.extend(filled);
    LogTable {
        file: bag.file.clone(),
        header: format!("topic `{topic}`"),
        named: true,
        columns,
        rows: parsed.iter().map(|(number, ..)| *number).collect(),
        row_word: format!("topic `{topic}`, message"),
        topic: Some(kind.columns.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::mcap::BagTopic;

    /// A message in plain CDR, little-endian: what is aligned is aligned after the first four
    /// bytes.
    struct Writer(Vec<u8>);

    impl Writer {
        fn new() -> Writer {
            Writer(vec![0, 1, 0, 0])
        }

        fn aligned(mut self, bytes: &[u8]) -> Writer {
            while !(self.0.len() - 4).is_multiple_of(bytes.len()) {
                self.0.push(0);
            }
            self.0.extend(bytes);
            self
        }

        fn u32(self, number: u32) -> Writer {
            self.aligned(&number.to_le_bytes())
        }

        fn text(self, text: &str) -> Writer {
            let mut sized = self.u32(text.len() as u32 + 1);
            sized.0.extend(text.bytes());
            sized.0.push(0);
            sized
        }

        fn numbers(self, numbers: &[f64]) -> Writer {
            numbers.iter().fold(self, |writer, number| writer.aligned(&number.to_le_bytes()))
        }

        fn header(self, seconds: u32, nanoseconds: u32) -> Writer {
            self.u32(seconds).u32(nanoseconds).text("map")
        }
    }

    fn bag(topic: &str, kind: &str, messages: Vec<Writer>) -> Bag {
        let message = |(k, Writer(data)): (usize, Writer)| {
            let log_ns = 1_000 * k as u64;
            BagMessage { log_ns, publish_ns: log_ns + 1, data }
        };
        let messages = messages.into_iter().enumerate().map(message).collect();
        let topic_of = BagTopic { kinds: vec![(kind.to_owned(), "cdr".to_owned())], messages };
        Bag { file: "a.mcap".into(), topics: BTreeMap::from([(topic.to_owned(), topic_of)]) }
    }

    fn number(table: &LogTable, name: &str, row: usize) -> Option<f64> {
        let column = table.columns.iter().position(|(known, _)| known == name).unwrap();
        table.number(column, row).unwrap()
    }

    #[test]
    fn joints_are_told_by_their_names_whatever_their_order() {
        let joints = |names: [&str; 2], positions: &[f64]| {
            let named = names
                .iter()
                .fold(Writer::new().header(5, 250).u32(2), |writer, name| writer.text(name));
            named.u32(positions.len() as u32).numbers(positions).u32(0).u32(0)
        };
        let messages = vec![
            joints(["a", "bcd"], &[1.0, 2.0]),
            joints(["bcd", "a"], &[4.0, 3.0]),
            joints(["a", "x"], &[5.0]),
        ];
        let bag = bag("/j", "sensor_msgs/msg/JointState", messages);
        let table = table(&bag, "/j", None).unwrap();
        let read = |name| [0, 1, 2].map(|row| number(&table, name, row));
        assert_eq!(read("position[a]"), [Some(1.0), Some(3.0), Some(5.0)]);
        assert_eq!(read("position[bcd]"), [Some(2.0), Some(4.0), None]);
        assert_eq!(
            (table.own_time(), table.place(2)),
            ("header.stamp".to_owned(), "topic `/j`, message 3".to_owned())
        );
        let stamps = commands::stamps(&table, None, "time").unwrap().ns;
        assert_eq!(stamps[0], 5_000_000_250);
    }

    #[test]
    fn transforms_are_rows_of_their_child_frames() {
        let transform = |writer: Writer, child: &str, x: f64| {
            writer.header(1, 0).text(child).numbers(&[x, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8])
        };
        let both = transform(transform(Writer::new().u32(2), "base", 0.0), "tip", 0.1);
        let bag = bag("/tf", "tf2_msgs/msg/TFMessage", vec![both]);
        let tip = table(&bag, "/tf", Some("tip")).unwrap();
        assert_eq!((tip.rows.len(), number(&tip, "transform.translation.x", 0)), (1, Some(0.1)));
        assert_eq!(number(&tip, "transform.rotation.w", 0), Some(0.8));
        let said = |child| table(&bag, "/tf", child).unwrap_err().to_string();
        assert!(said(Some("hand")).contains("one of `base`, `tip`"), "{}", said(Some("hand")));
        assert!(said(None).contains("the child frames `base` and `tip`"), "{}", said(None));
    }

    #[test]
    fn what_cannot_be_read_is_told_with_topic_and_message() {
        let array = |numbers: &[f64]| {
            Writer::new()
                .u32(1)
                .text("row")
                .u32(2)
                .u32(2)
                .u32(0)
                .u32(numbers.len() as u32)
                .numbers(numbers)
        };
        let mut cut = array(&[1.0, 2.0]);
        cut.0.truncate(40);
        let whole = bag("/c", "std_msgs/Float64MultiArray", vec![array(&[1.0, 2.0])]);
        assert_eq!(number(&table(&whole, "/c", None).unwrap(), "data[1]", 0), Some(2.0));
        let damaged = bag("/c", "std_msgs/Float64MultiArray", vec![array(&[1.0]), cut]);
        let said = table(&damaged, "/c", None).unwrap_err().to_string();
        assert!(
            said.contains(
                "topic `/c`: found 40 bytes in message 2, expected std_msgs/Float64MultiArray"
            ),
            "{said}"
        );
        assert!(table(&whole, "/d", None).unwrap_err().to_string().contains("one of `/c`"));
        let image = bag("/c", "sensor_msgs/msg/Image", vec![Writer::new()]);
        let said = table(&image, "/c", None).unwrap_err().to_string();
        assert!(said.contains("messages of type `sensor_msgs/msg/Image` in `cdr`"), "{said}");
        // A count that the message has no room for.
        let huge = bag(
            "/c",
            "std_msgs/Float64MultiArray",
            vec![Writer::new().u32(0).u32(0).u32(u32::MAX)],
        );
        assert!(table(&huge, "/c", None).is_err());
    }
}
