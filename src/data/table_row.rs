//! One description of each result table, from which reading, writing and the documentation of its columns follow.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// A column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableColumn {
    /// Its name in the header.
    pub name: &'static str,
    /// What it holds, as its field is documented.
    pub documentation: &'static str,
}

/// Endings of column names and the units that they stand for; the longest come first.
const UNITS: [(&str, &str); 6] =
    [("_mb_s", "MB/s"), ("_gb", "GB"), ("_rad", "rad"), ("_kg", "kg"), ("_m", "m"), ("_s", "s")];

impl TableColumn {
    /// Its unit, which its name ends in; `–` for a plain number or text.
    pub fn unit(&self) -> &'static str {
        let ends = |(end, _): &&(&str, &str)| self.name.ends_with(end) && !self.name.ends_with("_per_s");
        UNITS.iter().find(ends).map_or("–", |(_, unit)| unit)
    }
}

/// A table of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableDescription {
    /// Name of the row type.
    pub name: &'static str,
    /// Name of its file.
    pub file: &'static str,
    /// What one row is.
    pub row: &'static str,
    /// The columns that tell its rows apart.
    pub key: &'static [&'static str],
    /// All columns in their order.
    pub columns: &'static [TableColumn],
}

impl TableDescription {
    /// Its columns as a Markdown table.
    pub fn markdown(&self) -> String {
        let mut text = String::from("| column | unit | meaning |\n| --- | --- | --- |\n");
        for column in self.columns {
            let words: Vec<&str> = column.documentation.split_whitespace().collect();
            let words = words.join(" ");
            text.push_str(&format!("| `{}` | {} | {} |\n", column.name, column.unit(), words.trim_end_matches('.')));
        }
        text
    }
}

/// A row of a table of results: its fields are the columns.
pub trait TableRow: Serialize + DeserializeOwned + Clone + PartialEq + 'static {
    /// The table.
    const TABLE: TableDescription;
}

/// Declares row types with their tables, and the list of these tables.
macro_rules! table_rows {
    ($(
        $file:literal, key [$($key:ident),*]:
        $(#[doc = $about:literal])+
        pub struct $row:ident {
            $($(#[doc = $documentation:literal])+ $(#[serde($($serde:tt)*)])? pub $field:ident: $type:ty,)*
        }
    )*) => {
        $(
            $(#[doc = $about])+
            #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
            pub struct $row {
                $($(#[doc = $documentation])+ $(#[serde($($serde)*)])? pub $field: $type,)*
            }

            impl $crate::data::TableRow for $row {
                const TABLE: $crate::data::TableDescription = $crate::data::TableDescription {
                    name: stringify!($row),
                    file: $file,
                    row: concat!($($about),+),
                    key: &[$(stringify!($key)),*],
                    columns: &[$($crate::data::TableColumn {
                        name: stringify!($field),
                        documentation: concat!($($documentation),+),
                    }),*],
                };
            }
        )*

        /// The tables of this file.
        pub const TABLES: &[$crate::data::TableDescription] = &[$(<$row as $crate::data::TableRow>::TABLE),*];
    };
}
pub(super) use table_rows;
