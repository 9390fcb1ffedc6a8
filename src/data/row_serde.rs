//! Conversion between plain structs and table rows through serde: field names are column names, in declaration order.

use serde::de::value::MapDeserializer;
use serde::de::{self, IntoDeserializer};
use serde::ser::{self, Impossible};
use serde::{Deserializer, Serialize, Serializer, forward_to_deserialize_any};

/// Value of one field.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FieldValue {
    Integer(i64),
    Unsigned(u64),
    Number(f64),
    Flag(bool),
    Text(String),
    Missing,
}

/// Why a struct is not a row, or a cell does not fit its field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum RowError {
    #[error("a row has fields of numbers, text and flags only: {0}")]
    NotFlat(String),
    #[error("no column `{0}`")]
    MissingColumn(String),
    #[error("column `{0}` is not known")]
    UnknownColumn(String),
    #[error("{expected} expected")]
    Value { column: String, expected: String },
}

impl ser::Error for RowError {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        RowError::NotFlat(message.to_string())
    }
}

impl de::Error for RowError {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        RowError::Value { column: String::new(), expected: message.to_string() }
    }

    fn missing_field(field: &'static str) -> Self {
        RowError::MissingColumn(field.to_owned())
    }
}

/// The fields of a row, name and value, in declaration order.
pub(crate) fn fields_of<R: Serialize>(row: &R) -> Result<Vec<(&'static str, FieldValue)>, RowError> {
    row.serialize(RowSerializer)
}

fn not_flat<T>(what: &str) -> Result<T, RowError> {
    Err(RowError::NotFlat(what.to_owned()))
}

/// Serialises a struct to its fields.
struct RowSerializer;

