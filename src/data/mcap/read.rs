//! Reading an MCAP file from beginning to end; indices are not needed for that.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::{MAGIC, opcode};
use crate::data::{DataError, file};

/// Bytes of a chunk after decompression, at most: a damaged size must not take all memory.
const MAX_CHUNK_BYTES: u64 = 4 << 30;

/// A file's messages by topic.
#[derive(Debug)]
pub(crate) struct Bag {
    /// The file.
    pub(crate) file: PathBuf,
    /// Topics in the order of their names.
    pub(crate) topics: BTreeMap<String, BagTopic>,
}

/// The messages of a topic, in the order of their log times.
#[derive(Debug, Default)]
pub(crate) struct BagTopic {
    /// The messages' types; one, unless publishers disagree.
    pub(crate) kinds: Vec<MessageKind>,
    /// The messages.
    pub(crate) messages: Vec<BagMessage>,
}

/// A type of messages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct MessageKind {
    /// Its name.
    pub(crate) name: String,
    /// How its messages are written, such as `cdr`.
    pub(crate) encoding: String,
    /// Its definition; empty where the bag holds none.
    pub(crate) definition: String,
    /// The language of the definition, such as `ros2msg`.
    pub(crate) definition_encoding: String,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BagMessage {
    /// When it was recorded, nanoseconds.
    pub(crate) log_ns: u64,
    /// When it was published, nanoseconds.
    pub(crate) publish_ns: u64,
    /// Its bytes.
    pub(crate) data: Vec<u8>,
}

/// The bytes that are left of a record.
struct RecordFields<'a>(&'a [u8]);

impl<'a> RecordFields<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn number<const N: usize>(&mut self) -> Option<u64> {
        let mut bytes = [0; 8];
        bytes[..N].copy_from_slice(self.take(N)?);
        Some(u64::from_le_bytes(bytes))
    }

    fn text(&mut self) -> Option<String> {
        let count = self.number::<4>()? as usize;
        String::from_utf8(self.take(count)?.to_vec()).ok()
    }
}

/// What has been read so far.
#[derive(Default)]
struct Contents {
    /// Types of messages, whose encoding a channel tells.
    schemas: BTreeMap<u64, MessageKind>,
    /// Topic of each channel.
    channels: BTreeMap<u64, String>,
    topics: BTreeMap<String, BagTopic>,
}

