//! Messages of ROS 2 by their definitions: each number, text and time in one has a path, such as
//! `rigidbodies[tip].pose.position.x`.

use std::collections::BTreeMap;

use re_cdr::{BigEndian, CdrEndian, CdrReader, LittleEndian};
use re_ros_msg::MessageSchema;
pub(super) use re_ros_msg::deserialize::Value;
use re_ros_msg::deserialize::primitive_array::PrimitiveArray;
use re_ros_msg::deserialize::{MapResolver, decode_message};
use re_ros_msg::message_spec::MessageSpecification;

use crate::data::mcap::MessageKind;

/// Definitions of messages that bags of early recorders lack.
const COMMON: &str = include_str!("ros_messages.txt");
/// Items of a list of numbers that have paths, at most: images have none.
const MAX_ITEMS: usize = 1024;

/// The definition of a kind of message.
#[derive(Debug)]
pub(super) struct MessageDefinition {
    main: MessageSpecification,
    others: Vec<MessageSpecification>,
}

impl MessageDefinition {
    /// The definition that the bag holds, or the common one of this name.
    ///
    /// # Errors
    /// What was found in place of a definition.
    pub(super) fn of(kind: &MessageKind) -> Result<MessageDefinition, String> {
        let name = plain(&kind.name);
        if kind.encoding != "cdr" {
            return Err(format!("messages of type `{name}` in `{}`", kind.encoding));
        }
        let is_written =
            kind.definition_encoding == "ros2msg" && !kind.definition.trim().is_empty();
        let text = if is_written {
            kind.definition.clone()
        } else {
            common(&name).ok_or_else(|| {
                let encoding = &kind.definition_encoding;
                let how = if encoding.is_empty() { "no definition" } else { encoding };
                format!("messages of type `{name}` without their definition in the bag ({how})")
            })?
        };
        let schema = MessageSchema::parse(&name, &text)
            .map_err(|error| format!("the definition of `{name}` ({error:#})"))?;
        Ok(MessageDefinition { main: schema.spec, others: schema.dependencies })
    }

    /// The fields of a message in CDR; none when it is damaged.
    pub(super) fn decode(&self, message: &[u8]) -> Option<Value> {
        let (head, body) = message.split_at_checked(4)?;
        match head[..2] {
            [0, 0] => self.decode_body::<BigEndian>(body),
            [0, 1] => self.decode_body::<LittleEndian>(body),
            _ => None,
        }
    }

    fn decode_body<Order: CdrEndian>(&self, body: &[u8]) -> Option<Value> {
        /// Messages are padded to a multiple of this, at most.
        const PADDING_BYTES: usize = 8;
        let resolver = MapResolver::new(self.others.iter().map(|spec| (plain(&spec.name), spec)));
        let mut reader = CdrReader::<Order>::new(body);
        let value = decode_message(&mut reader, &self.main, &resolver).ok()?;
        (reader.remaining() < PADDING_BYTES).then_some(value)
    }
}

/// The names `a/msg/B` and `a/B` are one.
fn plain(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// The common definition of this name, with all that it may refer to.
fn common(name: &str) -> Option<String> {
    let sections: Vec<&str> =
        COMMON.split('=').map(str::trim).filter(|section| !section.is_empty()).collect();
    let head = format!("MSG: {name}\n");
    let main = sections.iter().find_map(|section| section.strip_prefix(&head))?;
    Some(format!(
        "{main}\n{}\n{}",
        "=".repeat(80),
        sections.join(&format!("\n{}\n", "=".repeat(80)))
    ))
}

/// What stands at a path.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MessageLeaf {
    Number(f64),
    Text(String),
    /// Nanoseconds.
    Time(i64),
}

/// The leaves of a message by their paths.
#[derive(Clone, Debug, Default)]
pub(super) struct MessageLeaves(pub(super) Vec<(String, MessageLeaf)>);

impl MessageLeaves {
    /// The leaves of a message.
    pub(super) fn of(message: &Value) -> MessageLeaves {
        let mut leaves = MessageLeaves::default();
        leaves.add(String::new(), message);
        leaves
    }

    fn push(&mut self, path: String, leaf: MessageLeaf) {
        self.0.push((path, leaf));
    }

    fn add(&mut self, path: String, value: &Value) {
        match value {
            Value::Message(fields) => self.add_fields(&path, fields),
            Value::Array(items) | Value::Sequence(items) => self.add_items(&path, items, &[]),
            Value::PrimitiveArray(list) | Value::PrimitiveSeq(list) => {
                self.add_list(&path, list, &[]);
            }
            Value::String(text) => self.push(path, MessageLeaf::Text(text.clone())),
            number => self.push(path, MessageLeaf::Number(self::number(number))),
        }
    }

    fn add_fields(&mut self, path: &str, fields: &BTreeMap<String, Value>) {
        if let Some(time_ns) = time_ns(fields) {
            self.push(path.to_owned(), MessageLeaf::Time(time_ns));
        }
        let names = item_names(fields);
        for (field, value) in fields {
            let path = if path.is_empty() { field.clone() } else { format!("{path}.{field}") };
            match value {
                Value::Array(items) | Value::Sequence(items) => {
                    self.add_items(&path, items, names);
                }
                Value::PrimitiveArray(list) | Value::PrimitiveSeq(list) => {
                    self.add_list(&path, list, names);
                }
                other => self.add(path, other),
            }
        }
    }

