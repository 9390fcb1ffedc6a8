//! Stages on a Slurm cluster: job arrays of tasks that fill a shared store. What is done is what lies in the store;
//! the queue only tells whether somebody is still at it.

use super::digest::Digest;

mod folder;
mod plan;
mod queue;
mod state;
mod watch;
mod work;

pub use folder::Folder;
pub use plan::{Task, waves};
pub use state::{Standing, cancel, standing};
pub use watch::{Ended, Watch};
pub use work::{Place, Worked, work};

/// The name that all jobs of a campaign have: another store's campaign for the same results has another.
fn job_name(folder: &Folder) -> String {
    let root = std::fs::canonicalize(folder.path()).unwrap_or_else(|_| folder.path().to_owned());
    format!("spinebench-{}", Digest::of(root.as_os_str().as_encoded_bytes()).short())
}
