//! Text files as editors of all systems write them: UTF-8 with or without a byte-order mark, and
//! UTF-16 with one.

use std::borrow::Cow;
use std::io::{Error, ErrorKind};
use std::path::Path;

/// The text of `bytes` without its byte-order mark.
///
/// # Errors
/// The line (from 1) of the first bytes that are no text, and the expected encoding.
pub(crate) fn decode_text(bytes: &[u8]) -> Result<Cow<'_, str>, (usize, &'static str)> {
    match bytes {
        [0xFF, 0xFE, units @ ..] => decode_utf16(units, u16::from_le_bytes),
        [0xFE, 0xFF, units @ ..] => decode_utf16(units, u16::from_be_bytes),
        [0xEF, 0xBB, 0xBF, text @ ..] | text => {
            std::str::from_utf8(text).map(Cow::Borrowed).map_err(|error| {
                let line =
                    1 + text[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
                (line, "UTF-8")
            })
        }
    }
}

fn decode_utf16(
    bytes: &[u8],
    unit: fn([u8; 2]) -> u16,
) -> Result<Cow<'_, str>, (usize, &'static str)> {
    let pairs = bytes.chunks(2).map(|pair| unit([pair[0], pair.get(1).copied().unwrap_or(0)]));
    let mut text = String::with_capacity(bytes.len() / 2);
    for letter in char::decode_utf16(pairs) {
        match letter {
            Ok(letter) => text.push(letter),
            Err(_) => {
                return Err((1 + text.matches('\n').count(), "UTF-16, as in its byte-order mark"));
            }
        }
    }
    Ok(Cow::Owned(text))
}

/// Reads a text file: UTF-8, with or without a byte-order mark, or UTF-16 with one.
///
/// # Errors
/// The error of the file system, or [`ErrorKind::InvalidData`] with the line that is no text.
pub fn read_text(path: &Path) -> std::io::Result<String> {
    let bytes = std::fs::read(path)?;
    decode_text(&bytes).map(Cow::into_owned).map_err(|(line, expected)| {
        Error::new(
            ErrorKind::InvalidData,
            format!("line {line}: found bytes that are not text, expected {expected}"),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_order_mark_is_no_part_of_the_text() {
        let text = "robot: {}\nä: 1\n";
        let utf16 = |mark: char, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            format!("{mark}{text}").encode_utf16().flat_map(bytes).collect()
        };
        let marked = [
            text.as_bytes().to_vec(),
            format!("\u{feff}{text}").into_bytes(),
            utf16('\u{feff}', u16::to_le_bytes),
            utf16('\u{feff}', u16::to_be_bytes),
        ];
        for bytes in marked {
            assert_eq!(decode_text(&bytes).unwrap(), text);
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_refused_with_their_line() {
        assert_eq!(decode_text(b"a\nb\n\xff").unwrap_err().0, 3);
        assert_eq!(decode_text(&[0xFF, 0xFE, b'\n', 0, 0, 0xDC]).unwrap_err().0, 2);
    }
}
