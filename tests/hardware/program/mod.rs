//! The program itself at the bench: in a process of its own, against imitated motors on a
//! pseudo-terminal and an imitated tracker on UDP in another one, or in rehearsals.

mod align;
pub(crate) mod bench;
mod collect;
mod doctor;
mod ends;
mod in_process;
mod weigh;