impl Bag {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DataError::Line`] for another kind of file and a damaged one, with the byte.
    pub(crate) fn read(path: &Path) -> Result<Bag, DataError> {
        Bag::parse(path, &file::read(path)?)
    }

    /// Reads the bytes of a file. Errors as [`Bag::read`].
    pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Bag, DataError> {
        let Some(records) = bytes.strip_prefix(&MAGIC) else {
            let found = match bytes {
                [b'S', b'Q', b'L', b'i', b't', b'e', ..] => "a database of SQLite",
                [b'#', b'R', b'O', b'S', b'B', b'A', b'G', ..] => "a bag of ROS 1",
                [] => "nothing",
                _ => "another kind of file",
            };
            return Err(damaged(
                path,
                0,
                found,
                "an MCAP file (`rosbags-convert --src BAG --dst NEW --dst-storage mcap`, of the \
                 Python package rosbags, converts other bags)",
            ));
        };
        let mut contents = Contents::default();
        contents.records(records).map_err(|(remaining, found, expected)| {
            damaged(path, bytes.len() - remaining, &found, expected)
        })?;
        let mut topics = contents.topics;
        topics.values_mut().for_each(|topic| topic.messages.sort_by_key(|message| message.log_ns));
        Ok(Bag { file: path.to_owned(), topics })
    }
}

fn damaged(path: &Path, byte: usize, found: &str, expected: &str) -> DataError {
    let place = format!("byte {byte}");
    DataError::Line {
        file: path.to_owned(),
        place,
        found: found.to_owned(),
        expected: expected.to_owned(),
    }
}

/// How many bytes are left, what was found and what was expected.
type Damage = (usize, String, &'static str);

impl Contents {
    /// Reads records to the end of the data; `bytes` begin with one.
    fn records(&mut self, bytes: &[u8]) -> Result<(), Damage> {
        const WHOLE: &str = "a whole record (`mcap recover` repairs a bag that was not closed)";
        let mut fields = RecordFields(bytes);
        while !fields.0.is_empty() {
            let remaining = fields.0.len();
            let cut = || (remaining, "the end of the file within a record".to_owned(), WHOLE);
            let kind = fields.number::<1>().ok_or_else(cut)? as u8;
            let size = fields.number::<8>().ok_or_else(cut)?;
            let content =
                usize::try_from(size).ok().and_then(|size| fields.take(size)).ok_or_else(cut)?;
            // What follows repeats what stands before.
            if matches!(kind, opcode::DATA_END | opcode::FOOTER) {
                return Ok(());
            }
            let broken =
                || (remaining, format!("a damaged record of kind {kind}"), "an intact one");
            if kind == opcode::CHUNK {
                let chunk = chunk(&mut RecordFields(content))
                    .map_err(|(found, expected)| (remaining, found, expected))?;
                self.records(&chunk).map_err(|(_, found, expected)| {
                    (remaining, format!("{found} of a chunk"), expected)
                })?;
            } else {
                self.record(kind, &mut RecordFields(content)).ok_or_else(broken)?;
            }
        }
        Ok(())
    }

    fn record(&mut self, kind: u8, fields: &mut RecordFields) -> Option<()> {
        match kind {
            opcode::SCHEMA => {
                let id = fields.number::<2>()?;
                let (name, definition_encoding) = (fields.text()?, fields.text()?);
                let count = fields.number::<4>()? as usize;
                // Definitions in other languages may be no text.
                let definition = String::from_utf8(fields.take(count)?.to_vec());
                let (definition, encoding) = (definition.unwrap_or_default(), String::new());
                let kind = MessageKind { name, encoding, definition, definition_encoding };
                self.schemas.insert(id, kind);
            }
            opcode::CHANNEL => {
                let (id, schema) = (fields.number::<2>()?, fields.number::<2>()?);
                let (topic, encoding) = (fields.text()?, fields.text()?);
                let kind = self.schemas.get(&schema).cloned().unwrap_or_default();
                let kind = MessageKind { encoding, ..kind };
                let bag_topic = self.topics.entry(topic.clone()).or_default();
                if !bag_topic.kinds.contains(&kind) {
                    bag_topic.kinds.push(kind);
                }
                self.channels.insert(id, topic);
            }
            opcode::MESSAGE => {
                let topic = self.channels.get(&fields.number::<2>()?)?;
                fields.number::<4>()?;
                let (log_ns, publish_ns) = (fields.number::<8>()?, fields.number::<8>()?);
                let message = BagMessage { log_ns, publish_ns, data: fields.0.to_vec() };
                self.topics.get_mut(topic)?.messages.push(message);
            }
            // Indices, attachments, metadata, and kinds that are yet to come.
            _ => {}
        }
        Some(())
    }
}

/// The records of a chunk.
fn chunk(fields: &mut RecordFields) -> Result<Vec<u8>, (String, &'static str)> {
    let broken = || ("a damaged chunk".to_owned(), "an intact one");
    let mut header = || {
        fields.number::<8>()?;
        fields.number::<8>()?;
        let (size, _check, compression) =
            (fields.number::<8>()?, fields.number::<4>()?, fields.text()?);
        let count = usize::try_from(fields.number::<8>()?).ok()?;
        Some((size, compression, fields.take(count)?))
    };
    let (size, compression, compressed) = header().ok_or_else(broken)?;
    if size > MAX_CHUNK_BYTES {
        return Err((format!("a chunk of {size} bytes"), "at most 4 GiB"));
    }
    let mut records = Vec::new();
    let read = match compression.as_str() {
        "" => return Ok(compressed.to_vec()),
        "zstd" => zstd::Decoder::new(compressed)
            .and_then(|unpack| unpack.take(size).read_to_end(&mut records)),
        "lz4" => lz4::Decoder::new(compressed)
            .and_then(|unpack| unpack.take(size).read_to_end(&mut records)),
        other => return Err((format!("the compression `{other}`"), "`zstd`, `lz4` or none")),
    };
    match read {
        Ok(count) if count as u64 == size => Ok(records),
        _ => Err(broken()),
    }
}
