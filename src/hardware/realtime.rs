//! Real-time priority of the threads that the robot depends on.

use thread_priority::unix::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id, thread_schedule_policy,
};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

/// Priorities of real-time threads, lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// Simulated devices. Real ones have processors of their own.
    Simulator,
    /// The thread that sends the commands.
    ControlLoop,
    /// The thread that supervises the robot.
    Supervisor,
}

/// Gives the calling thread real-time priority (`SCHED_FIFO`) until dropped, if the system permits
/// it: the user needs `rtprio` in `/etc/security/limits.conf`. The thread must not compute for
/// long.
#[derive(Debug)]
pub struct RealTime {
    /// The nice value to restore; none if nothing was changed.
    before: Option<i32>,
}

impl RealTime {
    /// Raises the calling thread's priority. A thread that has real-time priority already keeps it.
    pub fn new(rank: Priority) -> RealTime {
        let normal = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
        if thread_schedule_policy().ok() != Some(normal) {
            return RealTime { before: None };
        }
        let value = match rank {
            // The supervisor interrupts the loop, which interrupts simulated devices.
            Priority::Simulator => 5,
            Priority::ControlLoop => 10,
            Priority::Supervisor => 20,
        };
        let nice = nice();
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let granted = priority(value).is_some_and(|priority| {
            set_thread_priority_and_policy(thread_native_id(), priority, fifo).is_ok()
        });
        RealTime { before: granted.then_some(nice) }
    }

    /// Whether the system granted it.
    pub fn is_granted(&self) -> bool {
        self.before.is_some()
    }
}

impl Drop for RealTime {
    fn drop(&mut self) {
        let Some(nice) = self.before else { return };
        // A granted priority can be given back; at worst the nice value is refused and stays as it
        // was.
        set_nice(nice);
    }
}

/// Makes the calling thread an ordinary one with that nice value, if the system permits it.
fn set_nice(nice: i32) {
    let normal = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    let _ = priority(crate_value_of_nice(nice))
        .map(|priority| set_thread_priority_and_policy(thread_native_id(), priority, normal));
}

fn priority(value: u8) -> Option<ThreadPriority> {
    ThreadPriorityValue::try_from(value).ok().map(ThreadPriority::Crossplatform)
}

/// Nice value of the calling thread; 0 if the system does not provide it.
fn nice() -> i32 {
    // The name in parentheses may contain any character; nice is the seventeenth field after it
    // (proc(5): 19).
    let text = std::fs::read_to_string("/proc/thread-self/stat").unwrap_or_default();
    let fields = text.rsplit_once(')').map_or("", |(_, fields)| fields);
    fields.split_whitespace().nth(16).and_then(|field| field.parse().ok()).unwrap_or(0)
}

/// The crate maps 0 to 99 to nice values 19 to -20 and rounds down.
fn crate_value_of_nice(nice: i32) -> u8 {
    let share = 1.0 - (f64::from(nice.clamp(-20, 19)) + 20.5) / 39.0;
    (99.0 * share).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn real_time_priority_ends_and_leaves_the_thread_as_it_was() {
        std::thread::spawn(|| {
            let before = (thread_schedule_policy().unwrap(), nice());
            let real_time = RealTime::new(Priority::Supervisor);
            let granted = real_time.is_granted();
            assert_eq!(thread_schedule_policy().unwrap() != before.0, granted);
            assert!(
                !RealTime::new(Priority::ControlLoop).is_granted() || !granted,
                "nothing to give back twice"
            );
            drop(real_time);
            assert_eq!((thread_schedule_policy().unwrap(), nice()), before);
        })
        .join()
        .unwrap();
    }

    /// Every thread may increase its nice value.
    #[test]
    fn every_nice_value_is_found_again() {
        std::thread::spawn(|| {
            for wanted in nice()..=19 {
                set_nice(wanted);
                assert_eq!(nice(), wanted);
            }
        })
        .join()
        .unwrap();
    }
}
