//! MCAP files (mcap.dev/spec), the format of ROS 2 bags and of Foxglove: records behind a magic
//! number, messages in chunks that may be compressed.

mod export;
mod read;
mod robot;
mod write;

pub use export::{Shown, to_mcap};

#[cfg(test)]
pub(crate) use read::BagTopic;
pub(crate) use read::{Bag, BagMessage, MessageKind};
pub(crate) use write::BagWriter;

/// First and last bytes of a file.
const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];

/// Kinds of records.
mod opcode {
    pub(super) const HEADER: u8 = 0x01;
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const MESSAGE_INDEX: u8 = 0x07;
    pub(super) const CHUNK_INDEX: u8 = 0x08;
    pub(super) const STATISTICS: u8 = 0x0B;
    pub(super) const SUMMARY_OFFSET: u8 = 0x0E;
    pub(super) const DATA_END: u8 = 0x0F;
}
