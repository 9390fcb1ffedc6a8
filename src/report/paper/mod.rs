//! The paper's Table I, Figs 5, 6 and 8, its claims, and the values that it prints.

pub(super) mod claim_lines;
pub mod printed;
pub(super) mod summarise;

figures! { table1, fig5, fig6, fig8, claims }
