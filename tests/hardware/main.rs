//! Drivers, guard and commands against simulated motors and trackers.

#[path = "../support/mod.rs"]
mod support;

mod closed_loop;
mod faults;
mod grbl;
mod limits;
mod natnet_peer;
mod plant;
mod program;
mod table1;
mod tracking;
mod verification;
