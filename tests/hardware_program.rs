//! The program itself at the bench: in a process of its own, against imitated motors on a pseudo-terminal and an imitated
//! tracker on UDP in another one, or in rehearsals.

#[path = "hardware_program/align.rs"]
mod align;
#[path = "hardware_program/bench.rs"]
mod bench;
#[path = "hardware_program/collect.rs"]
mod collect;
#[path = "hardware_program/doctor.rs"]
mod doctor;
#[path = "hardware_program/ends.rs"]
mod ends;
#[path = "hardware_program/in_process.rs"]
mod in_process;
#[path = "hardware_program/weigh.rs"]
mod weigh;
