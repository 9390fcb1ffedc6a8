//! One description of each result table, from which reading, writing and the documentation of its
//! columns follow.

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
        let ends =
            |(end, _): &&(&str, &str)| self.name.ends_with(end) && !self.name.ends_with("_per_s");
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
    pub key: &'static [&'static [&'static str]],
    /// All columns in their order: those of the row, and of the structs within it.
    pub columns: &'static [&'static [TableColumn]],
}

impl TableDescription {
    /// All columns in their order.
    pub fn columns(&self) -> impl Iterator<Item = &'static TableColumn> {
        self.columns.iter().copied().flatten()
    }

    /// The names of the columns that tell its rows apart.
    pub fn key(&self) -> impl Iterator<Item = &'static str> {
        self.key.iter().copied().flatten().copied()
    }

    /// Its columns as a Markdown table.
    pub fn markdown(&self) -> String {
        let mut text = String::from("| column | unit | meaning |\n| --- | --- | --- |\n");
        for column in self.columns() {
            let words: Vec<&str> = column.documentation.split_whitespace().collect();
            let words = words.join(" ");
            text.push_str(&format!(
                "| `{}` | {} | {} |\n",
                column.name,
                column.unit(),
                words.trim_end_matches('.')
            ));
        }
        text
    }
}

/// A row of a table of results: its fields are the columns.
pub trait TableRow: Serialize + DeserializeOwned + Clone + PartialEq + 'static {
    /// The table.
    const TABLE: TableDescription;

    /// Whether the row stands for something that failed.
    fn failed(&self) -> bool {
        false
    }
}

/// A struct whose fields are columns.
pub trait TableColumns {
    /// The columns in the order of the fields: those of the struct, and of a struct within it.
    const COLUMNS: &'static [&'static [TableColumn]];
}

/// Declares structs whose fields are columns. The columns of a `flat` field, a struct itself, stand
/// in its place.
macro_rules! columns {
    ($(
        $(#[doc = $about:literal])+
        $(#[derive($($derive:ident),+)])?
        pub struct $name:ident {
            $($(#[doc = $doc:literal])+ $(#[serde($($serde:tt)*)])? pub $field:ident: $type:ty,)*
            $(
                flat $flat:ident: $flat_type:ident,
                $($(#[doc = $after_doc:literal])+ pub $after:ident: $after_type:ty,)*
            )?
        }
    )*) => {$(
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize $($(, $derive)+)?)]
        pub struct $name {
            $($(#[doc = $doc])+ $(#[serde($($serde)*)])? pub $field: $type,)*
            $(
                #[doc = concat!("Columns of [`", stringify!($flat_type), "`].")]
                #[serde(rename = "+")]
                pub $flat: $flat_type,
                $($(#[doc = $after_doc])+ pub $after: $after_type,)*
            )?
        }

        impl $crate::data::TableColumns for $name {
            const COLUMNS: &'static [&'static [$crate::data::TableColumn]] = &[
                &[$($crate::data::TableColumn { name: stringify!($field), documentation: concat!($($doc),+) }),*],
                $(
                    <$flat_type as $crate::data::TableColumns>::COLUMNS[0],
                    &[$($crate::data::TableColumn {
                        name: stringify!($after),
                        documentation: concat!($($after_doc),+),
                    }),*],
                )?
            ];
        }
    )*};
}
pub(crate) use columns;

/// Declares row types with their tables, and the list of these tables; `failed` tells the rows that
/// stand for a failure.
macro_rules! table_rows {
    ($(
        $file:literal, key [$($key:ident),*] $(, failed [$($failed:tt)+])?:
        $(#[doc = $about:literal])+
        pub struct $row:ident { $($fields:tt)* }
    )*) => {
        $(
            $crate::data::columns! {
                $(#[doc = $about])+
                pub struct $row { $($fields)* }
            }

            impl $crate::data::TableRow for $row {
                const TABLE: $crate::data::TableDescription = $crate::data::TableDescription {
                    name: stringify!($row),
                    file: $file,
                    row: concat!($($about),+),
                    key: &[&[$(stringify!($key)),*]],
                    columns: <$row as $crate::data::TableColumns>::COLUMNS,
                };

                $(fn failed(&self) -> bool {
                    let failed: fn(&Self) -> bool = $($failed)+;
                    failed(self)
                })?
            }
        )*

        /// The tables of this file.
        pub const TABLES: &[$crate::data::TableDescription] = &[$(<$row as $crate::data::TableRow>::TABLE),*];
    };
}
pub(crate) use table_rows;
