//! From the search to the answer: final fit, verdict, alternatives, residual map and text.

pub(crate) mod alternatives;
pub(crate) mod assemble;
pub(crate) mod caveats;
pub(crate) mod final_fit;
pub(crate) mod rescore;
pub(crate) mod residual_map;
pub(crate) mod summary_text;
pub(crate) mod verdict;