    /// Messages in a list, by their numbers and by their own texts or the names beside the list.
    fn add_items(&mut self, path: &str, items: &[Value], names: &[String]) {
        for (place, item) in items.iter().enumerate().take(MAX_ITEMS) {
            self.add(format!("{path}[{place}]"), item);
            let by_text = texts(item).into_iter().filter(|text| {
                let with_it = items.iter().filter(|other| texts(other).contains(text));
                with_it.count() == 1
            });
            let beside = names.get(place).map(String::as_str);
            for name in by_text.chain(beside).filter(|name| !name.is_empty()) {
                self.add(format!("{path}[{name}]"), item);
            }
        }
    }

    /// Numbers or texts in a list, by their numbers and the names beside the list.
    fn add_list(&mut self, path: &str, list: &PrimitiveArray, names: &[String]) {
        if let PrimitiveArray::String(texts) = list {
            for (place, text) in texts.iter().enumerate().take(MAX_ITEMS) {
                self.push(format!("{path}[{place}]"), MessageLeaf::Text(text.clone()));
            }
            return;
        }
        let numbers = numbers(list);
        if numbers.len() > MAX_ITEMS {
            return;
        }
        for (place, number) in numbers.into_iter().enumerate() {
            self.push(format!("{path}[{place}]"), MessageLeaf::Number(number));
            if let Some(name) = names.get(place).filter(|name| !name.is_empty()) {
                self.push(format!("{path}[{name}]"), MessageLeaf::Number(number));
            }
        }
    }
}

/// The items of a message that are called `name`, or the message itself: a text of their own is
/// this.
pub(super) fn items_named<'a>(value: &'a Value, name: &str) -> Vec<&'a Value> {
    if texts(value).contains(&name) {
        return vec![value];
    }
    let inner: Vec<&Value> = match value {
        Value::Message(fields) => fields.values().collect(),
        Value::Array(items) | Value::Sequence(items) => items.iter().collect(),
        _ => Vec::new(),
    };
    inner.into_iter().flat_map(|inner| items_named(inner, name)).collect()
}

/// All texts by which an item of a message can be called.
pub(super) fn all_names(value: &Value) -> Vec<&str> {
    let inner: Vec<&Value> = match value {
        Value::Message(fields) => fields.values().collect(),
        Value::Array(items) | Value::Sequence(items) => items.iter().collect(),
        _ => Vec::new(),
    };
    texts(value).into_iter().chain(inner.into_iter().flat_map(all_names)).collect()
}

/// The texts that are fields of a message; a header's frame is none of a body.
fn texts(value: &Value) -> Vec<&str> {
    let Value::Message(fields) = value else { return Vec::new() };
    let is_name = |field: &&String| field.as_str() != "frame_id";
    let texts = fields.iter().filter(|(field, _)| is_name(field)).map(|(_, value)| value);
    texts
        .filter_map(
            |value| if let Value::String(text) = value { Some(text.as_str()) } else { None },
        )
        .collect()
}

/// The names that stand beside the lists of a message: its field `name`, or its only list of texts.
fn item_names(fields: &BTreeMap<String, Value>) -> &[String] {
    let lists: Vec<(&String, &Vec<String>)> = fields
        .iter()
        .filter_map(|(field, value)| match value {
            Value::PrimitiveArray(PrimitiveArray::String(texts))
            | Value::PrimitiveSeq(PrimitiveArray::String(texts)) => Some((field, texts)),
            _ => None,
        })
        .collect();
    let named = lists.iter().find(|(field, _)| field.as_str() == "name");
    let only = if lists.len() == 1 { lists.first() } else { None };
    named.or(only).map_or(&[], |(_, texts)| texts)
}

/// The time that `builtin_interfaces/Time` and `Duration` hold, nanoseconds.
fn time_ns(fields: &BTreeMap<String, Value>) -> Option<i64> {
    match (fields.len(), fields.get("sec")?, fields.get("nanosec")?) {
        (2, Value::I32(seconds), Value::U32(nanoseconds)) => {
            Some(i64::from(*seconds) * 1_000_000_000 + i64::from(*nanoseconds))
        }
        _ => None,
    }
}

fn number(value: &Value) -> f64 {
    match *value {
        Value::Bool(flag) => f64::from(flag),
        Value::I8(number) => f64::from(number),
        Value::U8(number) => f64::from(number),
        Value::I16(number) => f64::from(number),
        Value::U16(number) => f64::from(number),
        Value::I32(number) => f64::from(number),
        Value::U32(number) => f64::from(number),
        Value::I64(number) => number as f64,
        Value::U64(number) => number as f64,
        Value::F32(number) => f64::from(number),
        Value::F64(number) => number,
        _ => f64::NAN,
    }
}

fn numbers(list: &PrimitiveArray) -> Vec<f64> {
    match list {
        PrimitiveArray::Bool(list) => list.iter().map(|flag| f64::from(*flag)).collect(),
        PrimitiveArray::I8(list) => list.iter().map(|number| f64::from(*number)).collect(),
        PrimitiveArray::U8(list) => list.iter().map(|number| f64::from(*number)).collect(),
        PrimitiveArray::I16(list) => list.iter().map(|number| f64::from(*number)).collect(),
        PrimitiveArray::U16(list) => list.iter().map(|number| f64::from(*number)).collect(),
        PrimitiveArray::I32(list) => list.iter().map(|number| f64::from(*number)).collect(),
        PrimitiveArray::U32(list) => list.iter().map(|number| f64::from(*number)).collect(),
        PrimitiveArray::I64(list) => list.iter().map(|number| *number as f64).collect(),
        PrimitiveArray::U64(list) => list.iter().map(|number| *number as f64).collect(),
        PrimitiveArray::F32(list) => list.iter().map(|number| f64::from(*number)).collect(),
        PrimitiveArray::F64(list) => list.clone(),
        PrimitiveArray::String(_) => Vec::new(),
    }
}
