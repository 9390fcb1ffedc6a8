//! Exact text form of numbers: the hexadecimal digits of their bits. Decimal readers may round the
//! last digit, and long lists of decimals are larger.

/// One number as a text of `DIGITS` hexadecimal digits.
trait Bits: Sized {
    const DIGITS: usize;
    fn write(&self, text: &mut String);
    fn read(digits: &str) -> Option<Self>;
}

macro_rules! bits {
    ($float:ty, $bits:ty, $digits:literal) => {
        impl Bits for $float {
            const DIGITS: usize = $digits;
            fn write(&self, text: &mut String) {
                let bits = self.to_bits();
                for shift in (0..$digits).rev() {
                    let digit = (bits >> (4 * shift)) & 0xf;
                    text.push(char::from(b"0123456789abcdef"[digit as usize]));
                }
            }
            fn read(digits: &str) -> Option<Self> {
                <$bits>::from_str_radix(digits, 16).ok().map(<$float>::from_bits)
            }
        }
    };
}
bits!(f32, u32, 8);
bits!(f64, u64, 16);

fn encode<T: Bits>(values: &[T]) -> String {
    let mut text = String::with_capacity(values.len() * T::DIGITS);
    values.iter().for_each(|value| value.write(&mut text));
    text
}

fn decode<T: Bits>(text: &str) -> Option<Vec<T>> {
    if !text.is_ascii() || !text.len().is_multiple_of(T::DIGITS) {
        return None;
    }
    (0..text.len()).step_by(T::DIGITS).map(|at| T::read(&text[at..at + T::DIGITS])).collect()
}

macro_rules! with_module {
    ($name:ident, $float:ty) => {
        /// For `#[serde(with = …)]` on a list of numbers of this width.
        pub(crate) mod $name {
            use serde::{Deserialize, Deserializer, Serializer, de::Error};

            pub(crate) fn serialize<S: Serializer>(
                values: &[$float],
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(&super::encode(values))
            }

            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Vec<$float>, D::Error> {
                let text = String::deserialize(deserializer)?;
                super::decode(&text)
                    .ok_or_else(|| D::Error::custom("expected the hexadecimal bits of numbers"))
            }
        }
    };
}
with_module!(f32s, f32);
with_module!(f64s, f64);

/// For `#[serde(with = …)]` on one number: its shortest decimal, as text, which is read back
/// exactly.
pub(crate) mod decimal {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(value)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(|_| D::Error::custom(format!("expected a number, found `{text}`")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Serialize, serde::Deserialize)]
    struct One(#[serde(with = "decimal")] f64);

    #[test]
    fn decimals_come_back() {
        for i in 1..2000 {
            let value = (f64::from(i) * 0.7311).sin() * 10.0_f64.powi(i % 40 - 20);
            let text = serde_json::to_string(&One(value)).unwrap();
            assert_eq!(
                serde_json::from_str::<One>(&text).unwrap().0.to_bits(),
                value.to_bits(),
                "{text}"
            );
        }
    }

    #[test]
    fn bits_come_back() {
        let wide = [0.1, -0.0, f64::MIN_POSITIVE / 8.0, 1.0 / 3.0, f64::MAX];
        let back: Vec<f64> = decode(&encode(&wide)).unwrap();
        assert!(wide.iter().zip(&back).all(|(a, b)| a.to_bits() == b.to_bits()));
        let narrow = [0.1_f32, -7.25e-40];
        assert_eq!(decode::<f32>(&encode(&narrow)).unwrap(), narrow);
        assert!(decode::<f32>("0123456").is_none());
        assert!(decode::<f32>("0123456g").is_none());
    }
}
