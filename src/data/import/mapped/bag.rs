//! Topics of a bag as tables: a message is a row, a field a column.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::columns::{LogCells, LogTable, TopicColumns};
use super::join::{JoinedLog, join, without_tracking};
use super::map::{BodyMap, ImportMap, TrackingMap};
use super::ros_message::{
    MessageDefinition, MessageLeaf, MessageLeaves, Value, all_names, items_named,
};
use super::{MappedImport, commands, tracking};
use crate::data::DataError;
use crate::data::error::listed;
use crate::data::mcap::{Bag, BagMessage, MessageKind};

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
    let table_of = |body: &BodyMap| table(&bag, topic_of(body, tracking), Some(body));
    let bodies = tracking::read(tracking, &table_of)?;
    let log = JoinedLog { file: file.to_owned(), commands, tracking_file: file.to_owned(), bodies };
    join(vec![log], tracking, false, None)
}

fn topic_of<'a>(body: &'a BodyMap, map: &'a TrackingMap) -> &'a str {
    body.topic.as_deref().or(map.topic.as_deref()).unwrap_or_default()
}

const STAMP: &str = "header.stamp";
const LOG_TIME: &str = "log_time";
const CHILD: &str = "child_frame_id";
/// What positions are called in messages, and orientations beside them.
const POSES: [[&str; 2]; 4] =
    [["position", "orientation"], ["translation", "rotation"], ["point", ""], ["vector", ""]];

fn refuse(bag: &Bag, topic: &str, found: String, expected: String) -> DataError {
    DataError::Line { file: bag.file.clone(), place: format!("topic `{topic}`"), found, expected }
}

/// Names without repetition, in alphabetical order.
fn sorted<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: BTreeSet<&str> = names.into_iter().filter(|name| !name.is_empty()).collect();
    let shown = names.iter().map(|name| format!("`{name}`"));
    if names.is_empty() { "none".to_owned() } else { listed(shown) }
}

/// A message, or an item of one.
struct Row<'a> {
    /// Number of the message, from 1.
    number: usize,
    message: &'a BagMessage,
    /// Of the item, and then of the whole message.
    leaves: MessageLeaves,
    /// How many of the leaves are those of the item.
    own: usize,
}

/// The table of a topic: of the messages, or of the items in them that are the child of `body`.
///
/// # Errors
/// [`DataError::Line`] for a topic that is not there, messages without a definition or child, and a
/// message that cannot be read.
fn table(bag: &Bag, topic: &str, body: Option<&BodyMap>) -> Result<LogTable, DataError> {
    let Some(bag_topic) = bag.topics.get(topic) else {
        let all = format!("one of {}", sorted(bag.topics.keys().map(String::as_str)));
        return Err(refuse(bag, topic, "no such topic".to_owned(), all));
    };
    let kind = kind_of(bag, topic, &bag_topic.kinds)?;
    let definition = MessageDefinition::of(kind).map_err(|found| {
        let expected = "messages in `cdr` with their definition in `ros2msg`, as `ros2 bag record` \
                        writes them";
        refuse(bag, topic, found, expected.to_owned())
    })?;
    let mut values = Vec::new();
    for (index, message) in bag_topic.messages.iter().enumerate() {
        values.push(definition.decode(&message.data).ok_or_else(|| {
            let found = format!("{} bytes in message {}", message.data.len(), index + 1);
            refuse(bag, topic, found, kind.name.clone())
        })?);
    }
    let child = body.and_then(|body| body.child.as_deref());
    let rows = rows(&bag_topic.messages, &values, child);
    let Some(first) = rows.first() else {
        let names = sorted(values.iter().flat_map(all_names));
        return Err(match child {
            Some(child) if !values.is_empty() => {
                refuse(bag, topic, format!("no child `{child}`"), format!("one of {names}"))
            }
            _ => refuse(bag, topic, "no messages".to_owned(), "at least one".to_owned()),
        });
    };
    let mut topic_columns = TopicColumns { time: time_of(&first.leaves), ..Default::default() };
    if let Some(body) = body.filter(|body| body.position.is_none()) {
        check_one_child(bag, topic, &rows, body)?;
        [topic_columns.position, topic_columns.orientation] = pose_of(bag, topic, first)?;
    }
    Ok(columns(bag, topic, topic_columns, &rows))
}

