//! Stages on a Slurm cluster: job arrays of tasks that fill a shared store. What is done is what lies in the store;
//! the queue only tells whether somebody is still at it.

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

/// The name that all jobs of a campaign have.
fn job_name(id: &str) -> String {
    format!("spinebench-{id}")
}
