//! Writing an MCAP file: one chunk for every so many bytes, with the indices by which viewers seek.

use std::collections::BTreeMap;

use super::{MAGIC, opcode};

/// Bytes after which a chunk is closed.
const CHUNK_BYTES: usize = 1 << 20;

/// Messages on their way into a file. Times must not decrease.
#[derive(Default)]
pub(crate) struct BagWriter {
    bytes: Vec<u8>,
    /// Schema and channel records, which the summary repeats.
    schemas: Vec<u8>,
    channels: Vec<u8>,
    counts: BTreeMap<u16, u64>,
    schema_count: u16,
    chunk: OpenChunk,
    chunk_indices: Vec<u8>,
    chunk_count: u32,
    span_ns: Option<(u64, u64)>,
}

#[derive(Default)]
struct OpenChunk {
    records: Vec<u8>,
    span_ns: Option<(u64, u64)>,
    /// Log time and place of the messages of each channel.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
}

fn text(into: &mut Vec<u8>, text: &str) {
    into.extend((text.len() as u32).to_le_bytes());
    into.extend(text.as_bytes());
}

fn record(into: &mut Vec<u8>, kind: u8, content: &[u8]) {
    into.push(kind);
    into.extend((content.len() as u64).to_le_bytes());
    into.extend(content);
}

fn widened(span_ns: Option<(u64, u64)>, time_ns: u64) -> Option<(u64, u64)> {
    span_ns.map_or(Some((time_ns, time_ns)), |(first, last)| {
        Some((first.min(time_ns), last.max(time_ns)))
    })
}

impl BagWriter {
    /// A file without messages.
    pub(crate) fn new() -> BagWriter {
        let mut bytes = MAGIC.to_vec();
        let mut header = Vec::new();
        text(&mut header, "");
        text(&mut header, concat!("spinebench ", env!("CARGO_PKG_VERSION")));
        record(&mut bytes, opcode::HEADER, &header);
        BagWriter { bytes, ..BagWriter::default() }
    }

    /// Declares a topic of JSON messages with the schema of their type; returns its channel.
    pub(crate) fn channel(&mut self, topic: &str, kind: &str, schema: &serde_json::Value) -> u16 {
        self.schema_count += 1;
        let id = self.schema_count;
        let schema_text = schema.to_string();
        let mut content = id.to_le_bytes().to_vec();
        text(&mut content, kind);
        text(&mut content, "jsonschema");
        text(&mut content, &schema_text);
        let mut records = Vec::new();
        record(&mut records, opcode::SCHEMA, &content);
        self.schemas.extend(&records);
        let mut content = [id.to_le_bytes(), id.to_le_bytes()].concat();
        text(&mut content, topic);
        text(&mut content, "json");
        content.extend(0_u32.to_le_bytes());
        let schema_bytes = records.len();
        record(&mut records, opcode::CHANNEL, &content);
        self.channels.extend(&records[schema_bytes..]);
        self.chunk.records.extend(records);
        self.counts.insert(id, 0);
        id
    }

    /// Adds a message.
    pub(crate) fn message(&mut self, channel: u16, time_ns: u64, message: &serde_json::Value) {
        let count = self.counts.entry(channel).or_default();
        let mut content = channel.to_le_bytes().to_vec();
        content.extend((*count as u32).to_le_bytes());
        content.extend(time_ns.to_le_bytes());
        content.extend(time_ns.to_le_bytes());
        content.extend(message.to_string().as_bytes());
        *count += 1;
        let place = self.chunk.records.len() as u64;
        self.chunk.index.entry(channel).or_default().push((time_ns, place));
        self.chunk.span_ns = widened(self.chunk.span_ns, time_ns);
        self.span_ns = widened(self.span_ns, time_ns);
        record(&mut self.chunk.records, opcode::MESSAGE, &content);
        if self.chunk.records.len() >= CHUNK_BYTES {
            self.close_chunk();
        }
    }

