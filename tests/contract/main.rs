//! What every part must hold: registries, files, specs, learning, tasks, tables and figures.

#[path = "../../build/dependencies.rs"]
mod dependencies;
#[path = "../../build/import_graph.rs"]
mod import_graph;
#[path = "../support/mod.rs"]
mod support;

mod architecture;
mod drive_effects;
mod effects;
mod gp_noise;
mod import_motive;
mod kernel_expressions;
mod kernels;
mod learn_gp;
mod learn_networks;
mod learn_onnx;
mod model_keys;
mod names;
mod plants;
mod policies;
mod policy_a;
mod policy_c;
mod policy_learned;
mod policy_models;
mod policy_outside;
mod population;
mod recording_files;
mod report_figures;
mod report_golden;
mod report_numbers;
mod report_tables;
mod spec_bad_input;
mod spec_bad_learning;
mod spec_merge_keys;
mod spec_scale;
mod spec_shipped;
mod spec_sweep;
mod store_keys;
mod task_data;
mod task_trials;