/// The only type of a topic's messages; one of several recorders may have written its definition.
fn kind_of<'a>(
    bag: &Bag,
    topic: &str,
    kinds: &'a [MessageKind],
) -> Result<&'a MessageKind, DataError> {
    let same =
        |kind: &MessageKind| (&kind.name, &kind.encoding) == (&kinds[0].name, &kinds[0].encoding);
    if kinds.is_empty() || !kinds.iter().all(same) {
        let names = sorted(kinds.iter().map(|kind| kind.name.as_str()));
        let expected = "one type".to_owned();
        return Err(refuse(bag, topic, format!("messages of the types {names}"), expected));
    }
    Ok(kinds.iter().find(|kind| !kind.definition.is_empty()).unwrap_or(&kinds[0]))
}

/// The messages, or the items in them that are called `child`.
fn rows<'a>(messages: &'a [BagMessage], values: &[Value], child: Option<&str>) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    for (index, (message, value)) in messages.iter().zip(values).enumerate() {
        let items = child.map_or_else(|| vec![value], |child| items_named(value, child));
        for item in items {
            let mut leaves = MessageLeaves::of(item);
            let own = leaves.0.len();
            if !std::ptr::eq(item, value) {
                leaves.0.extend(MessageLeaves::of(value).0);
            }
            rows.push(Row { number: index + 1, message, leaves, own });
        }
    }
    rows
}

/// The time of a message that has several.
fn time_of(leaves: &MessageLeaves) -> String {
    let is_time = |path: &&str| {
        leaves.0.iter().any(|(known, leaf)| known == path && matches!(leaf, MessageLeaf::Time(_)))
    };
    [STAMP, "stamp"].into_iter().find(is_time).unwrap_or(LOG_TIME).to_owned()
}

/// Refuses frames of several bodies that follow one another.
fn check_one_child(bag: &Bag, topic: &str, rows: &[Row], body: &BodyMap) -> Result<(), DataError> {
    let child = |row: &Row| row.leaves.0.iter().find(|(path, _)| path == CHILD).cloned();
    let first = child(&rows[0]);
    let other = rows.iter().map(child).find(|other| *other != first).flatten();
    match (first, other) {
        (Some((_, MessageLeaf::Text(first))), Some((_, MessageLeaf::Text(other))))
            if body.conditions.is_empty() =>
        {
            let found = format!("the child frames `{first}` and `{other}`");
            let expected = "one of them as `child` of the body in the map".to_owned();
            Err(refuse(bag, topic, found, expected))
        }
        _ => Ok(()),
    }
}

/// Prefixes of the position and the orientation of a message or an item of one that has one pose.
fn pose_of(bag: &Bag, topic: &str, row: &Row) -> Result<[Option<String>; 2], DataError> {
    let paths: BTreeSet<&str> =
        row.leaves.0[..row.own].iter().map(|(path, _)| path.as_str()).collect();
    let part = |stem: &str, axis: &str| {
        if stem.is_empty() { axis.to_owned() } else { format!("{stem}.{axis}") }
    };
    let has = |stem: &str, axes: &[&str]| {
        axes.iter().all(|axis| paths.contains(part(stem, axis).as_str()))
    };
    let stems = paths.iter().filter_map(|path| match path.strip_suffix('x')? {
        "" => Some(""),
        stem => stem.strip_suffix('.'),
    });
    let name_of = |stem: &str| stem.rsplit('.').next().unwrap_or_default().to_owned();
    let is_position = |stem: &&str| {
        let name = name_of(stem);
        has(stem, &["x", "y", "z"])
            && (stem.is_empty() || POSES.iter().any(|[position, _]| *position == name))
    };
    let positions: Vec<&str> = stems.filter(is_position).collect();
    let outside_lists: Vec<&str> =
        positions.iter().copied().filter(|stem| !stem.contains('[')).collect();
    let [position] = outside_lists[..] else {
        let found = format!("the positions {}", sorted(positions.iter().copied()));
        let expected = "one; `position` of the body in the map names three numbers, `child` the \
                        item of a list";
        return Err(refuse(bag, topic, found, expected.to_owned()));
    };
    let name = name_of(position);
    let turn = POSES.iter().find(|[known, _]| *known == name).map_or("", |[_, turn]| turn);
    let orientation = format!("{}{turn}", position.strip_suffix(&name).unwrap_or_default());
    let has_turn = !turn.is_empty() && has(&orientation, &["x", "y", "z", "w"]);
    Ok([Some(position.to_owned()), has_turn.then_some(orientation)])
}

