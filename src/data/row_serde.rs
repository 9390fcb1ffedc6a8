//! Conversion between plain structs and table rows through serde: field names are column names, in
//! declaration order.

use std::cell::RefCell;

use serde::de::value::MapDeserializer;
use serde::de::{self, DeserializeOwned, IntoDeserializer};
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
    #[error("a row may contain only numbers, text and flags: {0}")]
    NotFlat(String),
    #[error("no column `{0}`")]
    MissingColumn(String),
    #[error("unknown column `{0}`")]
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

/// Beginning of the serde name of a field whose own fields stand among the columns: a struct of
/// several columns.
pub(crate) const FLAT: &str = "+";

/// A row's cells, name and value, in declaration order.
type Fields = Vec<(&'static str, FieldValue)>;

/// The fields of a row, those of structs within it among them.
pub(crate) fn fields_of<R: Serialize>(row: &R) -> Result<Fields, RowError> {
    row.serialize(FieldSerializer { name: FLAT })
}

fn not_flat<T>(what: &str) -> Result<T, RowError> {
    Err(RowError::NotFlat(what.to_owned()))
}

/// Serialises the field of this name; a whole row is called [`FLAT`].
struct FieldSerializer {
    name: &'static str,
}

impl FieldSerializer {
    fn cell(self, value: FieldValue) -> Result<Fields, RowError> {
        if self.name.starts_with(FLAT) {
            not_flat("a value without a column")
        } else {
            Ok(vec![(self.name, value)])
        }
    }
}

/// The fields of a struct met so far.
struct StructFields(Fields);

impl ser::SerializeStruct for StructFields {
    type Ok = Fields;
    type Error = RowError;

    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        key: &'static str,
        value: &T,
    ) -> Result<(), RowError> {
        self.0.extend(value.serialize(FieldSerializer { name: key })?);
        Ok(())
    }

    fn end(self) -> Result<Fields, RowError> {
        Ok(self.0)
    }
}

macro_rules! serialize_cells {
    ($($name:ident: $kind:ty => $cell:ident),* $(,)?) => {
        $(fn $name(self, value: $kind) -> Result<Fields, RowError> { self.cell(FieldValue::$cell(value.into())) })*
    };
}

macro_rules! refuse_kinds {
    ($($name:ident($($kind:ty),*) -> $ok:ty, $what:literal;)*) => {
        $(fn $name(self, $(_: $kind),*) -> Result<$ok, RowError> { not_flat($what) })*
    };
}

impl Serializer for FieldSerializer {
    type Ok = Fields;
    type Error = RowError;
    type SerializeSeq = Impossible<Fields, RowError>;
    type SerializeTuple = Impossible<Fields, RowError>;
    type SerializeTupleStruct = Impossible<Fields, RowError>;
    type SerializeTupleVariant = Impossible<Fields, RowError>;
    type SerializeMap = Impossible<Fields, RowError>;
    type SerializeStruct = StructFields;
    type SerializeStructVariant = Impossible<Fields, RowError>;

    serialize_cells!(serialize_bool: bool => Flag, serialize_i8: i8 => Integer, serialize_i16: i16 => Integer,
        serialize_i32: i32 => Integer, serialize_i64: i64 => Integer, serialize_u8: u8 => Unsigned,
        serialize_u16: u16 => Unsigned, serialize_u32: u32 => Unsigned, serialize_u64: u64 => Unsigned,
        serialize_f32: f32 => Number, serialize_f64: f64 => Number, serialize_char: char => Text,
        serialize_str: &str => Text);
    refuse_kinds! {
        serialize_bytes(&[u8]) -> Fields, "bytes";
        serialize_unit_struct(&'static str) -> Fields, "a struct without fields";
        serialize_seq(Option<usize>) -> Self::SerializeSeq, "a sequence";
        serialize_tuple(usize) -> Self::SerializeTuple, "a tuple";
        serialize_tuple_struct(&'static str, usize) -> Self::SerializeTupleStruct, "a tuple";
        serialize_tuple_variant(&'static str, u32, &'static str, usize) -> Self::SerializeTupleVariant, "a tuple";
        serialize_map(Option<usize>) -> Self::SerializeMap, "a map";
        serialize_struct_variant(&'static str, u32, &'static str, usize) -> Self::SerializeStructVariant, "a struct";
    }

    fn serialize_none(self) -> Result<Fields, RowError> {
        self.cell(FieldValue::Missing)
    }
    fn serialize_unit(self) -> Result<Fields, RowError> {
        self.cell(FieldValue::Missing)
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<Fields, RowError> {
        value.serialize(self)
    }
    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
    ) -> Result<Fields, RowError> {
        self.cell(FieldValue::Text(variant.to_owned()))
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<Fields, RowError> {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<Fields, RowError> {
        not_flat(name)
    }
    fn serialize_struct(self, name: &'static str, _: usize) -> Result<StructFields, RowError> {
        if self.name.starts_with(FLAT) { Ok(StructFields(Vec::new())) } else { not_flat(name) }
    }
}

/// A row as text cells under their column names, to be read as a struct.
#[derive(Clone, Copy)]
pub(crate) struct TextRow<'a> {
    /// Column names.
    pub(crate) names: &'a [&'a str],
    /// One cell a column.
    pub(crate) cells: &'a [&'a str],
}

impl TextRow<'_> {
    /// Reads the row; each of its columns must be a field.
    pub(crate) fn read<R: DeserializeOwned>(self) -> Result<R, RowError> {
        let fields = RefCell::new(Vec::new());
        let row = R::deserialize(FieldReader { row: self, fields: &fields, name: FLAT, text: "" })?;
        match self.names.iter().find(|name| !fields.borrow().contains(*name)) {
            Some(name) => Err(RowError::UnknownColumn((*name).to_owned())),
            None => Ok(row),
        }
    }
}

/// Reads the field of this name from its cell, or one that starts with [`FLAT`] from the columns
/// that are its fields.
#[derive(Clone, Copy)]
struct FieldReader<'a> {
    row: TextRow<'a>,
    /// Fields of all structs met so far.
    fields: &'a RefCell<Vec<&'static str>>,
    name: &'a str,
    text: &'a str,
}

impl FieldReader<'_> {
    fn parse<T: std::str::FromStr>(&self, expected: &str) -> Result<T, RowError> {
        let wrong =
            |_| RowError::Value { column: self.name.to_owned(), expected: expected.to_owned() };
        self.text.parse().map_err(wrong)
    }
}

impl IntoDeserializer<'_, RowError> for FieldReader<'_> {
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

impl<'de> Deserializer<'de> for FieldReader<'_> {
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
        if self.text.is_empty() {
            visitor.visit_f64(f64::NAN)
        } else {
            visitor.visit_f64(self.parse("a number")?)
        }
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

    fn deserialize_struct<V: de::Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, RowError> {
        if !self.name.starts_with(FLAT) {
            return not_flat("a field of several columns");
        }
        self.fields.borrow_mut().extend(fields);
        let cells =
            self.row.names.iter().zip(self.row.cells).filter(|(name, _)| fields.contains(name));
        let cells = cells.map(|(&name, &text)| (name, FieldReader { name, text, ..self }));
        let flat = fields.iter().filter(|field| field.starts_with(FLAT));
        visitor.visit_map(MapDeserializer::new(
            cells.chain(flat.map(|&name| (name, FieldReader { name, ..self }))),
        ))
    }

    forward_to_deserialize_any! {
        i128 u128 str string bytes byte_buf unit unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}
