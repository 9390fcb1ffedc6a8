//! Pages: Markdown and LaTeX tables, generated parts between markers, pictures with captions, and
//! counts that a page states.

mod counts;
mod document;
mod gallery;
mod keys;
pub mod markup;

pub use counts::recounted;
pub use document::{PageError, splice};
pub use gallery::{captioned_picture, gallery};
pub use keys::keys_table;
