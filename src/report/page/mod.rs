//! Pages: Markdown and LaTeX tables, generated parts between markers, and counts that a page
//! states.

mod counts;
mod document;
pub mod markup;

pub use counts::recounted;
pub use document::{PageError, picture, splice};
