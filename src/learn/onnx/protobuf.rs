//! The wire format of protocol buffers: fields of a message, by number
//! (<https://protobuf.dev/programming-guides/encoding/>).

use super::OnnxError;

/// The value of a field.
#[derive(Clone, Copy)]
pub(super) enum WireValue<'a> {
    /// A whole number.
    Number(u64),
    /// Eight bytes.
    Eight([u8; 8]),
    /// A text, a message, or packed numbers.
    Bytes(&'a [u8]),
    /// Four bytes.
    Four([u8; 4]),
}

impl<'a> WireValue<'a> {
    pub(super) fn bytes(self) -> Result<&'a [u8], OnnxError> {
        match self {
            WireValue::Bytes(bytes) => Ok(bytes),
            _ => Err(OnnxError::NotOnnx("a number, expected a message")),
        }
    }

    pub(super) fn text(self) -> Result<String, OnnxError> {
        Ok(String::from_utf8_lossy(self.bytes()?).into_owned())
    }

    pub(super) fn number(self) -> Result<i64, OnnxError> {
        match self {
            WireValue::Number(number) => Ok(number.cast_signed()),
            _ => Err(OnnxError::NotOnnx("a message, expected a number")),
        }
    }

    /// Whole numbers, one or packed.
    pub(super) fn numbers(self) -> Result<Vec<i64>, OnnxError> {
        match self {
            WireValue::Bytes(mut bytes) => {
                let mut all = Vec::new();
                while !bytes.is_empty() {
                    all.push(varint(&mut bytes)?.cast_signed());
                }
                Ok(all)
            }
            one => Ok(vec![one.number()?]),
        }
    }

    /// Numbers of four bytes, one or packed.
    pub(super) fn floats(self) -> Result<Vec<f64>, OnnxError> {
        match self {
            WireValue::Four(bytes) => Ok(vec![f64::from(f32::from_le_bytes(bytes))]),
            other => Ok(floats(other.bytes()?)),
        }
    }

    /// Numbers of eight bytes, one or packed.
    pub(super) fn doubles(self) -> Result<Vec<f64>, OnnxError> {
        match self {
            WireValue::Eight(bytes) => Ok(vec![f64::from_le_bytes(bytes)]),
            other => Ok(doubles(other.bytes()?)),
        }
    }
}

/// Little-endian numbers of four bytes.
pub(super) fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes
        .chunks_exact(4)
        .map(|four| f64::from(f32::from_le_bytes([four[0], four[1], four[2], four[3]])))
        .collect()
}

/// Little-endian numbers of eight bytes.
pub(super) fn doubles(bytes: &[u8]) -> Vec<f64> {
    let number =
        |eight: &[u8]| eight.iter().rev().fold(0_u64, |all, byte| all << 8 | u64::from(*byte));
    bytes.chunks_exact(8).map(|eight| f64::from_bits(number(eight))).collect()
}

/// Little-endian whole numbers of eight bytes.
pub(super) fn integers(bytes: &[u8]) -> Vec<f64> {
    let number =
        |eight: &[u8]| eight.iter().rev().fold(0_u64, |all, byte| all << 8 | u64::from(*byte));
    bytes.chunks_exact(8).map(|eight| number(eight).cast_signed() as f64).collect()
}

const TRUNCATED: OnnxError = OnnxError::NotOnnx("the file ends within a field");

fn varint(bytes: &mut &[u8]) -> Result<u64, OnnxError> {
    let mut value = 0_u64;
    for place in 0..10 {
        let (&byte, remaining) = bytes.split_first().ok_or(TRUNCATED)?;
        *bytes = remaining;
        // Seven bits a byte, the lowest first; the eighth says that more follow.
        value |= u64::from(byte & 0x7f) << (7 * place).min(63);
        if byte & 0x80 == 0 {
            return Ok(value);
        }
    }
    Err(OnnxError::NotOnnx("a number of more than ten bytes"))
}

fn take<'a>(bytes: &mut &'a [u8], count: u64) -> Result<&'a [u8], OnnxError> {
    let count =
        usize::try_from(count).ok().filter(|count| *count <= bytes.len()).ok_or(TRUNCATED)?;
    let (front, remaining) = bytes.split_at(count);
    *bytes = remaining;
    Ok(front)
}

/// The fields of a message, in their order.
pub(super) fn fields(mut bytes: &[u8]) -> Result<Vec<(u64, WireValue<'_>)>, OnnxError> {
    let mut parsed = Vec::new();
    while !bytes.is_empty() {
        let tag = varint(&mut bytes)?;
        // A tag is the field number and, in its lowest three bits, the wire type.
        let value = match tag & 7 {
            0 => WireValue::Number(varint(&mut bytes)?),
            1 => WireValue::Eight(take(&mut bytes, 8)?.try_into().map_err(|_| TRUNCATED)?),
            2 => {
                let count = varint(&mut bytes)?;
                WireValue::Bytes(take(&mut bytes, count)?)
            }
            5 => WireValue::Four(take(&mut bytes, 4)?.try_into().map_err(|_| TRUNCATED)?),
            _ => return Err(OnnxError::NotOnnx("a field of an unknown kind")),
        };
        parsed.push((tag >> 3, value));
    }
    Ok(parsed)
}
