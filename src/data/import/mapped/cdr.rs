//! Messages of ROS 2 in CDR (OMG DDS-XTypes, plain CDR): numbers stand at multiples of their size
//! after the first four bytes, which tell the order of bytes.

/// The fields of a message, in order.
pub(super) struct CdrReader<'a> {
    bytes: &'a [u8],
    /// Bytes after the first four that have been read.
    position: usize,
    is_big_endian: bool,
}

impl<'a> CdrReader<'a> {
    /// The fields after the first four bytes; none for another encoding.
    pub(super) fn new(message: &'a [u8]) -> Option<CdrReader<'a>> {
        let (head, bytes) = message.split_at_checked(4)?;
        let is_big_endian = match head[..2] {
            [0, 0] => true,
            [0, 1] => false,
            _ => return None,
        };
        Some(CdrReader { bytes, position: 0, is_big_endian })
    }

    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.position = self.position.next_multiple_of(N);
        let mut number: [u8; N] =
            self.bytes.get(self.position..self.position + N)?.try_into().ok()?;
        self.position += N;
        if self.is_big_endian {
            number.reverse();
        }
        Some(number)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    fn i32(&mut self) -> Option<i32> {
        self.number().map(i32::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Option<f64> {
        self.number().map(f64::from_le_bytes)
    }

    /// Text, which ends in a zero byte.
    pub(super) fn text(&mut self) -> Option<String> {
        let size = self.u32()? as usize;
        let text = self.bytes.get(self.position..self.position.checked_add(size)?)?;
        self.position += size;
        String::from_utf8(text.strip_suffix(&[0]).unwrap_or(text).to_vec()).ok()
    }

    /// A list whose items `item` reads.
    pub(super) fn list<T>(&mut self, item: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.u32()? as usize;
        // An item takes a byte at least: a damaged count must not take all memory.
        if count > self.bytes.len() {
            return None;
        }
        (0..count).map(|_| item(self)).collect()
    }

    /// `builtin_interfaces/Time`, nanoseconds.
    fn time(&mut self) -> Option<i64> {
        let (seconds, nanoseconds) = (i64::from(self.i32()?), i64::from(self.u32()?));
        Some(seconds * 1_000_000_000 + nanoseconds)
    }

    /// `std_msgs/Header`: its time, nanoseconds.
    pub(super) fn header(&mut self) -> Option<i64> {
        let time = self.time()?;
        self.text()?;
        Some(time)
    }

    /// Three numbers, and for an orientation a fourth.
    pub(super) fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.f64()?;
        }
        Some(numbers)
    }
}