/// The fields met so far.
#[derive(Default)]
struct Fields(Vec<(&'static str, FieldValue)>);

impl ser::SerializeStruct for Fields {
    type Ok = Vec<(&'static str, FieldValue)>;
    type Error = RowError;

    fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), RowError> {
        self.0.push((key, value.serialize(CellSerializer)?));
        Ok(())
    }

    fn end(self) -> Result<Self::Ok, RowError> {
        Ok(self.0)
    }
}

/// Serialises one field.
struct CellSerializer;

macro_rules! refuse {
    ($ok:ty; $($name:ident($($kind:ty),*)),* $(,)?) => {
        $(fn $name(self, $(_: $kind),*) -> Result<$ok, RowError> { not_flat(stringify!($name)) })*
    };
}

macro_rules! refuse_compound {
    ($ok:ty) => {
        type SerializeSeq = Impossible<$ok, RowError>;
        type SerializeTuple = Impossible<$ok, RowError>;
        type SerializeTupleStruct = Impossible<$ok, RowError>;
        type SerializeTupleVariant = Impossible<$ok, RowError>;
        type SerializeMap = Impossible<$ok, RowError>;
        type SerializeStructVariant = Impossible<$ok, RowError>;

        fn serialize_seq(self, _: Option<usize>) -> Result<Self::SerializeSeq, RowError> {
            not_flat("a sequence")
        }
        fn serialize_tuple(self, _: usize) -> Result<Self::SerializeTuple, RowError> {
            not_flat("a tuple")
        }
        fn serialize_tuple_struct(self, name: &'static str, _: usize) -> Result<Self::SerializeTupleStruct, RowError> {
            not_flat(name)
        }
        fn serialize_tuple_variant(
            self,
            name: &'static str,
            _: u32,
            _: &'static str,
            _: usize,
        ) -> Result<Self::SerializeTupleVariant, RowError> {
            not_flat(name)
        }
        fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, RowError> {
            not_flat("a map")
        }
        fn serialize_struct_variant(
            self,
            name: &'static str,
            _: u32,
            _: &'static str,
            _: usize,
        ) -> Result<Self::SerializeStructVariant, RowError> {
            not_flat(name)
        }
        fn serialize_newtype_variant<T: Serialize + ?Sized>(
            self,
            name: &'static str,
            _: u32,
            _: &'static str,
            _: &T,
        ) -> Result<$ok, RowError> {
            not_flat(name)
        }
        fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Result<$ok, RowError> {
            value.serialize(self)
        }
    };
}

impl Serializer for RowSerializer {
    type Ok = Vec<(&'static str, FieldValue)>;
    type Error = RowError;
    type SerializeStruct = Fields;

    refuse_compound!(Self::Ok);
    refuse!(Self::Ok; serialize_bool(bool), serialize_i8(i8), serialize_i16(i16), serialize_i32(i32), serialize_i64(i64),
        serialize_u8(u8), serialize_u16(u16), serialize_u32(u32), serialize_u64(u64), serialize_f32(f32),
        serialize_f64(f64), serialize_char(char), serialize_str(&str), serialize_bytes(&[u8]), serialize_none(),
        serialize_unit(), serialize_unit_struct(&'static str),
        serialize_unit_variant(&'static str, u32, &'static str));

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<Self::Ok, RowError> {
        value.serialize(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Fields, RowError> {
        Ok(Fields::default())
    }
}

macro_rules! cell_numbers {
    ($($name:ident: $kind:ty => $cell:ident),* $(,)?) => {
        $(fn $name(self, value: $kind) -> Result<FieldValue, RowError> { Ok(FieldValue::$cell(value.into())) })*
    };
}

impl Serializer for CellSerializer {
    type Ok = FieldValue;
    type Error = RowError;
    type SerializeStruct = Impossible<FieldValue, RowError>;

    refuse_compound!(FieldValue);
    refuse!(FieldValue; serialize_bytes(&[u8]), serialize_unit_struct(&'static str));
    cell_numbers!(serialize_bool: bool => Flag, serialize_i8: i8 => Integer, serialize_i16: i16 => Integer,
        serialize_i32: i32 => Integer, serialize_i64: i64 => Integer, serialize_u8: u8 => Unsigned,
        serialize_u16: u16 => Unsigned, serialize_u32: u32 => Unsigned, serialize_u64: u64 => Unsigned,
        serialize_f32: f32 => Number, serialize_f64: f64 => Number, serialize_char: char => Text,
        serialize_str: &str => Text);

    fn serialize_none(self) -> Result<FieldValue, RowError> {
        Ok(FieldValue::Missing)
    }
    fn serialize_unit(self) -> Result<FieldValue, RowError> {
        Ok(FieldValue::Missing)
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<FieldValue, RowError> {
        value.serialize(self)
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Result<FieldValue, RowError> {
        Ok(FieldValue::Text(variant.to_owned()))
    }
    fn serialize_struct(self, name: &'static str, _: usize) -> Result<Self::SerializeStruct, RowError> {
        not_flat(name)
    }
}

/// A row as text cells under their column names, to be read as a struct.
pub(crate) struct TextRow<'a> {
    /// Column names.
    pub(crate) names: &'a [&'a str],
    /// One cell a column.
    pub(crate) cells: &'a [&'a str],
}

impl<'de> Deserializer<'de> for TextRow<'_> {
    type Error = RowError;

    fn deserialize_any<V: de::Visitor<'de>>(self, _: V) -> Result<V::Value, RowError> {
        not_flat("a row is read into a struct")
    }

    fn deserialize_struct<V: de::Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, RowError> {
        let cells = self.names.iter().zip(self.cells);
        let row =
            visitor.visit_map(MapDeserializer::new(cells.map(|(&name, &text)| (name, TextCell { name, text }))))?;
        match self.names.iter().find(|name| !fields.contains(name)) {
            Some(name) => Err(RowError::UnknownColumn((*name).to_owned())),
            None => Ok(row),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// One cell and the name of its column.
#[derive(Clone, Copy)]
struct TextCell<'a> {
    name: &'a str,
    text: &'a str,
}

impl TextCell<'_> {
    fn parse<T: std::str::FromStr>(&self, expected: &str) -> Result<T, RowError> {
        let wrong = |_| RowError::Value { column: self.name.to_owned(), expected: expected.to_owned() };
        self.text.parse().map_err(wrong)
    }
}

impl<'a> IntoDeserializer<'_, RowError> for TextCell<'a> {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}

macro_rules! parse_cells {
    ($($name:ident, $visit:ident, $expected:literal);* $(;)?) => {
        $(fn $name<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
            visitor.$visit(self.parse($expected)?)
        })*
    };
}

impl<'de> Deserializer<'de> for TextCell<'_> {
    type Error = RowError;

    parse_cells! {
        deserialize_bool, visit_bool, "true or false";
        deserialize_i8, visit_i8, "a whole number"; deserialize_i16, visit_i16, "a whole number";
        deserialize_i32, visit_i32, "a whole number"; deserialize_i64, visit_i64, "a whole number";
        deserialize_u8, visit_u8, "0 or a positive whole number"; deserialize_u16, visit_u16, "0 or a positive whole number";
        deserialize_u32, visit_u32, "0 or a positive whole number"; deserialize_u64, visit_u64, "0 or a positive whole number";
        deserialize_char, visit_char, "one character";
    }

    fn deserialize_any<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        visitor.visit_str(self.text)
    }

    fn deserialize_f32<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        self.deserialize_f64(visitor)
    }

    fn deserialize_f64<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        // A missing number is published as an empty cell.
        if self.text.is_empty() { visitor.visit_f64(f64::NAN) } else { visitor.visit_f64(self.parse("a number")?) }
    }

    fn deserialize_option<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        if self.text.is_empty() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_enum<V: de::Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, RowError> {
        visitor.visit_enum(self.text.into_deserializer())
    }

    fn deserialize_newtype_struct<V: de::Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, RowError> {
        visitor.visit_newtype_struct(self)
    }

    forward_to_deserialize_any! {
        i128 u128 str string bytes byte_buf unit unit_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}