/// The leaves of one path in all rows.
fn cells(leaves: &[Option<&MessageLeaf>]) -> Option<LogCells> {
    match leaves.iter().flatten().next()? {
        MessageLeaf::Number(_) => {
            let number = |leaf: &Option<&MessageLeaf>| match leaf {
                Some(MessageLeaf::Number(number)) => *number,
                _ => f64::NAN,
            };
            Some(LogCells::Numbers(leaves.iter().map(number).collect()))
        }
        MessageLeaf::Text(_) => {
            let text = |leaf: &Option<&MessageLeaf>| match leaf {
                Some(MessageLeaf::Text(text)) => text.clone(),
                _ => String::new(),
            };
            Some(LogCells::Text(leaves.iter().map(text).collect()))
        }
        MessageLeaf::Time(_) => {
            let time = |leaf: &Option<&MessageLeaf>| match leaf {
                Some(MessageLeaf::Time(time_ns)) => Some(*time_ns),
                _ => None,
            };
            leaves.iter().map(time).collect::<Option<_>>().map(LogCells::Nanoseconds)
        }
    }
}

/// The rows as columns; a number that a message lacks is not a number.
fn columns(bag: &Bag, topic: &str, topic_columns: TopicColumns, rows: &[Row]) -> LogTable {
    let times = |time: fn(&BagMessage) -> u64| {
        LogCells::Nanoseconds(rows.iter().map(|row| time(row.message) as i64).collect())
    };
    let mut columns = vec![
        (LOG_TIME.to_owned(), times(|message| message.log_ns)),
        ("publish_time".to_owned(), times(|message| message.publish_ns)),
    ];
    let mut paths: Vec<&str> = Vec::new();
    let mut by_path: BTreeMap<&str, Vec<Option<&MessageLeaf>>> = BTreeMap::new();
    for (place, row) in rows.iter().enumerate() {
        for (path, leaf) in &row.leaves.0 {
            let leaves = by_path.entry(path).or_insert_with(|| {
                paths.push(path);
                vec![None; rows.len()]
            });
            // An item's own leaves stand before those of its message.
            leaves[place].get_or_insert(leaf);
        }
    }
    let filled = paths.iter().filter_map(|&path| Some((path.to_owned(), cells(&by_path[path])?)));
    columns.extend(filled);
    LogTable {
        file: bag.file.clone(),
        preamble: Vec::new(),
        units: None,
        header: format!("topic `{topic}`"),
        named: true,
        columns,
        rows: rows.iter().map(|row| row.number).collect(),
        row_word: format!("topic `{topic}`, message"),
        topic: Some(topic_columns),
        first_of_all: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::import::mapped::time;
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

    /// A bag without definitions.
    fn bag(topic: &str, kind: &str, messages: Vec<Writer>) -> Bag {
        defined_bag(topic, kind, "", messages)
    }

    fn defined_bag(topic: &str, kind: &str, definition: &str, messages: Vec<Writer>) -> Bag {
        let message = |(k, Writer(data)): (usize, Writer)| {
            let log_ns = 1_000 * k as u64;
            BagMessage { log_ns, publish_ns: log_ns + 1, data }
        };
        let messages = messages.into_iter().enumerate().map(message).collect();
        let kind = MessageKind {
            name: kind.to_owned(),
            encoding: "cdr".to_owned(),
            definition: definition.to_owned(),
            definition_encoding: "ros2msg".to_owned(),
        };
        let topic_of = BagTopic { kinds: vec![kind], messages };
        Bag { file: "a.mcap".into(), topics: BTreeMap::from([(topic.to_owned(), topic_of)]) }
    }

    fn child(name: &str) -> BodyMap {
        BodyMap { child: Some(name.to_owned()), ..BodyMap::default() }
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
        let stamps = time::stamps(&table, None, "time").unwrap().ns;
        assert_eq!(stamps[0], 5_000_000_250);
    }

    #[test]
    fn transforms_are_rows_of_their_child_frames() {
        let transform = |writer: Writer, child: &str, x: f64| {
            writer.header(1, 0).text(child).numbers(&[x, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8])
        };
        let both = transform(transform(Writer::new().u32(2), "base", 0.0), "tip", 0.1);
        let bag = bag("/tf", "tf2_msgs/msg/TFMessage", vec![both]);
        let tip = table(&bag, "/tf", Some(&child("tip"))).unwrap();
        assert_eq!((tip.rows.len(), number(&tip, "transform.translation.x", 0)), (1, Some(0.1)));
        assert_eq!(number(&tip, "transform.rotation.w", 0), Some(0.8));
        assert_eq!(tip.own_pose().0.unwrap()[0].to_string(), "`transform.translation.x`");
        let said = |body: &BodyMap| table(&bag, "/tf", Some(body)).unwrap_err().to_string();
        let hand = said(&child("hand"));
        assert!(hand.contains("no child `hand`, expected one of `base`, `tip`"), "{hand}");
        let any = said(&BodyMap::default());
        assert!(any.contains("the positions `transforms[0].transform.translation`"), "{any}");
        // Without a child the whole message has paths to each of its items.
        let whole = table(&bag, "/tf", None).unwrap();
        assert_eq!(number(&whole, "transforms[tip].transform.translation.x", 0), Some(0.1));
        assert_eq!(number(&whole, "transforms[0].transform.translation.x", 0), Some(0.0));
    }

    #[test]
    fn frames_that_follow_one_another_are_refused() {
        let frame = |name: &str| {
            Writer::new().header(1, 0).text(name).numbers(&[0.1, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8])
        };
        let kind = "geometry_msgs/msg/TransformStamped";
        let bag = bag("/mocap", kind, vec![frame("base"), frame("tip")]);
        let said = table(&bag, "/mocap", Some(&BodyMap::default())).unwrap_err().to_string();
        assert!(said.contains("the child frames `base` and `tip`"), "{said}");
        assert_eq!(table(&bag, "/mocap", Some(&child("tip"))).unwrap().rows, [2]);
    }

    #[test]
    fn messages_of_a_laboratory_are_read_by_their_definition() {
        let definition = "# Poses.\nuint8 KIND=3\nstd_msgs/Header header\nbool ok\n\
                          Body[] bodies # all of them\nint16[2] counts\nfloat32[<=4] volts\n\
                          string<=8[] motors\nfloat32[] currents\n\
                          ====================\nMSG: lab_msgs/Body\nstring label\nuint32 id\n\
                          geometry_msgs/Point position\n====================\n\
                          MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
                          ====================\nMSG: builtin_interfaces/Time\nint32 sec\n\
                          uint32 nanosec\n====================\n\
                          MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";
        let body = |writer: Writer, name: &str, id: u32, x: f64| {
            writer.text(name).u32(id).numbers(&[x, 0.0, 0.2])
        };
        let start = Writer::new().header(7, 5).aligned(&[1]).u32(2);
        let bodies = body(body(start, "base", 1, 0.5), "tip", 2, 0.75);
        let counts = bodies.aligned(&(-3_i16).to_le_bytes()).aligned(&9_i16.to_le_bytes());
        let volts = counts.u32(1).aligned(&1.5_f32.to_le_bytes());
        let motors = volts.u32(2).text("m1").text("m2");
        let message =
            motors.u32(2).aligned(&0.25_f32.to_le_bytes()).aligned(&0.5_f32.to_le_bytes());
        let bag = defined_bag("/lab", "lab_msgs/msg/Bodies", definition, vec![message]);
        let whole = table(&bag, "/lab", None).unwrap();
        for (path, value) in [
            ("ok", 1.0),
            ("bodies[tip].position.x", 0.75),
            ("bodies[0].position.x", 0.5),
            ("bodies[base].id", 1.0),
            ("counts[0]", -3.0),
            ("volts[0]", 1.5),
            ("currents[m2]", 0.5),
            ("currents[0]", 0.25),
        ] {
            assert_eq!(number(&whole, path, 0), Some(value), "{path}");
        }
        let tip = table(&bag, "/lab", Some(&child("tip"))).unwrap();
        assert_eq!(
            (tip.own_time(), number(&tip, "position.x", 0)),
            ("header.stamp".into(), Some(0.75))
        );
        assert_eq!(
            tip.own_pose(),
            (
                Some(["x", "y", "z"].map(|axis| {
                    super::super::columns::ColumnName::Name(format!("position.{axis}"))
                })),
                None
            )
        );
        let unknown = defined_bag("/lab", "lab_msgs/msg/Bodies", "", vec![Writer::new()]);
        let said = table(&unknown, "/lab", None).unwrap_err().to_string();
        assert!(said.contains("without their definition in the bag"), "{said}");
    }

    #[test]
    fn a_stamp_that_nobody_has_set_names_the_time_of_recording() {
        let point = Writer::new().header(0, 0).numbers(&[0.1, 0.2, 0.3]);
        let bag = bag("/p", "geometry_msgs/msg/PointStamped", vec![point]);
        let table = table(&bag, "/p", Some(&BodyMap::default())).unwrap();
        let said = time::stamps(&table, None, "tracking.time").map(|_| ()).unwrap_err().to_string();
        assert!(said.contains("column `header.stamp`: found `0`, expected a time other than 0"));
        assert!(said.contains("`time: {column: log_time}`"), "{said}");
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
        assert!(said.contains("messages of type `sensor_msgs/Image` without"), "{said}");
        // A count that the message has no room for.
        let huge = bag(
            "/c",
            "std_msgs/Float64MultiArray",
            vec![Writer::new().u32(0).u32(0).u32(u32::MAX)],
        );
        assert!(table(&huge, "/c", None).is_err());
    }
}
