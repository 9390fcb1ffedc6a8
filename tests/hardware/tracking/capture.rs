//! Recorded packets of a real server.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::path::{Path, PathBuf};

/// Folder of the recordings: they come with the tests.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/natnet")
}

/// Motive 2.1 with NatNet 3.0, one rigid body at 120 Hz.
pub(crate) const CAPTURE: &str = "motive-2.1-natnet-3.0.pcapng";

/// Single packets of the same server.
pub(crate) const PACKETS: [&str; 9] = [
    "connect_packet_v3.bin",
    "discovery_packet_v3.bin",
    "echorequest_packet_v3.bin",
    "echoresponse_packet_v3.bin",
    "mocapframe_packet_occluded_v3.bin",
    "mocapframe_packet_v3.bin",
    "modeldef_packet_v3.bin",
    "requestmodeldef_packet_v3.bin",
    "serverinfo_packet_v3.bin",
];

/// A UDP datagram on the wire.
pub(crate) struct Datagram {
    pub(crate) time_s: f64,
    pub(crate) from: SocketAddr,
    pub(crate) payload: Vec<u8>,
}

/// The UDP datagrams of a little-endian pcapng file of Ethernet frames with times in microseconds.
pub(crate) fn datagrams(file: &[u8]) -> Vec<Datagram> {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    let mut found = Vec::new();
    let mut at = 0;
    while at + 12 <= file.len() {
        let length = word(at + 4) as usize;
        const ENHANCED_PACKET: u32 = 6;
        if word(at) == ENHANCED_PACKET {
            let ticks = u64::from(word(at + 12)) << 32 | u64::from(word(at + 16));
            let captured = word(at + 20) as usize;
            found.extend(datagram(ticks as f64 * 1e-6, &file[at + 28..at + 28 + captured]));
        }
        at += length;
    }
    found
}

fn datagram(time_s: f64, ethernet: &[u8]) -> Option<Datagram> {
    const IPV4: [u8; 2] = [8, 0];
    const UDP: u8 = 17;
    let ip = (ethernet[12..14] == IPV4).then(|| &ethernet[14..])?;
    let udp = (ip[9] == UDP).then(|| &ip[usize::from(ip[0] & 15) * 4..])?;
    let short = |at: usize| u16::from_be_bytes([udp[at], udp[at + 1]]);
    let address = Ipv4Addr::from(<[u8; 4]>::try_from(&ip[12..16]).unwrap());
    let from = SocketAddr::V4(SocketAddrV4::new(address, short(0)));
    Some(Datagram { time_s, from, payload: udp[8..usize::from(short(4))].to_vec() })
}
