//! The steps of a discovery, reported to a listener: it takes minutes.

use std::cell::RefCell;

/// A listener.
type Listener = Box<dyn Fn(&str)>;

thread_local! {
    static LISTENER: RefCell<Option<Listener>> = const { RefCell::new(None) };
}

/// Does `work` and reports its steps, as they begin on this thread, to `listener`.
pub fn with_step_listener<T>(listener: impl Fn(&str) + 'static, work: impl FnOnce() -> T) -> T {
    // Nested calls restore the listener around them.
    let outer = LISTENER.replace(Some(Box::new(listener)));
    let result = work();
    LISTENER.replace(outer);
    result
}

/// A step begins.
pub(crate) fn step(text: &str) {
    LISTENER.with_borrow(|listener| listener.iter().for_each(|listener| listener(text)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;

    #[test]
    fn steps_are_reported_to_the_listener_alone() {
        let heard = Rc::new(RefCell::new(Vec::new()));
        let recorded = Rc::clone(&heard);
        let listener = move |text: &str| recorded.borrow_mut().push(text.to_owned());
        assert_eq!(
            with_step_listener(listener, || {
                step("one");
                3
            }),
            3
        );
        step("two");
        assert_eq!(*heard.borrow(), ["one"]);
    }
}
