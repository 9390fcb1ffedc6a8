//! Controllers beside the paper's, robots that change, populations of robots, and how much data a
//! controller needs.

mod controllers_table;
mod population_table;
mod repair_table;

figures! {
    controllers,
    repair,
    population,
    gp_coverage,
    data_efficiency,
}
