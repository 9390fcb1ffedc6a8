//! Clock of a rehearsal: it advances when every registered thread waits for it, so its speed does
//! not depend on the computer.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::hardware::clock::Clock;

/// A clock that jumps to the next awaited time once all registered threads wait.
#[derive(Debug, Default)]
pub struct RehearsalClock {
    state: Mutex<ClockState>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct ClockState {
    now_s: f64,
    joined: usize,
    /// Times that the waiting threads wait for.
    awaited_s: Vec<f64>,
}

impl RehearsalClock {
    /// A thread that panicked while holding the lock has left no inconsistent state.
    fn lock(&self) -> MutexGuard<'_, ClockState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn advance_if_all_wait(&self, state: &mut ClockState) {
        if state.awaited_s.is_empty() || state.awaited_s.len() < state.joined {
            return;
        }
        let next_s = state.awaited_s.iter().copied().fold(f64::INFINITY, f64::min);
        state.now_s = next_s;
        state.awaited_s.retain(|&awaited_s| awaited_s > next_s);
        self.changed.notify_all();
    }
}

impl Clock for RehearsalClock {
    fn now_s(&self) -> f64 {
        self.lock().now_s
    }

    fn sleep_until(&self, time_s: f64) {
        let mut state = self.lock();
        if time_s <= state.now_s {
            return;
        }
        state.awaited_s.push(time_s);
        self.advance_if_all_wait(&mut state);
        while state.now_s < time_s {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn join(&self) {
        self.lock().joined += 1;
    }

    fn leave(&self) {
        let mut state = self.lock();
        state.joined = state.joined.saturating_sub(1);
        self.advance_if_all_wait(&mut state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn time_goes_on_only_when_all_wait_and_in_order() {
        let clock = Arc::new(RehearsalClock::default());
        let view = Arc::new(Mutex::new(Vec::new()));
        (0..3).for_each(|_| clock.join());
        std::thread::scope(|threads| {
            for k in 0..3 {
                let (clock, view) = (Arc::clone(&clock), Arc::clone(&view));
                threads.spawn(move || {
                    for step in 1..=20 {
                        clock.sleep_until(f64::from(step) * (1.0 + 0.1 * f64::from(k)));
                        view.lock().unwrap().push(clock.now_s());
                    }
                    clock.leave();
                });
            }
        });
        let view = view.lock().unwrap();
        assert_eq!(view.len(), 60);
        assert!(view.is_sorted(), "{view:?}");
        assert!((clock.now_s() - 24.0).abs() < 1e-12);
    }
}