    fn close_chunk(&mut self) {
        let OpenChunk { records, span_ns, index } = std::mem::take(&mut self.chunk);
        if records.is_empty() {
            return;
        }
        let (first_ns, last_ns) = span_ns.unwrap_or_default();
        let size = records.len() as u64;
        let start = self.bytes.len() as u64;
        let mut content = Vec::with_capacity(records.len() + 64);
        content.extend(first_ns.to_le_bytes());
        content.extend(last_ns.to_le_bytes());
        content.extend(size.to_le_bytes());
        // No check sum, no compression.
        content.extend(0_u32.to_le_bytes());
        text(&mut content, "");
        content.extend(size.to_le_bytes());
        content.extend(&records);
        record(&mut self.bytes, opcode::CHUNK, &content);
        let end = self.bytes.len() as u64;
        let mut index_offsets = Vec::new();
        for (channel, messages) in &index {
            index_offsets.extend(channel.to_le_bytes());
            index_offsets.extend((self.bytes.len() as u64).to_le_bytes());
            let mut content = channel.to_le_bytes().to_vec();
            content.extend(((messages.len() * 16) as u32).to_le_bytes());
            messages.iter().for_each(|(time_ns, place)| {
                content.extend([time_ns.to_le_bytes(), place.to_le_bytes()].concat())
            });
            record(&mut self.bytes, opcode::MESSAGE_INDEX, &content);
        }
        let mut content = Vec::new();
        [first_ns, last_ns, start, end - start]
            .iter()
            .for_each(|number| content.extend(number.to_le_bytes()));
        content.extend((index_offsets.len() as u32).to_le_bytes());
        content.extend(index_offsets);
        content.extend((self.bytes.len() as u64 - end).to_le_bytes());
        text(&mut content, "");
        content.extend(size.to_le_bytes());
        content.extend(size.to_le_bytes());
        record(&mut self.chunk_indices, opcode::CHUNK_INDEX, &content);
        self.chunk_count += 1;
    }

    fn statistics(&self) -> Vec<u8> {
        let (first_ns, last_ns) = self.span_ns.unwrap_or_default();
        let mut content = self.counts.values().sum::<u64>().to_le_bytes().to_vec();
        content.extend(self.schema_count.to_le_bytes());
        content.extend((self.counts.len() as u32).to_le_bytes());
        content.extend([0_u8; 8]);
        content.extend(self.chunk_count.to_le_bytes());
        content.extend(first_ns.to_le_bytes());
        content.extend(last_ns.to_le_bytes());
        content.extend(((self.counts.len() * 10) as u32).to_le_bytes());
        for (channel, count) in &self.counts {
            content.extend(channel.to_le_bytes());
            content.extend(count.to_le_bytes());
        }
        let mut bytes = Vec::new();
        record(&mut bytes, opcode::STATISTICS, &content);
        bytes
    }

    /// The bytes of the file.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.close_chunk();
        record(&mut self.bytes, opcode::DATA_END, &0_u32.to_le_bytes());
        let summary = self.bytes.len() as u64;
        let groups = [
            (opcode::SCHEMA, self.schemas.clone()),
            (opcode::CHANNEL, self.channels.clone()),
            (opcode::STATISTICS, self.statistics()),
            (opcode::CHUNK_INDEX, self.chunk_indices.clone()),
        ];
        let mut offsets = Vec::new();
        for (kind, group) in groups.into_iter().filter(|(_, group)| !group.is_empty()) {
            let mut content = vec![kind];
            content.extend((self.bytes.len() as u64).to_le_bytes());
            content.extend((group.len() as u64).to_le_bytes());
            record(&mut offsets, opcode::SUMMARY_OFFSET, &content);
            self.bytes.extend(group);
        }
        let mut footer = summary.to_le_bytes().to_vec();
        footer.extend((self.bytes.len() as u64).to_le_bytes());
        footer.extend(0_u32.to_le_bytes());
        self.bytes.extend(offsets);
        record(&mut self.bytes, opcode::FOOTER, &footer);
        self.bytes.extend(MAGIC);
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::super::Bag;
    use super::*;
    use serde_json::json;
    use std::path::Path;

    #[test]
    fn what_is_written_is_read_and_a_cut_file_is_refused() {
        let mut writer = BagWriter::new();
        let schema = json!({ "type": "object" });
        let (a, b) = (writer.channel("/a", "A", &schema), writer.channel("/b", "B", &schema));
        let long = "x".repeat(CHUNK_BYTES / 2);
        for k in 0..5_u64 {
            writer.message(a, 10 * k, &json!({ "k": k, "long": long }));
            writer.message(b, 10 * k, &json!(k));
        }
        let bytes = writer.finish();
        let read = |bytes: &[u8]| Bag::parse(Path::new("a.mcap"), bytes);
        let bag = read(&bytes).unwrap();
        let kind = &bag.topics["/a"].kinds[0];
        assert_eq!((kind.name.as_str(), kind.encoding.as_str()), ("A", "json"));
        let times: Vec<u64> =
            bag.topics["/b"].messages.iter().map(|message| message.log_ns).collect();
        assert_eq!(
            (times, &bag.topics["/b"].messages[3].data[..]),
            (vec![0, 10, 20, 30, 40], &b"3"[..])
        );
        let said = read(&bytes[..bytes.len() / 2]).unwrap_err().to_string();
        assert!(said.contains("the end of the file within a record"), "{said}");
        assert!(read(b"SQLite format 3").unwrap_err().to_string().contains("a database of SQLite"));
    }
}
