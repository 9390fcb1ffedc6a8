//! The program as its users start it.

#[path = "../support/mod.rs"]
mod support;

mod bags;
mod benchmark;
mod calibrate;
mod discover;
mod editors;
mod examples;
mod extending;
mod first_hour;
mod import_csv;
mod import_exports;
mod import_layouts;
mod league;
mod outside_policies;
mod page;
mod real;
mod run;
mod simulate;
mod slurm;
mod survives;
mod view;
