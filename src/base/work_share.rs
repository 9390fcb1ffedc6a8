//! How much of a long computation is done, reported to whoever shows it.

use std::cell::RefCell;

/// A listener: share of the work that is done, 0 to 1.
type ShareListener = Box<dyn Fn(f64)>;

thread_local! {
    static LISTENER: RefCell<Option<ShareListener>> = const { RefCell::new(None) };
}

/// Does `work` and reports how much of it is done, as it goes on on this thread, to `listener`.
pub fn with_share_listener<T>(listener: impl Fn(f64) + 'static, work: impl FnOnce() -> T) -> T {
    // Nested calls restore the listener around them.
    let outer = LISTENER.replace(Some(Box::new(listener)));
    let result = work();
    LISTENER.replace(outer);
    result
}

/// So many of `all` equal parts of the work are done.
pub fn report_share(done: usize, all: usize) {
    LISTENER.with_borrow(|listener| {
        listener.iter().for_each(|listener| listener(done as f64 / all.max(1) as f64));
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;

    #[test]
    fn shares_are_reported_to_the_listener_alone() {
        let heard = Rc::new(RefCell::new(Vec::new()));
        let recorded = Rc::clone(&heard);
        let listener = move |share: f64| recorded.borrow_mut().push(share);
        with_share_listener(listener, || (1..=4).for_each(|done| report_share(done, 4)));
        report_share(1, 2);
        assert_eq!(*heard.borrow(), [0.25, 0.5, 0.75, 1.0]);
    }
}
