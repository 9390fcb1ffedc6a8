//! The rows of result tables, as they are published.

pub mod cell;
pub mod experiment;
pub mod league;
pub mod learning_peers;
pub mod population;
pub mod repairs;
pub mod responses;

use crate::data::{TableDescription, findings};

/// Every table of results.
pub fn table_descriptions() -> impl Iterator<Item = &'static TableDescription> {
    let tables =
        experiment::CELL_TABLES.iter().chain(experiment::TABLES).chain(responses::CELL_TABLES);
    let tables = tables.chain(responses::TABLES).chain(repairs::TABLES).chain(population::TABLES);
    tables.chain(findings::TABLES).chain(learning_peers::TABLES).chain(league::TABLES)
}
